//! Lanes that follow commands from outside.

use super::super::commanded::{Ended, with_commands};
use super::super::lane_flight::Departure;
use super::super::lane_state::LaneState;
use super::super::{Batch, KNOT_STEPS};
use super::Engine;
use crate::STEP_S;
use crate::deck::spline::on_piece;
use crate::landing::space::policy::Observation;
use crate::number::Number;

impl<N: Number> Engine<N> {
    /// Steps since the engine began.
    pub(in super::super) fn step(&self) -> u64 {
        self.step
    }

    /// What comes are rates about body axes, none yet.
    pub(in super::super) fn follow_rates(&mut self) {
        self.wanted.body_rates = Some([self.wanted.yaw_rate; 3].map(|rate| rate.splat(0.0)));
    }

    /// A lane takes a flight at once, wherever the others are between two knots.
    pub(in super::super) fn begin(&mut self, lane: usize, mut departure: Departure) {
        let within = self.step % KNOT_STEPS;
        departure.0.begin_after_knot(within);
        let piece = departure.0.next_piece();
        self.take(lane, departure);
        for (to, from) in self.piece.iter_mut().flatten().zip(piece.iter().flatten()) {
            *to = to.with(lane, *from);
        }
        self.pose = on_piece(&self.piece, within as f64 * STEP_S).pose();
    }

    /// Flies so many steps with one command for each lane; gives the landings that have ended.
    #[inline(always)]
    pub(in super::super) fn follow(
        &mut self,
        batch: &Batch,
        commands: &[f64],
        steps: u64,
    ) -> Vec<Ended> {
        let before = self
            .coming
            .back()
            .map_or(self.wanted, |(_, wanted)| *wanted);
        self.command(batch, with_commands(before, commands));
        let mut ends = Vec::new();
        for _ in 0..steps {
            self.act(batch, self.step % KNOT_STEPS);
            // Before the lanes that are left are moved out of the others' way.
            for (lane, landing) in self
                .vacated
                .drain(..)
                .zip(self.landed.drain(..))
                .collect::<Vec<_>>()
            {
                let state = self.observe(lane).numbers();
                ends.push(Ended {
                    lane,
                    landing,
                    state,
                });
            }
            if self.step.is_multiple_of(KNOT_STEPS) {
                self.knot();
            }
        }
        ends
    }

    /// The true state of a lane.
    pub(in super::super) fn observe(&self, lane: usize) -> Observation {
        let seen = LaneState::of_all(&self.state, &self.pose, self.acceleration_mps2).of(lane);
        Observation {
            place_m: seen.place_m,
            relative_mps: seen.relative_mps,
            velocity_mps: seen.velocity_mps,
            attitude: seen.attitude,
            rates: self.state.rates.map(|rate| rate.get(lane)),
            normal: seen.normal,
        }
    }
}
