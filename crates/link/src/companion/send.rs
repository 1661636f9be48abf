//! Setpoints and commands.

use touchdown_flight::{Attitude, Vector};

use super::{Companion, Stage, Vehicle, messages};
use crate::axes;

/// Age beyond which a mode report does not show who flies, µs: half as long again as the second between the
/// heartbeats of an autopilot that was not asked for more. With half of it, one late heartbeat ends the requests; in
/// twice of it a pilot may have taken off again.
const MODE_KNOWN_US: i64 = 1_500_000;
/// Silence beyond which a request was probably not heard either, µs: two reports at 10 Hz. With half of it, a late report
/// prolongs the requests for the position by one; with twice of it, one request into a cut link counts.
const HEARD_US: i64 = 200_000;
/// Requests for a mode that holds the position; then for one that holds the altitude.
const POSITION_REQUESTS: u32 = 5;

impl Companion {
    /// Sends attitude and throttle through the thrust curve; without them, level and thrust zero.
    pub(super) fn setpoint(&mut self, command: Option<(Attitude<f64>, f64)>, out: &mut Vec<u8>) {
        let (Some(vehicle), Some(way), false) =
            (self.vehicle, self.thrust, self.times.catches_up())
        else {
            return;
        };
        let (attitude, thrust) = match command {
            Some((attitude, throttle)) => {
                let cosine = attitude.rotate(Vector::UP).z;
                (attitude, way.setpoint(throttle, cosine))
            }
            None => (self.inbox.level(), 0.0),
        };
        let Some(quaternion) = axes::quaternion(attitude) else {
            return;
        };
        if !(0.0..=1.0).contains(&thrust) {
            return;
        }
        let now = self.times.now;
        let theirs_us = self.clock.theirs_us(now).unwrap_or(0);
        let boot_ms = u32::try_from(theirs_us / 1000).unwrap_or(0);
        let message = messages::attitude_target(vehicle.system, boot_ms, quaternion, thrust);
        self.echo.sends(thrust, now);
        self.send(&message, out);
        if self.stage == Stage::InControl {
            self.setpoints += 1;
            let age_us = self.inbox.newest_age_us(now).unwrap_or(i64::MAX);
            self.reading_ages.add(age_us.unsigned_abs());
        }
    }

    pub(super) fn switch(&mut self, out: &mut Vec<u8>) {
        if let (Some(vehicle), false) = (self.vehicle, self.times.catches_up()) {
            let mode = vehicle.autopilot.modes().following;
            self.send(&messages::set_mode(vehicle.system, mode), out);
        }
    }

    /// Whether a recent report shows that the vehicle still follows the companion.
    fn follows_surely(&self) -> bool {
        let recent = |vehicle: &Vehicle| self.times.now - vehicle.mode_us <= MODE_KNOWN_US;
        let follows = self
            .vehicle
            .is_some_and(|vehicle| vehicle.following && recent(&vehicle));
        follows && !self.times.catches_up()
    }

    pub(super) fn disarm(&mut self, out: &mut Vec<u8>) {
        if let (Some(vehicle), true) = (self.vehicle, self.follows_surely()) {
            self.send(&messages::disarm(vehicle.system), out);
        }
    }

    pub(super) fn ask_to_hold(&mut self, out: &mut Vec<u8>) {
        let asks = self.follows_surely() && !self.hold_accepted;
        if let (Some(vehicle), true) = (self.vehicle, asks) {
            let [position, altitude] = vehicle.autopilot.modes().given_back;
            let early = self.hold_requests < POSITION_REQUESTS;
            let mode = if early { position } else { altitude };
            // What is sent into a cut link is no attempt.
            let heard_us = self.times.now - vehicle.heard_us;
            self.hold_requests += u32::from(heard_us <= HEARD_US);
            self.times.command = Some(self.times.now);
            self.send(&messages::set_mode(vehicle.system, mode), out);
        }
    }
}
