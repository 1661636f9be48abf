//! The step of all lanes.

use std::collections::VecDeque;
use std::ops::Range;

use super::lane::{Looked, ask_for, pose_of, state_of};
use super::seat::Seat;
use super::{Batch, KNOT_STEPS};
use crate::STEP_S;
use crate::cascade::{Memory, Wanted};
use crate::contact::{Foothold, Legs};
use crate::deck::rigid::{DeckCoordinates, DeckPose};
use crate::deck::spline::on_piece;
use crate::error::SimError;
use crate::number::{Number, angle};
use crate::rigid::{Disturbance, Input, Kind, Moving, RigidState, SIZE, Standing};
use crate::space::outcome::{CrashCause, SpaceLanding, SpaceOutcome};
use crate::space::sensing::steps;
use crate::vector::{along, axes_of, dot, sub};

/// Time for which half the lanes wait for the others, in steps.
const WAIT_STEPS: u64 = 400;
/// Height above the landed height below which a vehicle is judged at every step, m.
const NEAR_M: f64 = 0.02;

/// Landings in the lanes of a number.
pub(super) struct Engine<'a, N: Number> {
    batch: &'a Batch,
    legs: &'a Legs,
    waiting: Range<u64>,
    seed: u64,
    step: u64,
    /// When a lane was last left.
    left: u64,
    seats: Vec<Option<Seat>>,
    landed: Vec<SpaceLanding>,
    kind: Kind<N>,
    state: Moving<N>,
    foothold: Foothold<N>,
    input: Input<N>,
    acceleration_mps2: [N; 3],
    piece: [[N; 5]; 6],
    pose: DeckPose<N>,
    /// Velocity along the deck's normal relative to it, m/s.
    sinking_mps: N,
    wanted: Wanted<N>,
    coming: VecDeque<(u64, Wanted<N>)>,
    memory: Memory<N>,
    /// 1 in lanes whose control has not stepped, whose rotors have stopped.
    fresh: N,
    stopped: N,
    /// 1 in lanes that are watched after their touch.
    watched: N,
    throttle: [N; 4],
}

impl<'a, N: Number> Engine<'a, N> {
    #[inline(always)]
    pub(super) fn new(batch: &'a Batch, trials: Range<u64>, seed: u64, like: N) -> Self {
        let (zero, one) = (like.like(0.0), like.like(1.0));
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
            batch,
            legs: &batch.legs,
            waiting: trials,
            seed,
            step: 0,
            left: 0,
            seats: (0..N::COUNT).map(|_| None).collect(),
            landed: Vec::with_capacity(count),
            kind: Kind {
                thrust_scale_error: [zero; 4],
                ground_effect_scale: one,
            },
            state: Moving::from_array(&start),
            foothold: Foothold {
                sticks: [none; 4],
                stuck_m: [[zero; 2]; 4],
            },
            input: Input {
                throttle: [zero; 4],
                wind_mps: [zero; 3],
                turbulence_n: [zero; 4],
            },
            acceleration_mps2: [zero; 3],
            piece: [[zero; 5]; 6],
            pose: still.pose(),
            sinking_mps: zero,
            wanted: Wanted {
                thrust_n: zero,
                attitude: [one, zero, zero, zero],
                yaw_rate: zero,
            },
            coming: VecDeque::new(),
            memory: Memory::none(zero),
            fresh: zero,
            stopped: one,
            watched: zero,
            throttle: [zero; 4],
        }
    }

    /// Flies all trials.
    #[inline(always)]
    pub(super) fn run(mut self) -> Result<Vec<SpaceLanding>, SimError> {
        let scenario = &self.batch.lander.scenario;
        let cascade = &self.batch.lander.cascade;
        let control_steps = steps(scenario.control_period_s) as u64;
        let cascade_steps = steps(cascade.period_s()) as u64;
        let delay = steps(scenario.command_delay_s) as u64;
        loop {
            let within = self.step % KNOT_STEPS;
            if within == 0 {
                self.seat()?;
                if self.seats.iter().all(Option::is_none) {
                    break;
                }
                self.knot();
            }
            if self.step.is_multiple_of(control_steps) {
                let wanted = self.ask();
                self.coming.push_back((self.step + delay, wanted));
            }
            while let Some((_, wanted)) = self.coming.front().filter(|(at, _)| *at <= self.step) {
                self.wanted = *wanted;
                self.coming.pop_front();
            }
            if self.step.is_multiple_of(cascade_steps) {
                let zero = self.fresh.like(0.0);
                let first = zero.below(self.fresh);
                let (q, rates) = (self.state.attitude, self.state.rates);
                let given = cascade.control(&mut self.memory, first, q, rates, &self.wanted);
                self.throttle = given.throttle;
                self.fresh = zero;
            }
            self.fly(within);
        }
        self.landed.sort_by_key(|landing| landing.trial_index);
        Ok(self.landed)
    }

    /// Trials take the empty seats.
    ///
    /// Lanes that touch at the same time share the work of the legs: trials begin together, when
    /// all have landed or half of them a while ago.
    fn seat(&mut self) -> Result<(), SimError> {
        let empty = self.seats.iter().filter(|seat| seat.is_none()).count();
        let late = self.step >= self.left + WAIT_STEPS;
        if !(empty == N::COUNT || late && 2 * empty >= N::COUNT) {
            return Ok(());
        }
        for lane in 0..N::COUNT {
            if self.seats[lane].is_some() {
                continue;
            }
            let Some(trial) = self.waiting.next() else {
                continue;
            };
            let (seat, state, hover, disturbance) =
                Seat::new(self.batch, trial, self.seed, self.step)?;
            let kind = seat.vehicle.kind();
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
            let here = self.fresh.like(0.0).with(lane, 1.0);
            let taken = here.like(0.0).below(here);
            self.memory = self.memory.without(taken);
            for i in 0..4 {
                self.foothold.sticks[i] = self.foothold.sticks[i] & !taken;
            }
            self.fresh = self.fresh.with(lane, 1.0);
            self.stopped = self.stopped.with(lane, 0.0);
            self.sinking_mps = self.sinking_mps.with(lane, 0.0);
            self.seats[lane] = Some(seat);
        }
        Ok(())
    }

    /// The decks up to their next knots.
    fn knot(&mut self) {
        let mut idle = Vec::new();
        for (lane, seat) in self.seats.iter_mut().enumerate() {
            let Some(seat) = seat else {
                // Out of the others' way: above the deck, from rest again at every knot.
                idle.push(lane);
                continue;
            };
            let piece = seat.next_piece();
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

    /// What the pilots ask for now.
    fn ask(&mut self) -> Wanted<N> {
        let mut wanted = self
            .coming
            .back()
            .map_or(self.wanted, |(_, wanted)| *wanted);
        for lane in 0..N::COUNT {
            let (state, pose) = (state_of(&self.state, lane), pose_of(&self.pose, lane));
            let acceleration = self.acceleration_mps2.map(|a| a.get(lane));
            let Some(seat) = self.seats[lane].as_mut().filter(|seat| !seat.is_stopped()) else {
                continue;
            };
            let setpoint = self.batch.command(seat, &state, &pose, acceleration);
            ask_for(&mut wanted, lane, &setpoint);
        }
        wanted
    }

    /// The motion of all over a step.
    #[inline(always)]
    fn fly(&mut self, within: u64) {
        let vehicle = &self.batch.lander.vehicle;
        let zero = self.stopped.like(0.0);
        let t = within as f64 * STEP_S;
        let poses = [
            self.pose,
            on_piece(&self.piece, t + 0.5 * STEP_S).pose(),
            on_piece(&self.piece, t + STEP_S).pose(),
        ];
        let off = zero.below(self.stopped);
        for i in 0..4 {
            self.input.throttle[i] = N::choose(off, zero, self.throttle[i]);
        }
        let axes = axes_of(self.state.attitude);
        let near = self.legs.near(&self.state.body(&axes), &poses[0]);
        let mut standing = N::any(near).then_some(Standing {
            legs: self.legs,
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
        self.pose = poses[2];
        self.step += 1;

        let roots = &self.state.rotors.root_thrust;
        let sd_n = vehicle.rotors().turbulence_sd_n(roots, &held.target);
        for lane in 0..N::COUNT {
            let Some(seat) = &mut self.seats[lane] else {
                continue;
            };
            if let Some(turbulence) = &mut seat.turbulence {
                let values_n = turbulence.step(sd_n.map(|sd| sd.get(lane)));
                for i in 0..4 {
                    let value = &mut self.input.turbulence_n[i];
                    *value = value.with(lane, values_n[i]);
                }
            }
            if seat.wind.changes() {
                seat.wind.step();
                let wind_mps = seat.wind.velocity_mps();
                for k in 0..3 {
                    let value = &mut self.input.wind_mps[k];
                    *value = value.with(lane, wind_mps[k]);
                }
            }
        }
        self.judge();
    }

    /// Judges all by the truth.
    #[inline(always)]
    fn judge(&mut self) {
        let scenario = &self.batch.lander.scenario;
        let arm = sub(self.state.position_m, self.pose.origin_m);
        let velocity = sub(self.state.velocity_mps, self.pose.point_velocity(arm));
        let height_m = dot(self.pose.axes[2], arm);
        let before_mps = self.sinking_mps;
        self.sinking_mps = dot(self.pose.axes[2], velocity);
        let path = (before_mps.abs() + self.sinking_mps.abs()) * (0.5 * STEP_S);
        let low_m = scenario.landed_height_m + NEAR_M;
        let zero = height_m.like(0.0);
        let looks = height_m.below(zero.like(low_m)) | zero.below(self.watched);
        let looked = N::any(looks).then(|| self.look(velocity));
        let looks = N::choose(looks, zero.like(1.0), zero);
        let seldom = self.step.is_multiple_of(KNOT_STEPS);
        for lane in 0..N::COUNT {
            let Some(seat) = &mut self.seats[lane] else {
                continue;
            };
            if !seat.is_stopped() {
                seat.path_m += path.get(lane);
            }
            let judged = looked
                .as_ref()
                .filter(|_| looks.get(lane) > 0.0)
                .map(|looked| looked.of(lane, before_mps));
            let mut outcome = None;
            if judged.is_some() || seldom {
                outcome = seat.judge(self.batch, self.step, judged.as_ref());
                if seat.is_stopped() {
                    self.stopped = self.stopped.with(lane, 1.0);
                    self.watched = self.watched.with(lane, 1.0);
                }
            }
            if seldom {
                let state = state_of(&self.state, lane);
                let far = sub(state.position_m, scenario.start_m);
                let most = scenario.crash.lost_m;
                if !state.is_finite() || dot(far, far) > most * most {
                    let cause = CrashCause::Lost;
                    outcome = Some(SpaceOutcome::Crashed { cause });
                }
            }
            if let Some(outcome) = outcome
                && let Some(seat) = self.seats[lane].take()
            {
                self.landed.push(seat.landing(self.step, outcome));
                self.stopped = self.stopped.with(lane, 1.0);
                self.watched = self.watched.with(lane, 0.0);
                self.left = self.step;
            }
        }
    }

    /// How all stand to their decks, `velocity` being relative to the deck.
    #[inline(always)]
    fn look(&self, velocity: [N; 3]) -> Looked<N> {
        let axes = axes_of(self.state.attitude);
        let up = dot(axes[2], self.pose.axes[2]);
        let up = up.within(up.like(-1.0), up.like(1.0));
        let arm = sub(self.state.position_m, self.pose.origin_m);
        let feet = self
            .legs
            .feet_at(&self.state.body(&axes), &self.pose, &self.foothold);
        let (zero, one) = (up.like(0.0), up.like(1.0));
        let mut slides = [zero; 4];
        for i in 0..4 {
            slides[i] = N::choose(feet[i].slides, one, zero);
        }
        Looked {
            place_m: along(&self.pose.axes, arm),
            velocity_mps: along(&self.pose.axes, velocity),
            tilt_rad: angle(up, (up * up).taken_from(1.0).sqrt()),
            feet,
            slides,
        }
    }

    fn put(&mut self, lane: usize, state: &RigidState) {
        let (mut all, one) = (self.state.to_array(), state.moving().to_array());
        for k in 0..SIZE {
            all[k] = all[k].with(lane, one[k]);
        }
        self.state = Moving::from_array(&all);
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
