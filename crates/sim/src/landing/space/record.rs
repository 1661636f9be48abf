//! The record of a landing, from the true state and the computer's output.

use touchdown_lander::computer::ComputerOutput;
use touchdown_lander::state_machine::Phase;

use super::flight::{Descent, Flight};
use super::outcome::{Abort, CrashCause, SpaceOutcome, TraceRow};
use super::touchdown::DeckState;
use crate::STEP_S;
use crate::number::vector::{along, sub};
use crate::sensors::suite::{steps, tilt_from};

/// Time for which the simulation continues after the vehicle gave up, s. It shows whether
/// the vehicle holds its position; a longer time costs only computing time.
const GIVEN_UP_S: f64 = 2.0;

impl Flight<'_> {
    /// Place and velocity relative to the deck's centre along its axes.
    pub(super) fn relative(&self) -> ([f64; 3], [f64; 3]) {
        let arm = sub(self.state.position_m, self.pose.origin_m);
        let velocity = sub(self.state.velocity_mps, self.pose.point_velocity(arm));
        (
            along(&self.pose.axes, arm),
            along(&self.pose.axes, velocity),
        )
    }

    /// Judges the state at a step by the truth.
    pub(super) fn judge(
        &mut self,
        step: u64,
        before: ([f64; 3], [f64; 3]),
    ) -> Option<SpaceOutcome> {
        let scenario = &self.lander.scenario;
        let (place_m, velocity_mps) = self.relative();
        let travelled_m = self.track.travelled_m(step as f64 * STEP_S);
        let beside_deck_m = sub(self.state.position_m, travelled_m);
        if !self.state.is_finite() || scenario.is_lost(beside_deck_m) {
            let cause = CrashCause::Lost;
            return Some(SpaceOutcome::Crashed { cause });
        }
        let near = self.touching.is_near(self.lander, place_m);
        let now = DeckState {
            place_m,
            velocity_mps,
            before_mps: before.1[2],
            tilt_rad: if near {
                tilt_from(self.state.attitude, &self.pose)
            } else {
                0.0
            },
        };
        if let Some(descending) = &mut self.descending
            && descending.touch.is_none()
        {
            descending.path_m += 0.5 * STEP_S * (before.1[2].abs() + velocity_mps[2].abs());
            descending.touch = near.then(|| {
                let t_l_s = (step - descending.since) as f64 * STEP_S;
                now.touch(step as f64 * STEP_S, t_l_s, descending.path_m)
            });
        }
        let ended = self.touching.judge(scenario, &now);
        if ended.is_some() {
            return ended;
        }
        let settled = self.stopped.and_then(|stopped| {
            let (since, watch) = (step - stopped, steps(scenario.watch_s) as u64);
            let attempts = self.landing.descents;
            self.touching.settled(attempts, since, watch)
        });
        if settled.is_some() {
            return settled;
        }
        if let Some((gave_up, reason)) = self.gave_up
            && step - gave_up >= steps(GIVEN_UP_S) as u64
        {
            return Some(SpaceOutcome::GivenUp { reason });
        }
        None
    }

    /// Records the output of the landing computer.
    pub(super) fn note(&mut self, step: u64, output: &ComputerOutput<f64>) {
        let phase = output.state_machine.phase;
        self.landing.estimated_latency_s = output.latency_s;
        self.waits.update(phase, output.state_machine.waits_for);
        if phase != self.phase {
            match (self.phase, phase) {
                (Phase::Wait, Phase::Descend) => {
                    self.landing.descents += 1;
                    self.descending = Some(Descent {
                        since: step,
                        path_m: 0.0,
                        touch: None,
                    });
                    self.fault_start.get_or_insert(step);
                }
                (_, Phase::GoAround) => self.landing.aborts.push(Abort {
                    time_s: step as f64 * STEP_S,
                    reason: output.state_machine.reason,
                    height_m: self.relative().0[2],
                }),
                (_, Phase::Disarmed) => self.stopped = Some(step),
                _ => {}
            }
            // A vehicle that resumes the landing has not given it up.
            self.gave_up = (phase == Phase::GivenUp).then_some((step, output.state_machine.reason));
            self.phase = phase;
        }
        if self.landing.trace.is_some() {
            let row = self.row(step, output);
            if let Some(trace) = &mut self.landing.trace {
                trace.rows.push(row);
            }
        }
    }

    fn row(&self, step: u64, output: &ComputerOutput<f64>) -> TraceRow {
        let (relative_m, relative_mps) = self.relative();
        let feet = self.vehicle.feet(&self.state, &self.pose);
        let estimate = &output.estimate;
        let forecast = self
            .lander
            .computer
            .forecast(&self.brain, TraceRow::FORECAST_S);
        TraceRow {
            time_s: step as f64 * STEP_S,
            position_m: self.state.position_m,
            velocity_mps: self.state.velocity_mps,
            attitude: self.state.attitude,
            rates: self.state.rates,
            deck_m: self.pose.origin_m,
            deck_mps: self.pose.velocity_mps,
            deck_mps2: self.pose.acceleration_mps2,
            deck_normal: self.pose.axes[2],
            relative_m,
            relative_mps,
            rotor_n: self.loads.rotor_n,
            ground_effect_n: self.loads.ground_effect_n.iter().sum(),
            feet_n: feet.map(|foot| foot.force_n[2]),
            wind_mps: self.disturbance.wind_mps,
            throttle: self.throttle,
            estimated_m: estimate.position_m.to_array(),
            estimated_mps: estimate.relative_velocity_mps().to_array(),
            estimated_velocity_mps: estimate.velocity_mps.to_array(),
            estimated_sd_m: estimate.position_sd_m.to_array(),
            target: output
                .target
                .map(|target| [target.vertical.height_m, target.vertical.velocity_mps]),
            estimated_latency_s: output.latency_s,
            estimated_deck_mps: output.deck.velocity_mps,
            estimated_deck_sd_mps: output.deck.velocity_sd_mps,
            estimated_deck_mps2: output.deck.acceleration_mps2,
            forecast_deck_mps: forecast.velocity_mps,
            forecast_deck_sd_mps: forecast.velocity_sd_mps,
            counted_ground_effect_n: output
                .command
                .map_or(0.0, |command| command.ground_effect_n),
            disturbance_n: output.disturbance_n.to_array(),
            thrust_n: output.command.map(|command| command.thrust_n),
            attitude_asked: output
                .command
                .map(|command| command.attitude.to_quaternion()),
            phase: output.state_machine.phase,
            reason: output.state_machine.reason,
            waits_for: output.state_machine.waits_for,
            range: (&output.health.range).into(),
            tag: (&output.health.tag).into(),
            gnss: (&output.health.gnss).into(),
            beacon: (&output.health.beacon).into(),
            diverged: output.health.diverged,
        }
    }
}
