//! A tick of the companion.

use touchdown_lander::computer::{ComputerOutput, Sensed};
use touchdown_lander::estimate::relative::Health;
use touchdown_lander::state_machine::{OperatorRequest, Phase};

use super::{Companion, Ending, Stage, due, messages};
use crate::autopilot::Autopilot;
use crate::axes;
use crate::checklist::{Verdict, thrust_curve, thrust_setpoint};
use crate::readings::Source;

const SECOND_US: i64 = 1_000_000;
/// Time between two questions for the autopilot's clock, µs.
const SYNC_US: i64 = 200_000;
/// Time between two requests for what is missing, µs.
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
/// Requests for a mode that holds the position; then for one that holds the altitude.
const POSITION_REQUESTS: u32 = 5;
/// Silence after which nobody waits for the disarming to be confirmed, s.
const LANDED_SILENT_S: f64 = 5.0;
/// A tick that is later than this is counted, µs.
const LATE_US: i64 = 15_000;

impl Companion {
    pub(super) fn tick(&mut self, out: &mut Vec<u8>) {
        let now = self.times.now;
        let elapsed_us = self.times.tick.map_or(0, |last| now - last);
        self.times.tick = Some(now);
        if due(&mut self.times.heartbeat, now, SECOND_US) {
            self.send(&messages::heartbeat(), out);
        }
        if self.stage == Stage::Ended || self.vehicle.is_none() {
            return;
        }
        self.ask(out);
        self.measure_rates();
        self.watch();
        if self.stage == Stage::HandingOver {
            self.continue_hand_over(out);
            return;
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
                self.setpoint(output.command.map(|c| (c.attitude, c.throttle)), out);
                let streamed = now - self.times.stage >= STREAM_US;
                if self.take_control && streamed && due(&mut self.times.command, now, SECOND_US) {
                    self.switch(out);
                }
            }
            Stage::InControl => {
                self.in_control_us += elapsed_us;
                self.late_ticks += u64::from(elapsed_us > LATE_US);
                self.output = Some(output);
                self.fly(&output, out);
            }
            _ => {}
        }
    }

    /// Asks for what is missing: the clock, parameters, rates.
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
        for name in vehicle.autopilot.parameters() {
            if !self.parameters.contains_key(name) {
                self.send(&messages::parameter(vehicle.system, name), out);
            }
        }
        let rates = self.settings.rates;
        let imu = match vehicle.autopilot {
            Autopilot::Px4 => 105,
            Autopilot::ArduPilot => 26,
        };
        // ATTITUDE_QUATERNION, the inertial unit, DISTANCE_SENSOR, LOCAL_POSITION_NED, SYS_STATUS.
        for (index, message_id, hz) in [
            (Some(0), 31, rates.attitude_hz),
            (Some(1), imu, rates.imu_hz),
            (Some(2), 132, rates.range_hz),
            (Some(3), 32, rates.velocity_hz),
            (None, 1, 1.0),
        ] {
            let seen = self.rates_hz.zip(index).map(|(seen, index)| seen[index]);
            if seen.is_none_or(|seen| seen < 0.8 * hz) {
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
                arrivals.map(|count| f64::from(count) / elapsed_s)
            });
        }
    }

    /// The watchdog of a vehicle in control: it never flies on what is old.
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
        if self.stage == Stage::InControl {
            if silent_s > limits.silent_s {
                self.hand_over(Ending::Silent);
            } else if stale_s > limits.stale_s {
                self.hand_over(Ending::Stale);
            }
        } else if self.stage == Stage::Landed && silent_s > LANDED_SILENT_S {
            self.end(Ending::Silent);
        } else if self.stage == Stage::Ready && (silent_s.max(stale_s) > limits.stale_s) {
            self.enter(Stage::Checked);
        }
    }

    /// A step of the landing computer. Before control its landing starts again in every step.
    fn compute(&mut self, dt: f64) -> ComputerOutput<f64> {
        let sensing = self.inbox.sense(self.times.now);
        if self.stage != Stage::InControl {
            self.computer.restart_landing(&mut self.memory);
        }
        let battery = self.vehicle.and_then(|vehicle| vehicle.battery);
        let sensed = Sensed {
            imu: sensing.imu,
            readings: &sensing.readings,
            deck_normal: None,
            battery_share: battery.unwrap_or(1.0),
            contact: None,
            request: OperatorRequest::None,
        };
        self.computer.step(&mut self.memory, &sensed, dt)
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
        let known = armed && self.computer.knows(&output.estimate) && fresh(&output.health);
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
                    self.setpoints += 1;
                    self.setpoint(Some((command.attitude, command.throttle)), out);
                }
                _ => {
                    self.hand_over(Ending::NotFinite);
                    self.continue_hand_over(out);
                }
            },
        }
    }

    /// Sends attitude and throttle through the thrust curve; without them, level and thrust zero.
    fn setpoint(
        &mut self,
        command: Option<(touchdown_flight::Attitude<f64>, f64)>,
        out: &mut Vec<u8>,
    ) {
        let Some(vehicle) = self.vehicle else { return };
        let Some(curve) = thrust_curve(vehicle.autopilot, &self.parameters) else {
            return;
        };
        let (attitude, thrust) = match command {
            Some((attitude, throttle)) => {
                let side = self.settings.vehicle.throttle;
                (attitude, thrust_setpoint(side, curve, throttle))
            }
            None => (self.inbox.level(), 0.0),
        };
        let Some(quaternion) = axes::quaternion(attitude) else {
            return;
        };
        let theirs_us = self.clock.theirs_us(self.times.now).unwrap_or(0);
        let boot_ms = u32::try_from(theirs_us / 1000).unwrap_or(0);
        let message = messages::attitude_target(vehicle.system, boot_ms, quaternion, thrust);
        self.send(&message, out);
    }

    fn switch(&mut self, out: &mut Vec<u8>) {
        if let Some(vehicle) = self.vehicle {
            let mode = vehicle.autopilot.following_mode();
            self.send(&messages::set_mode(vehicle.system, mode), out);
        }
    }

    pub(super) fn disarm(&mut self, out: &mut Vec<u8>) {
        if let Some(vehicle) = self.vehicle {
            self.send(&messages::disarm(vehicle.system), out);
        }
    }

    pub(super) fn ask_to_hold(&mut self, out: &mut Vec<u8>) {
        if let Some(vehicle) = self.vehicle {
            let [position, altitude] = vehicle.autopilot.holding_modes();
            let early = self.hold_requests < POSITION_REQUESTS;
            let mode = if early { position } else { altitude };
            self.hold_requests += 1;
            self.times.command = Some(self.times.now);
            self.send(&messages::set_mode(vehicle.system, mode), out);
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
