//! One landing in its lane: what is not computed side by side.

use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_flight::guidance::GuidanceState;
use touchdown_flight::pilot::PilotState;

use super::{Batch, KNOT_STEPS};
use crate::STEP_S;
use crate::cascade::AttitudeSetpoint;
use crate::contact::{ContactLog, Foot};
use crate::deck::rigid::{DeckCoordinates, RigidDeck};
use crate::deck::spline::piece;
use crate::error::SimError;
use crate::noise::{Purpose, Stream};
use crate::rigid::{Disturbance, RigidState, RigidVehicle};
use crate::rotors::RotorTurbulence;
use crate::space::drawn::Drawn;
use crate::space::outcome::{CrashCause, Impact, SpaceLanding, SpaceOutcome, Touch};
use crate::wind::Wind;

/// State of the pilot that is simulated.
pub(super) type PilotMemory = PilotState<f64, <Guarded<f64> as GroundEffect<f64>>::State>;

/// A landing in a lane.
pub(super) struct Seat {
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
    pub(super) pilot: Option<PilotMemory>,
    pub(super) guidance: GuidanceState<f64>,
    throttle: f64,
    log: ContactLog,
    touch: Option<Touch>,
    was_down: bool,
    impact: Option<Impact>,
    stopped: Option<u64>,
    pub(super) path_m: f64,
}

/// How a vehicle stands to the deck at a step.
pub(super) struct Standing {
    /// Place relative to the deck's centre, along its axes, m.
    pub(super) place_m: [f64; 3],
    /// Velocity relative to the deck after the step and before it, along its axes, m/s.
    pub(super) velocity_mps: [f64; 3],
    pub(super) before_mps: f64,
    /// Tilt from the deck's normal, rad.
    pub(super) tilt_rad: f64,
    pub(super) feet: [Foot; 4],
}

impl Seat {
    /// A trial that begins at a step of the engine: the seat, its state, and the setpoint
    /// that it hovers at.
    pub(super) fn new(
        batch: &Batch,
        trial: u64,
        seed: u64,
        start: u64,
    ) -> Result<(Self, RigidState, AttitudeSetpoint, Disturbance), SimError> {
        let scenario = &batch.lander.scenario;
        let drawn = Drawn::new(scenario, trial, seed);
        let vehicle = drawn.vehicle(&batch.lander.vehicle)?;
        let (deck, shift_s) = batch.deck(trial, seed, drawn.phase)?;
        let knot = deck.coordinates(shift_s);
        let pose = knot.pose();
        let (state, throttle) = drawn.start(scenario, &vehicle, &pose);
        let turbulence = scenario.turbulence.then(|| {
            let stream = Stream::new(seed, trial, Purpose::Turbulence);
            let still = vehicle.loads(&state, &pose, &Disturbance::default());
            let roots = &state.rotors.root_thrust;
            let sd_n = vehicle.rotors().turbulence_sd_n(roots, &still.target);
            let correlation_s = scenario.plant.turbulence_correlation_s;
            RotorTurbulence::new(stream, correlation_s, STEP_S, sd_n)
        });
        let wind = Wind::new(&scenario.wind, STEP_S, seed, trial)?;
        let disturbance = Disturbance {
            wind_mps: wind.velocity_mps(),
            turbulence_n: turbulence
                .as_ref()
                .map_or([0.0; 4], RotorTurbulence::values_n),
        };
        let hover = AttitudeSetpoint {
            thrust_n: 0.25 * state.rotors.root_thrust.iter().map(|x| x * x).sum::<f64>(),
            attitude: state.attitude,
            yaw_rate: 0.0,
        };
        let seat = Self {
            trial,
            start,
            vehicle,
            deck,
            shift_s,
            knots: 0,
            knot,
            wind,
            turbulence,
            pilot: None,
            guidance: batch.guidance.initial(),
            throttle,
            log: ContactLog::default(),
            touch: None,
            was_down: false,
            impact: None,
            stopped: None,
            path_m: 0.0,
        };
        Ok((seat, state, hover, disturbance))
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
        standing: Option<&Standing>,
    ) -> Option<SpaceOutcome> {
        let since = step - self.start;
        if let Some(standing) = standing
            && let Some(outcome) = self.near(batch, since, standing)
        {
            return Some(outcome);
        }
        if let Some(stopped) = self.stopped
            && since - stopped >= batch.steps.watch
        {
            return Some(if self.log.feet_down >= 3 {
                SpaceOutcome::Landed { attempts: 1 }
            } else {
                SpaceOutcome::Crashed {
                    cause: CrashCause::StoppedInAir,
                }
            });
        }
        (since >= batch.steps.timeout).then_some(SpaceOutcome::TimedOut)
    }

    fn near(&mut self, batch: &Batch, since: u64, now: &Standing) -> Option<SpaceOutcome> {
        let scenario = &batch.lander.scenario;
        let crash = &scenario.crash;
        let crashed = |cause| Some(SpaceOutcome::Crashed { cause });
        let time_s = since as f64 * STEP_S;
        let tilt_rad = now.tilt_rad;
        let legs = &scenario.legs;
        self.log.add(time_s, &now.feet, tilt_rad, legs);
        let down = self.log.feet_down > 0;
        if self.touch.is_none() && (down || batch.lander.has_come_down(now.place_m)) {
            let [x, y, _] = now.place_m;
            let [u, v, _] = now.velocity_mps;
            self.touch = Some(Touch {
                time_s,
                t_l_s: time_s,
                v_l_mps: now.before_mps.abs(),
                s_l_m: self.path_m,
                tilt_rad,
                lateral_m: x.hypot(y),
                lateral_mps: u.hypot(v),
            });
            self.stopped = Some(since);
        }
        if down {
            // As fast as before the legs took up any of it.
            let fresh = if self.was_down { 0.0 } else { 1.0 };
            let so_far = self.impact.unwrap_or(Impact {
                speed_mps: 0.0,
                tilt_rad: 0.0,
            });
            self.impact = Some(Impact {
                speed_mps: so_far.speed_mps.max(-fresh * now.before_mps),
                tilt_rad: so_far.tilt_rad.max(tilt_rad),
            });
        }
        self.was_down = down;
        if down && -now.before_mps > crash.speed_mps {
            return crashed(CrashCause::Speed);
        }
        if self.log.tipped_s.is_some() {
            return Some(SpaceOutcome::TippedOver);
        }
        if down && tilt_rad > crash.tilt_rad {
            return crashed(CrashCause::Tilt);
        }
        if self.log.fell_s.is_some() {
            return crashed(CrashCause::FellOff);
        }
        if now.place_m[2] < scenario.landed_height_m - 0.15 {
            return crashed(CrashCause::Missed);
        }
        None
    }

    /// The landing, at its end.
    pub(super) fn landing(self, step: u64, outcome: SpaceOutcome) -> SpaceLanding {
        let steps = step - self.start;
        SpaceLanding {
            trial_index: self.trial,
            outcome,
            touch: self.touch,
            before_descent_s: Some(0.0),
            waited_s: 0.0,
            descents: 1,
            aborts: Vec::new(),
            bounces: self.log.bounces,
            slide_m: self.log.slide_m,
            greatest_foot_n: self.log.greatest_normal_n,
            impact: self.impact,
            estimated_latency_s: 0.0,
            end_s: steps as f64 * STEP_S,
            steps,
            trace: None,
        }
    }
}
