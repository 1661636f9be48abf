//! How landings end.

use super::super::lane_state::{DeckStates, state_of};
use super::super::{Batch, KNOT_STEPS};
use super::Engine;
use crate::STEP_S;
use crate::landing::space::outcome::{CrashCause, SpaceOutcome};
use crate::number::vector::{along, axes_of, dot, sub};
use crate::number::{Number, angle};

impl<N: Number> Engine<N> {
    /// Judges all by the truth: at every step those whose feet may have touched in it, that
    /// are low or that are watched, the others at knots.
    #[inline(always)]
    pub(super) fn judge(&mut self, batch: &Batch, near: N::Truth) {
        let scenario = &batch.lander.scenario;
        let arm = sub(self.state.position_m, self.pose.origin_m);
        let velocity = sub(self.state.velocity_mps, self.pose.point_velocity(arm));
        let height_m = dot(self.pose.axes[2], arm);
        let before_mps = self.sinking_mps;
        self.sinking_mps = dot(self.pose.axes[2], velocity);
        let path_m = (before_mps.abs() + self.sinking_mps.abs()) * (0.5 * STEP_S);
        let zero = height_m.splat(0.0);
        let flies = N::select(self.stopped.above(0.0), zero, path_m);
        self.path_m = self.path_m + flies;
        let above = height_m.above(scenario.landed_height_m);
        let looks = near | !above | self.watched.above(0.0);
        let standing = N::any(looks).then(|| self.look(batch, velocity));
        let looks = N::select(looks, zero.splat(1.0), 0.0);
        let seldom = self.step.is_multiple_of(KNOT_STEPS);
        if standing.is_none() && !seldom {
            return;
        }
        for lane in 0..N::COUNT {
            let Some(flight) = &mut self.flights[lane] else {
                continue;
            };
            let judged = standing
                .as_ref()
                .filter(|_| looks.get(lane) > 0.0)
                .map(|standing| standing.of(lane, before_mps));
            let mut outcome = None;
            if judged.is_some() || seldom {
                flight.path_m = self.path_m.get(lane);
                outcome = flight.judge(batch, self.step, judged.as_ref());
                if flight.is_stopped() {
                    self.stopped = self.stopped.with(lane, 1.0);
                    self.watched = self.watched.with(lane, 1.0);
                }
            }
            if seldom {
                let state = state_of(&self.state, lane);
                if !state.is_finite() || scenario.is_lost(state.position_m) {
                    let cause = CrashCause::Lost;
                    outcome = Some(SpaceOutcome::Crashed { cause });
                }
            }
            if let Some(outcome) = outcome
                && let Some(flight) = self.flights[lane].take()
            {
                self.landed.push(flight.landing(self.step, outcome));
                self.vacated.push(lane);
                self.stopped = self.stopped.with(lane, 1.0);
                self.watched = self.watched.with(lane, 0.0);
                self.left = self.step;
            }
        }
    }

    /// How all stand to their decks, `velocity` being relative to the deck.
    #[inline(always)]
    fn look(&self, batch: &Batch, velocity: [N; 3]) -> DeckStates<N> {
        let axes = axes_of(self.state.attitude);
        let up = dot(axes[2], self.pose.axes[2]);
        let up = up.within(-1.0, 1.0);
        let arm = sub(self.state.position_m, self.pose.origin_m);
        let feet = batch
            .legs
            .feet_at(&self.state.body(&axes), &self.pose, &self.foothold);
        let one = up.splat(1.0);
        let mut slides = [one; 4];
        for i in 0..4 {
            slides[i] = N::select(feet[i].slides, one, 0.0);
        }
        DeckStates {
            place_m: along(&self.pose.axes, arm),
            velocity_mps: along(&self.pose.axes, velocity),
            tilt_rad: angle(up, (1.0 - up * up).sqrt()),
            feet,
            slides,
        }
    }
}
