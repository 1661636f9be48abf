//! The step of all lanes.

mod judge;
mod outside;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::ops::Range;

use super::air::{Air, BLOCK_STEPS};
use super::lane_flight::{Departure, LaneFlight};
use super::lane_state::{LaneState, ask_for};
use super::{Batch, KNOT_STEPS};
use crate::STEP_S;
use crate::body::cascade::{CascadeMemory, Setpoint};
use crate::body::contact::Foothold;
use crate::body::rigid::{
    Disturbance, Input, LegContact, MotionState, RigidState, SIZE, VehicleVariation,
};
use crate::body::rotors::Shares;
use crate::deck::rigid::{DeckCoordinates, DeckPose};
use crate::deck::spline::on_piece;
use crate::error::SimError;
use crate::landing::space::outcome::SpaceLanding;
use crate::number::vector::axes_of;
use crate::number::{MOST_LANES, Number};

/// Steps for which half of the SIMD lanes wait for the others. The value affects only
/// computing time: a lane computes the same landing in any company.
const WAIT_STEPS: u64 = 400;

/// Landings in the lanes of a number.
pub(super) struct Engine<N: Number> {
    waiting: Range<u64>,
    seed: u64,
    step: u64,
    /// When a lane was last left.
    left: u64,
    flights: Vec<Option<LaneFlight>>,
    landed: Vec<SpaceLanding>,
    /// The lanes that these have left.
    vacated: Vec<usize>,
    kind: VehicleVariation<N>,
    state: MotionState<N>,
    foothold: Foothold<N>,
    input: Input<N>,
    acceleration_mps2: [N; 3],
    piece: [[N; 5]; 6],
    pose: DeckPose<N>,
    air: Air,
    /// Velocity along the deck's normal relative to it, m/s.
    sinking_mps: N,
    /// Way along the deck's normal up to the first touch, m.
    path_m: N,
    wanted: Setpoint<N>,
    coming: VecDeque<(u64, Setpoint<N>)>,
    memory: CascadeMemory<N>,
    /// 1 in lanes whose control has not stepped, whose rotors have stopped.
    fresh: N,
    stopped: N,
    /// 1 in lanes that are watched after their touch.
    watched: N,
    throttle: [N; 4],
}

impl<N: Number> Engine<N> {
    #[inline(always)]
    pub(super) fn new(batch: &Batch, trials: Range<u64>, seed: u64, like: N) -> Self {
        let (zero, one) = (like.splat(0.0), like.splat(1.0));
        let mut start = [zero; SIZE];
        start[15] = one;
        let none = zero.below(zero);
        let still = DeckCoordinates {
            value: [zero; 5],
            rate: [zero; 5],
            acceleration: [zero; 5],
        };
        let count = trials.end.saturating_sub(trials.start) as usize;
        Self {
            waiting: trials,
            seed,
            step: 0,
            left: 0,
            flights: (0..N::COUNT).map(|_| None).collect(),
            landed: Vec::with_capacity(count),
            vacated: Vec::with_capacity(count),
            kind: VehicleVariation {
                thrust_scale_error: [zero; 4],
                ground_effect_scale: one,
            },
            state: MotionState::from_array(&start),
            foothold: Foothold {
                sticks: [none; 4],
                stuck_m: [[zero; 2]; 4],
            },
            input: Input {
                throttle: [zero; 4],
                wind_mps: [zero; 3],
                turbulence_n: [zero; 4],
                shares: Shares {
                    plate: [one; 4],
                    upwash: [zero; 4],
                },
            },
            acceleration_mps2: [zero; 3],
            piece: [[zero; 5]; 6],
            pose: still.pose(),
            air: Air::new(batch),
            sinking_mps: zero,
            path_m: zero,
            wanted: Setpoint {
                thrust_n: zero,
                attitude: [one, zero, zero, zero],
                yaw_rate: zero,
                body_rates: None,
            },
            coming: VecDeque::new(),
            memory: CascadeMemory::none(zero),
            fresh: zero,
            stopped: one,
            watched: zero,
            throttle: [zero; 4],
        }
    }

    /// Flies all trials.
    #[inline(always)]
    pub(super) fn run(mut self, batch: &Batch) -> Result<Vec<SpaceLanding>, SimError> {
        while self.advance(batch)? {}
        self.landed.sort_by_key(|landing| landing.trial_index);
        Ok(self.landed)
    }

    /// A step of all; false when none is left.
    #[inline(always)]
    fn advance(&mut self, batch: &Batch) -> Result<bool, SimError> {
        let within = self.step % KNOT_STEPS;
        if within == 0 {
            self.flight(batch)?;
            if self.flights.iter().all(Option::is_none) {
                return Ok(false);
            }
            self.knot();
        }
        if self.step.is_multiple_of(batch.steps.control) {
            let wanted = self.ask(batch, within);
            self.command(batch, wanted);
        }
        self.act(batch, within);
        Ok(true)
    }

    /// Setpoints set out; the attitude control has them after the command's delay.
    fn command(&mut self, batch: &Batch, wanted: Setpoint<N>) {
        let at = self.step + batch.steps.command_delay;
        self.coming.push_back((at, wanted));
    }

    /// Air, attitude control and motion of a step.
    #[inline(always)]
    fn act(&mut self, batch: &Batch, within: u64) {
        if within.is_multiple_of(BLOCK_STEPS) {
            self.air.draw(&mut self.flights);
        }
        while let Some((_, wanted)) = self.coming.front().filter(|(at, _)| *at <= self.step) {
            self.wanted = *wanted;
            self.coming.pop_front();
        }
        if self.step.is_multiple_of(batch.steps.cascade) {
            let first = self.fresh.above(0.0);
            let (q, rates) = (self.state.attitude, self.state.rates);
            let cascade = &batch.lander.cascade;
            let given = cascade.control(&mut self.memory, first, q, rates, &self.wanted);
            self.throttle = given.throttle;
            self.fresh = self.fresh.splat(0.0);
        }
        self.fly(batch, within);
    }

    /// Trials take the empty flights.
    ///
    /// Lanes that touch at the same time share the work of the legs: trials begin together, when
    /// all have landed or half of them a while ago.
    fn flight(&mut self, batch: &Batch) -> Result<(), SimError> {
        let empty = self
            .flights
            .iter()
            .filter(|flight| flight.is_none())
            .count();
        let late = self.step >= self.left + WAIT_STEPS;
        if !(empty == N::COUNT || late && 2 * empty >= N::COUNT) {
            return Ok(());
        }
        for lane in 0..N::COUNT {
            if self.flights[lane].is_some() {
                continue;
            }
            let Some(trial) = self.waiting.next() else {
                continue;
            };
            let flight = LaneFlight::new(batch, trial, self.seed, self.step)?;
            self.take(lane, flight);
        }
        Ok(())
    }

    /// A lane takes a flight.
    fn take(&mut self, lane: usize, (flight, state, hover, disturbance): Departure) {
        let kind = flight.vehicle.kind();
        for i in 0..4 {
            let error = &mut self.kind.thrust_scale_error[i];
            *error = error.with(lane, kind.thrust_scale_error[i]);
        }
        let scale = &mut self.kind.ground_effect_scale;
        *scale = scale.with(lane, kind.ground_effect_scale);
        self.put(lane, &state);
        self.disturb(lane, &disturbance);
        for k in 0..3 {
            self.acceleration_mps2[k] = self.acceleration_mps2[k].with(lane, 0.0);
        }
        for wanted in std::iter::once(&mut self.wanted)
            .chain(self.coming.iter_mut().map(|(_, wanted)| wanted))
        {
            ask_for(wanted, lane, &hover);
        }
        let here = self.fresh.splat(0.0).with(lane, 1.0);
        let taken = here.above(0.0);
        self.memory = self.memory.without(taken);
        for i in 0..4 {
            self.foothold.sticks[i] = self.foothold.sticks[i] & !taken;
        }
        self.fresh = self.fresh.with(lane, 1.0);
        self.stopped = self.stopped.with(lane, 0.0);
        self.sinking_mps = self.sinking_mps.with(lane, 0.0);
        self.path_m = self.path_m.with(lane, 0.0);
        self.flights[lane] = Some(flight);
    }

    /// The decks up to their next knots.
    fn knot(&mut self) {
        let mut idle = Vec::new();
        for (lane, flight) in self.flights.iter_mut().enumerate() {
            let Some(flight) = flight else {
                // Out of the others' way: above the deck, from rest again at every knot.
                idle.push(lane);
                continue;
            };
            let piece = flight.next_piece();
            for (to, from) in self.piece.iter_mut().flatten().zip(piece.iter().flatten()) {
                *to = to.with(lane, *from);
            }
        }
        self.pose = on_piece(&self.piece, 0.0).pose();
        for lane in idle {
            let mut state = RigidState::default();
            state.position_m[2] = self.pose.origin_m[2].get(lane) + 1.0;
            self.put(lane, &state);
        }
    }

    /// The setpoints of the controllers in this step.
    fn ask(&mut self, batch: &Batch, within: u64) -> Setpoint<N> {
        let mut wanted = self
            .coming
            .back()
            .map_or(self.wanted, |(_, wanted)| *wanted);
        let deck = on_piece(&self.piece, within as f64 * STEP_S).pose();
        let seen = LaneState::of_all(&self.state, &deck, self.acceleration_mps2);
        let (mut thrust_n, mut attitude) = ([0.0; MOST_LANES], [[0.0; MOST_LANES]; 4]);
        for lane in 0..N::COUNT {
            thrust_n[lane] = wanted.thrust_n.get(lane);
            for k in 0..4 {
                attitude[k][lane] = wanted.attitude[k].get(lane);
            }
            let Some(flight) = self.flights[lane]
                .as_mut()
                .filter(|flight| !flight.is_stopped())
            else {
                continue;
            };
            let asked = batch.command(flight, &seen.of(lane));
            thrust_n[lane] = asked.thrust_n;
            for k in 0..4 {
                attitude[k][lane] = asked.attitude[k];
            }
        }
        wanted.thrust_n = wanted.thrust_n.of_lanes(&thrust_n);
        for k in 0..4 {
            wanted.attitude[k] = wanted.attitude[k].of_lanes(&attitude[k]);
        }
        wanted
    }

    /// The motion of all over a step.
    #[inline(always)]
    fn fly(&mut self, batch: &Batch, within: u64) {
        let vehicle = &batch.lander.vehicle;
        let zero = self.stopped.splat(0.0);
        let t = within as f64 * STEP_S;
        let held_steps = batch.steps.held;
        if within.is_multiple_of(held_steps) {
            let middle_s = 0.5 * STEP_S * held_steps as f64;
            let pose = on_piece(&self.piece, t + middle_s).pose();
            self.input.shares = vehicle.shares_ahead(&self.state, middle_s, &pose);
        }
        let poses = [
            self.pose,
            on_piece(&self.piece, t + 0.5 * STEP_S).pose(),
            on_piece(&self.piece, t + STEP_S).pose(),
        ];
        let off = self.stopped.above(0.0);
        for i in 0..4 {
            self.input.throttle[i] = N::select(off, zero, self.throttle[i]);
        }
        let axes = axes_of(self.state.attitude);
        let near = batch.legs.near(&self.state.body(&axes), &poses[0]);
        let mut standing = N::any(near).then_some(LegContact {
            legs: &batch.legs,
            foothold: self.foothold,
        });
        let (acting, held) = vehicle.advance(
            &self.kind,
            &mut self.state,
            &poses,
            &self.input,
            standing.as_mut(),
            STEP_S,
        );
        if let Some(standing) = standing {
            self.foothold = standing.foothold;
        }
        self.acceleration_mps2 = acting.acceleration_mps2;
        let none = [zero; 3];
        self.pose = DeckPose {
            acceleration_mps2: none,
            angular_acceleration: none,
            ..poses[2]
        };
        self.step += 1;

        let roots = &self.state.rotors.root_thrust;
        let sd_n = || vehicle.rotors().turbulence_sd_n(roots, &held.target);
        self.air.act(within, &mut self.input, sd_n);
        self.judge(batch, near);
    }

    fn put(&mut self, lane: usize, state: &RigidState) {
        let (mut all, one) = (self.state.to_array(), state.moving().to_array());
        for k in 0..SIZE {
            all[k] = all[k].with(lane, one[k]);
        }
        self.state = MotionState::from_array(&all);
    }

    fn disturb(&mut self, lane: usize, disturbance: &Disturbance) {
        for k in 0..3 {
            let value = &mut self.input.wind_mps[k];
            *value = value.with(lane, disturbance.wind_mps[k]);
        }
        for i in 0..4 {
            let value = &mut self.input.turbulence_n[i];
            *value = value.with(lane, disturbance.turbulence_n[i]);
        }
    }
}
