//! Messages of the vehicle.

use mavlink::dialects::common::{
    HEARTBEAT_DATA, MavMessage, MavModeFlag, MavParamType, PARAM_VALUE_DATA, TIMESYNC_DATA,
};

use super::{Companion, Ending, Stage, messages};
use crate::autopilot::Autopilot;
use crate::wire::Frame;

/// Component id of an autopilot.
const AUTOPILOT: u8 = 1;

/// The vehicle that has been heard.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vehicle {
    pub(super) system: u8,
    pub(super) autopilot: Autopilot,
    pub(super) armed: bool,
    /// Whether the last heartbeat was in the mode that follows a companion.
    pub(super) following: bool,
    /// When the autopilot was last heard, our time, µs.
    pub(super) heard_us: i64,
    /// Remaining energy, in [0, 1].
    pub(super) battery: Option<f64>,
}

impl Companion {
    pub(super) fn receive(&mut self, frame: &Frame, out: &mut Vec<u8>) {
        if self.stage == Stage::Ended {
            return;
        }
        if let MavMessage::HEARTBEAT(heartbeat) = &frame.message {
            self.heartbeat(frame, heartbeat);
            return;
        }
        let now = self.times.now;
        let Some(vehicle) = &mut self.vehicle else {
            self.other_senders += 1;
            return;
        };
        let same_system = frame.system == vehicle.system;
        // The deck may be seen by another component of the vehicle.
        if let (true, MavMessage::LANDING_TARGET(_)) = (same_system, &frame.message) {
            self.inbox.take(&frame.message, &self.clock, now);
            return;
        }
        if !same_system || frame.component != AUTOPILOT {
            self.other_senders += 1;
            return;
        }
        vehicle.heard_us = now;
        match &frame.message {
            MavMessage::TIMESYNC(sync) => self.timesync(sync, out),
            MavMessage::PARAM_VALUE(value) => self.parameter(value),
            MavMessage::SYS_STATUS(status) => {
                let share = f64::from(status.battery_remaining) / 100.0;
                vehicle.battery = (0.0..=1.0).contains(&share).then_some(share);
            }
            MavMessage::STATUSTEXT(text) => {
                if let Ok(text) = text.text.to_str() {
                    self.notes.push(format!("autopilot: {text}"));
                }
            }
            message => self.inbox.take(message, &self.clock, now),
        }
    }

    fn heartbeat(&mut self, frame: &Frame, heartbeat: &HEARTBEAT_DATA) {
        let wanted = self.settings.system_id;
        let autopilot = Autopilot::of(heartbeat.autopilot, heartbeat.mavtype)
            .filter(|_| frame.component == AUTOPILOT && (wanted == 0 || wanted == frame.system));
        let known = self
            .vehicle
            .is_none_or(|vehicle| vehicle.system == frame.system);
        let (Some(autopilot), true) = (autopilot, known) else {
            self.other_senders += 1;
            return;
        };
        let following = autopilot.follows(heartbeat.custom_mode);
        let armed = heartbeat
            .base_mode
            .contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        let before = self.vehicle;
        self.vehicle = Some(Vehicle {
            system: frame.system,
            autopilot: before.map_or(autopilot, |vehicle| vehicle.autopilot),
            armed,
            following,
            heard_us: self.times.now,
            battery: before.and_then(|vehicle| vehicle.battery),
        });
        let Some(before) = before else {
            self.encoder.system = frame.system;
            let (name, system) = (autopilot.name(), frame.system);
            self.notes.push(format!("{name}, system id {system}"));
            self.enter(Stage::Checking);
            return;
        };
        if before.autopilot != autopilot {
            self.other_autopilot();
            return;
        }
        match self.stage {
            Stage::Ready if following && !before.following && armed => self.enter(Stage::InControl),
            Stage::InControl | Stage::HandingOver if !following => self.end(Ending::PilotTookOver),
            Stage::InControl | Stage::HandingOver if !armed => self.end(Ending::Disarmed),
            Stage::Landed if !armed => self.end(Ending::Landed),
            Stage::Landed if !following => self.end(Ending::PilotTookOver),
            _ => {}
        }
    }

    /// Two autopilots share a system id: nobody can say whose readings these are.
    fn other_autopilot(&mut self) {
        match self.stage {
            Stage::InControl => self.hand_over(Ending::OtherAutopilot),
            Stage::HandingOver => {}
            _ => self.end(Ending::OtherAutopilot),
        }
    }

    fn timesync(&mut self, sync: &TIMESYNC_DATA, out: &mut Vec<u8>) {
        let now = self.times.now;
        if sync.tc1 == 0 {
            let answer = messages::timesync(now.saturating_mul(1000), sync.ts1);
            self.send(&answer, out);
            return;
        }
        let stepped = self.clock.answered(sync.ts1 / 1000, sync.tc1 / 1000, now);
        if !stepped {
            return;
        }
        self.inbox.forget();
        self.notes.push("the autopilot's clock stepped".to_string());
        match self.stage {
            Stage::InControl => self.hand_over(Ending::ClockStepped),
            Stage::Waiting | Stage::Checking | Stage::Checked | Stage::Ready => {
                // A restarted autopilot has forgotten rates, and maybe changed parameters.
                self.parameters.clear();
                self.rates_hz = None;
                self.memory = self.computer.initial(self.hover_throttle);
                self.enter(Stage::Checking);
            }
            Stage::Landed | Stage::HandingOver | Stage::Ended => {}
        }
    }

    fn parameter(&mut self, value: &PARAM_VALUE_DATA) {
        let (Some(vehicle), Ok(id)) = (self.vehicle, value.param_id.to_str()) else {
            return;
        };
        let mut names = vehicle.autopilot.parameters().iter();
        let Some(name) = names.find(|name| **name == id) else {
            return;
        };
        let raw = value.param_value;
        let number = match vehicle.autopilot {
            // PX4 sends the bytes of an integer in the place of the float; ArduPilot its value.
            Autopilot::Px4 if value.param_type == MavParamType::MAV_PARAM_TYPE_INT32 => {
                f64::from(raw.to_bits().cast_signed())
            }
            _ => f64::from(raw),
        };
        self.parameters.insert(name, number);
    }
}
