//! One landing in its lane: what is not computed side by side.

use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_lander::guidance::GuidanceState;
use touchdown_lander::space_controller::SpaceControllerState;

use super::{Batch, KNOT_STEPS};
use crate::STEP_S;
use crate::air::turbulence::RotorTurbulence;
use crate::air::wind::Wind;
use crate::body::cascade::AttitudeSetpoint;
use crate::body::contact::Foot;
use crate::body::rigid::{Disturbance, RigidState, RigidVehicle};
use crate::deck::rigid::{DeckCoordinates, RigidDeck};
use crate::deck::spline::piece;
use crate::error::SimError;
use crate::landing::space::outcome::{SpaceLanding, SpaceOutcome, Touch};
use crate::landing::space::touchdown::{DeckState, TouchdownJudge};
use crate::landing::space::trial::{TrialAir, TrialDraw, hover};

/// State of the simulated controller.
pub(super) type ControllerMemory =
    SpaceControllerState<f64, <Guarded<f64> as GroundEffect<f64>>::State>;

/// A flight with its state, the setpoint that it hovers at, and its air.
pub(super) type Departure = (LaneFlight, RigidState, AttitudeSetpoint, Disturbance);

/// A landing in a lane.
pub(super) struct LaneFlight {
    trial: u64,
    /// Step of the engine at which it began.
    start: u64,
    pub(super) vehicle: RigidVehicle,
    deck: RigidDeck,
    shift_s: f64,
    knots: u64,
    knot: DeckCoordinates,
    pub(super) wind: Wind,
    pub(super) turbulence: Option<RotorTurbulence>,
    /// None before its first step.
    pub(super) controller: Option<ControllerMemory>,
    pub(super) guidance: GuidanceState<f64>,
    throttle: f64,
    touching: TouchdownJudge,
    touch: Option<Touch>,
    stopped: Option<u64>,
    pub(super) path_m: f64,
}

impl LaneFlight {
    /// A trial that begins at a step of the engine: the flight, its state, and the setpoint
    /// that it hovers at.
    pub(super) fn new(
        batch: &Batch,
        trial: u64,
        seed: u64,
        start: u64,
    ) -> Result<Departure, SimError> {
        let scenario = &batch.lander.scenario;
        let draw = TrialDraw::new(scenario, trial, seed);
        let vehicle = draw.vehicle(&batch.lander.vehicle)?;
        let (deck, shift_s) = batch.deck(trial, seed, draw.phase)?;
        let knot = deck.coordinates(shift_s);
        let pose = knot.pose();
        let (state, throttle) = draw.start(scenario, &vehicle, &pose);
        let TrialAir {
            wind,
            turbulence,
            disturbance,
        } = TrialAir::new(scenario, &vehicle, &state, &pose, trial, seed)?;
        let hover = hover(&state);
        let flight = Self {
            trial,
            start,
            vehicle,
            deck,
            shift_s,
            knots: 0,
            knot,
            wind,
            turbulence,
            controller: None,
            guidance: batch.guidance.initial(),
            throttle,
            touching: TouchdownJudge::default(),
            touch: None,
            stopped: None,
            path_m: 0.0,
        };
        Ok((flight, state, hover, disturbance))
    }

    /// The throttle of the hover at the start.
    pub(super) fn throttle(&self) -> f64 {
        self.throttle
    }

    /// The deck up to its next knot.
    pub(super) fn next_piece(&mut self) -> [[f64; 5]; 6] {
        let knot_s = KNOT_STEPS as f64 * STEP_S;
        self.knots += 1;
        let next = match &self.deck {
            RigidDeck::Still => self.knot,
            deck => deck.coordinates(self.shift_s + knot_s * self.knots as f64),
        };
        let piece = piece(knot_s, &self.knot, &next);
        self.knot = next;
        piece
    }

    /// Moves the grid of the deck's knots, so that the flight begins so many steps after a knot.
    pub(super) fn begin_after_knot(&mut self, steps: u64) {
        self.shift_s -= steps as f64 * STEP_S;
        self.knot = self.deck.coordinates(self.shift_s);
    }

    /// Whether the rotors have been stopped.
    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    /// Judges the state after a step of the engine; near the deck only `standing` is
    /// needed.
    pub(super) fn judge(
        &mut self,
        batch: &Batch,
        step: u64,
        standing: Option<&(DeckState, [Foot; 4])>,
    ) -> Option<SpaceOutcome> {
        let since = step - self.start;
        if let Some(standing) = standing
            && let Some(outcome) = self.near(batch, since, standing)
        {
            return Some(outcome);
        }
        let settled = self
            .stopped
            .and_then(|stopped| self.touching.settled(1, since - stopped, batch.steps.watch));
        if settled.is_some() {
            return settled;
        }
        (since >= batch.steps.timeout).then_some(SpaceOutcome::TimedOut)
    }

    fn near(
        &mut self,
        batch: &Batch,
        since: u64,
        (now, feet): &(DeckState, [Foot; 4]),
    ) -> Option<SpaceOutcome> {
        let legs = &batch.lander.scenario.legs;
        let time_s = since as f64 * STEP_S;
        self.touching.log.add(time_s, feet, now.tilt_rad, legs);
        if self.touch.is_none() && self.touching.is_near(&batch.lander, now.place_m) {
            self.touch = Some(now.touch(time_s, time_s, self.path_m));
            self.stopped = Some(since);
        }
        self.touching.judge(&batch.lander.scenario, now)
    }

    /// The landing, at its end.
    pub(super) fn landing(self, step: u64, outcome: SpaceOutcome) -> SpaceLanding {
        let steps = step - self.start;
        let mut landing = SpaceLanding {
            outcome,
            touch: self.touch,
            before_descent_s: Some(0.0),
            descents: 1,
            end_s: steps as f64 * STEP_S,
            steps,
            ..SpaceLanding::begun(self.trial)
        };
        self.touching.enter(&mut landing);
        landing
    }
}
