//! A tick of the companion.

use touchdown_lander::computer::{ComputerOutput, Sensed};
use touchdown_lander::estimate::relative::Health;
use touchdown_lander::state_machine::{OperatorRequest, Phase};

use super::lift::Lift;
use super::{Companion, Ending, Stage, due, messages};
use crate::autopilot::Autopilot;
use crate::checklist::Verdict;
use crate::readings::Source;
use crate::settings::PERIOD_S;

const SECOND_US: i64 = 1_000_000;
/// Time between two questions for the autopilot's clock, µs.
const SYNC_US: i64 = 200_000;
/// Time between two requests for missing data, µs.
const REQUEST_US: i64 = SECOND_US;
/// Time over which rates are counted, µs.
const RATES_US: i64 = 2 * SECOND_US;
/// Time between two judgements of the checklist, µs.
const JUDGE_US: i64 = SECOND_US / 2;
/// Time between two commands that are not answered yet, µs.
const COMMAND_US: i64 = 200_000;
/// Stream of setpoints before the companion switches the mode itself, µs.
const STREAM_US: i64 = SECOND_US;
/// Longest hand-over, µs.
const HAND_OVER_US: i64 = 5 * SECOND_US;
/// Time without any report of the mode after which a take-over by the pilot may have gone unnoticed, µs: two heartbeats of
/// an autopilot that sends one a second are lost. Half of it takes a lost heartbeat for a fault.
const MODE_UNKNOWN_US: i64 = 2_500_000;
/// Time after Ctrl-C for which a landed vehicle is disarmed, µs.
const LANDED_US: i64 = 5 * SECOND_US;
/// Rate of heartbeats, Hz: a change of the mode is noticed within its period.
const HEARTBEATS_HZ: f64 = 10.0;
/// Rate of `CURRENT_MODE`, Hz. PX4 never sends heartbeats faster than once a second. It sends this message when its state
/// changes, and not faster than this: with half of it, a take-over is noticed 20 ms later.
const MODE_HZ: f64 = 50.0;
/// Rate of the setpoints that the autopilot follows, Hz: from a recording, thrust is identified by them.
const ECHO_HZ: f64 = 50.0;
/// Silence after which the companion waits no longer for the confirmation of the disarm, s.
const LANDED_SILENT_S: f64 = 5.0;
/// A tick that is later than this is counted, µs.
const LATE_US: i64 = 15_000;

impl Companion {
    pub(super) fn tick(&mut self, out: &mut Vec<u8>) {
        let now = self.times.now;
        let elapsed_us = self.times.tick.map_or(0, |last| now - last);
        self.times.tick = Some(now);
        self.computed = None;
        self.elapsed_us = elapsed_us;
        if due(&mut self.times.heartbeat, now, SECOND_US) {
            self.send(&messages::heartbeat(), out);
        }
        self.notice_silence();
        if self.stage == Stage::Ended || self.vehicle.is_none() {
            return;
        }
        self.inbox
            .arms(self.vehicle.is_some_and(|vehicle| vehicle.armed));
        self.ask(out);
        self.measure_rates();
        self.watch();
        if self.stage == Stage::HandingOver {
            self.continue_hand_over(out);
            return;
        }
        if self.stage == Stage::Restoring {
            self.restore(out);
            return;
        }
        if matches!(self.stage, Stage::Ready | Stage::InControl) {
            let period_us = (PERIOD_S * 1e6) as i64;
            self.jitter.add(elapsed_us.abs_diff(period_us));
        }
        if self.stage == Stage::Landed {
            if due(&mut self.times.command, now, COMMAND_US) {
                self.disarm(out);
            }
            self.setpoint(None, out);
            return;
        }
        let output = self.compute(elapsed_us as f64 * 1e-6);
        self.advance(&output);
        match self.stage {
            Stage::Ready => {
                let command = output
                    .command
                    .filter(|c| c.attitude.is_finite() && c.throttle.is_finite());
                if let Some(command) = command {
                    self.setpoint(Some((command.attitude, command.throttle)), out);
                }
                let streamed = now - self.times.stage >= STREAM_US;
                if self.session.take_control
                    && streamed
                    && due(&mut self.times.command, now, SECOND_US)
                {
                    self.switch(out);
                }
            }
            Stage::InControl => {
                self.in_control_us += elapsed_us;
                self.late_ticks += u64::from(elapsed_us > LATE_US);
                self.output = Some(output);
                self.touch.watch(&output);
                self.fly(&output, out);
            }
            _ => {}
        }
    }

    /// Requests missing data: the clock, parameters, rates.
    fn ask(&mut self, out: &mut Vec<u8>) {
        let (Some(vehicle), now) = (self.vehicle, self.times.now) else {
            return;
        };
        if due(&mut self.times.sync, now, SYNC_US) {
            self.clock.asks(now);
            self.send(&messages::timesync(0, now.saturating_mul(1000)), out);
        }
        let checks = matches!(self.stage, Stage::Checking | Stage::Checked);
        if !checks || !due(&mut self.times.requests, now, REQUEST_US) {
            return;
        }
        self.ask_for_parameters(out);
        if vehicle.firmware.is_none() {
            self.send(&messages::version(vehicle.system), out);
        }
        let rates = self.settings.rates;
        let imu = match vehicle.autopilot {
            Autopilot::Px4 => 105,
            Autopilot::ArduPilot => 26,
        };
        // ArduPilot has no CURRENT_MODE, and sends heartbeats as fast as it is asked to.
        let (mode, mode_hz) = match vehicle.autopilot {
            Autopilot::Px4 => (436, MODE_HZ),
            Autopilot::ArduPilot => (0, HEARTBEATS_HZ),
        };
        // ATTITUDE_QUATERNION, the inertial unit, DISTANCE_SENSOR, LOCAL_POSITION_NED, SYS_STATUS, the mode,
        // ATTITUDE_TARGET.
        for (index, message_id, hz) in [
            (Some(0), 31, rates.attitude_hz),
            (Some(1), imu, rates.imu_hz),
            (Some(2), 132, rates.range_hz),
            (Some(3), 32, rates.velocity_hz),
            (None, 1, 1.0),
            (None, mode, mode_hz),
            (None, 83, ECHO_HZ),
            // GLOBAL_POSITION_INT, only for a deck that reports its own.
            (None, 33, rates.velocity_hz),
        ] {
            let seen = self.rates_hz.zip(index).map(|(seen, index)| seen[index]);
            let needed = message_id != 33 || self.settings.deck.system_id != 0;
            if needed && seen.is_none_or(|seen| seen < 0.8 * hz) {
                let request = messages::message_interval(vehicle.system, message_id, hz);
                self.send(&request, out);
            }
        }
    }

    fn measure_rates(&mut self) {
        let now = self.times.now;
        let since = self.times.rates;
        if due(&mut self.times.rates, now, RATES_US) {
            let arrivals = self.inbox.take_arrivals();
            self.rates_hz = since.map(|since| {
                let elapsed_s = (now - since) as f64 * 1e-6;
                if let Some(camera) = &mut self.camera {
                    camera.count(elapsed_s);
                }
                arrivals.map(|count| f64::from(count) / elapsed_s)
            });
        }
    }

    /// The watchdog in control: it ends control when readings are too old.
    fn watch(&mut self) {
        let (Some(vehicle), now) = (self.vehicle, self.times.now) else {
            return;
        };
        let limits = self.settings.limits;
        let silent_s = (now - vehicle.heard_us) as f64 * 1e-6;
        let stale_s = self
            .inbox
            .age_s(Source::Attitude, now)
            .max(self.inbox.age_s(Source::Imu, now));
        let jumped = self.inbox.take_jump();
        if self.stage == Stage::InControl {
            if silent_s > limits.silent_s {
                self.hand_over(Ending::Silent);
            } else if stale_s > limits.stale_s {
                self.hand_over(Ending::Stale);
            } else if now - vehicle.mode_us > MODE_UNKNOWN_US {
                self.hand_over(Ending::ModeUnknown);
            } else if jumped {
                self.hand_over(Ending::EstimatorReset);
            } else if self.lift.is_missing(now) {
                self.notes.push(
                    "the accelerometer feels no thrust of the motors that carry the vehicle: it, or a motor, has failed"
                        .to_string(),
                );
                self.hand_over(Ending::Stale);
            } else if self.echo.rejected(now) {
                self.hand_over(Ending::Rejected);
            }
        } else if self.stage == Stage::Landed
            && self.times.stop.is_some_and(|stop| now - stop > LANDED_US)
        {
            self.end(Ending::Stopped);
        } else if self.stage == Stage::Landed && silent_s > LANDED_SILENT_S {
            self.end(Ending::Silent);
        } else if self.stage == Stage::Ready && (silent_s.max(stale_s) > limits.stale_s) {
            self.enter(Stage::Checked);
        } else if jumped && matches!(self.stage, Stage::Checking | Stage::Checked | Stage::Ready) {
            // Estimates in the axes of before are wrong in those of after.
            self.memory = self.computer.initial(self.hover_throttle);
        }
    }

    /// A step of the landing computer. Before control its landing starts again in every step.
    fn compute(&mut self, dt: f64) -> ComputerOutput<f64> {
        let imu = self.inbox.sense(self.times.now);
        let normal = self.inbox.take_normal(self.times.now);
        if self.stage == Stage::InControl {
            let command = self.output.and_then(|output| output.command);
            let throttle = command.map_or(0.0, |command| command.throttle);
            self.lift.feels(
                imu.specific_force_mps2.z / self.settings.vehicle.gravity_mps2,
                throttle / self.hover_throttle,
                self.times.now,
            );
        } else {
            self.lift = Lift::default();
            self.computer.restart_landing(&mut self.memory);
        }
        let battery = self.vehicle.and_then(|vehicle| vehicle.battery);
        let sensed = Sensed {
            imu,
            readings: self.inbox.ready(),
            deck_normal: normal,
            battery_share: battery.unwrap_or(1.0),
            contact: None,
            request: OperatorRequest::None,
        };
        let output = self.computer.step(&mut self.memory, &sensed, dt);
        self.computed = Some(output);
        output
    }

    /// The stages before control.
    fn advance(&mut self, output: &ComputerOutput<f64>) {
        let now = self.times.now;
        if !matches!(self.stage, Stage::Checking | Stage::Checked | Stage::Ready) {
            return;
        }
        if due(&mut self.times.checklist, now, JUDGE_US) {
            let verdict = self.judge();
            if verdict <= Verdict::Warning {
                if self.stage == Stage::Checking {
                    self.enter(Stage::Checked);
                }
            } else {
                self.enter(Stage::Checking);
            }
        }
        let armed = self.vehicle.is_some_and(|vehicle| vehicle.armed);
        // A vehicle that follows already would obey the first setpoint, before its pilot has given control.
        let follows = self.vehicle.is_some_and(|vehicle| vehicle.following);
        let known =
            armed && !follows && self.computer.knows(&output.estimate) && fresh(&output.health);
        match self.stage {
            Stage::Checked if known => self.enter(Stage::Ready),
            Stage::Ready if !known => self.enter(Stage::Checked),
            _ => {}
        }
    }

    fn fly(&mut self, output: &ComputerOutput<f64>, out: &mut Vec<u8>) {
        match output.state_machine.phase {
            Phase::Disarmed => {
                self.enter(Stage::Landed);
                self.disarm(out);
                self.times.command = Some(self.times.now);
                self.setpoint(None, out);
            }
            Phase::GivenUp => {
                self.hand_over(Ending::GivenUp);
                self.continue_hand_over(out);
            }
            _ => match output.command {
                Some(command) if command.attitude.is_finite() && command.throttle.is_finite() => {
                    self.setpoint(Some((command.attitude, command.throttle)), out);
                }
                _ => {
                    self.hand_over(Ending::NotFinite);
                    self.continue_hand_over(out);
                }
            },
        }
    }

    fn continue_hand_over(&mut self, out: &mut Vec<u8>) {
        let now = self.times.now;
        if now - self.times.stage > HAND_OVER_US {
            self.end(Ending::Stopped);
        } else if due(&mut self.times.command, now, COMMAND_US) {
            self.ask_to_hold(out);
        }
    }
}

/// Whether every sensor that a landing needs is fresh and agrees with the others.
fn fresh(health: &Health<f64>) -> bool {
    health.imu.fresh && health.range.fresh && health.tag.fresh && !health.diverged
}
