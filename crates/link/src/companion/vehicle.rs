//! Messages of the vehicle.

use mavlink::dialects::common::{
    COMMAND_ACK_DATA, HEARTBEAT_DATA, MavCmd, MavMessage, MavModeFlag, MavResult, TIMESYNC_DATA,
};

use super::{Companion, Ending, Stage, messages};
use crate::autopilot::{Autopilot, Firmware};
use crate::clock::SyncEvent;
use crate::readings::Source;
use crate::wire::Frame;

/// Component id of an autopilot.
const AUTOPILOT: u8 = 1;
/// Range above which a vehicle does not stand on its legs, m. Half of it is the height of long legs; with twice of it, a
/// hover just above the hold height of a small pad would not count.
const AIRBORNE_M: f64 = 0.4;
/// Frames over which steps back of the sequence are counted: less than a second of streams.
const FRAMES: u32 = 256;
/// Steps back among them that one sender does not make. Two senders of the same id, of which each fills datagrams with up
/// to four frames, step back so often; a replayed burst or swapped datagrams step back once each. Half of it is what a
/// link that repeats every 16th frame makes; with twice of it, senders that fill datagrams pass. Those that pass are
/// found by their clocks.
const STEPS_BACK: u32 = 32;

/// Time without an autopilot's heartbeat after which the companion says so, µs. Autopilots send one a second.
const UNHEARD_US: i64 = 10_000_000;

/// What has been said before an autopilot was heard.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hints {
    /// That another autopilot is on the link.
    another: bool,
    /// That none is.
    silence: bool,
    /// When the companion began to listen, µs.
    began: Option<i64>,
}

/// The vehicle that has been heard.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vehicle {
    pub(super) system: u8,
    pub(super) autopilot: Autopilot,
    pub(super) firmware: Option<Firmware>,
    pub(super) armed: bool,
    /// Whether the newest report of the mode was the one that follows a companion.
    pub(super) following: bool,
    /// When the mode was last reported, our time, µs.
    pub(super) mode_us: i64,
    /// When the autopilot was last heard, our time, µs.
    pub(super) heard_us: i64,
    /// Remaining energy, in [0, 1].
    pub(super) battery: Option<f64>,
    sequence: Sequence,
}

/// The numbers of a sender's frames.
#[derive(Clone, Copy, Debug, Default)]
struct Sequence {
    last: u8,
    frames: u32,
    steps_back: u32,
}

impl Sequence {
    /// Takes the next number; whether two senders must be counting.
    fn takes(&mut self, number: u8) -> bool {
        let ahead = number.wrapping_sub(self.last);
        self.last = number;
        self.frames += 1;
        // A number that repeats is a frame that came twice.
        self.steps_back += u32::from(ahead > 128);
        if self.frames < FRAMES {
            return false;
        }
        let two = self.steps_back >= STEPS_BACK;
        (self.frames, self.steps_back) = (0, 0);
        two
    }
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
        if frame.system == self.settings.deck.system_id && !same_system {
            self.inbox.take_deck(&frame.message, now);
            return;
        }
        if same_system && frame.component != AUTOPILOT && places_the_vehicle(&frame.message) {
            self.inbox.take_external(&frame.message, now);
            return;
        }
        if !same_system || frame.component != AUTOPILOT {
            self.other_senders += 1;
            return;
        }
        vehicle.heard_us = now;
        if vehicle.sequence.takes(frame.sequence) {
            self.other_autopilot();
        }
        self.take(&frame.message, out);
    }

    /// A message of the autopilot.
    fn take(&mut self, message: &MavMessage, out: &mut Vec<u8>) {
        let now = self.times.now;
        let Some(vehicle) = &mut self.vehicle else {
            return;
        };
        match message {
            MavMessage::TIMESYNC(sync) => self.timesync(sync, out),
            MavMessage::PARAM_VALUE(value) => {
                self.parameters.take(vehicle.autopilot, value);
            }
            MavMessage::SYS_STATUS(status) => {
                let share = f64::from(status.battery_remaining) / 100.0;
                vehicle.battery = (0.0..=1.0).contains(&share).then_some(share);
            }
            MavMessage::STATUSTEXT(text) => {
                if let Ok(text) = text.text.to_str() {
                    self.notes.push(format!("autopilot: {text}"));
                }
            }
            MavMessage::AUTOPILOT_VERSION(version) => {
                vehicle.firmware = Some(Firmware::of(version.flight_sw_version));
            }
            MavMessage::CURRENT_MODE(mode) => {
                let armed = vehicle.armed;
                self.mode(mode.custom_mode, armed);
            }
            MavMessage::ATTITUDE_TARGET(target) => self.echoed(f64::from(target.thrust)),
            MavMessage::COMMAND_ACK(answer) => self.answered(answer),
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
            self.notice_another(frame, heartbeat);
            return;
        };
        let now = self.times.now;
        let armed = heartbeat
            .base_mode
            .contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        let Some(vehicle) = &mut self.vehicle else {
            self.vehicle = Some(Vehicle {
                system: frame.system,
                autopilot,
                firmware: None,
                armed,
                following: autopilot.follows(heartbeat.custom_mode),
                mode_us: now,
                heard_us: now,
                battery: None,
                sequence: Sequence {
                    last: frame.sequence,
                    ..Sequence::default()
                },
            });
            self.inbox.hears(autopilot);
            self.encoder.system = frame.system;
            let (name, system) = (autopilot.name(), frame.system);
            self.notes.push(format!("{name}, system id {system}"));
            self.enter(Stage::Checking);
            if autopilot.follows(heartbeat.custom_mode) {
                self.refuse_early();
            }
            return;
        };
        vehicle.heard_us = now;
        let two = vehicle.sequence.takes(frame.sequence);
        if two || vehicle.autopilot != autopilot {
            self.other_autopilot();
            return;
        }
        self.mode(heartbeat.custom_mode, armed);
    }

    /// Says once that an autopilot is heard which is not the one that the settings name, or not of a kind that can be flown.
    fn notice_another(&mut self, frame: &Frame, heartbeat: &HEARTBEAT_DATA) {
        if self.vehicle.is_some() || self.hints.another || frame.component != AUTOPILOT {
            return;
        }
        let (wanted, found) = (self.settings.system_id, frame.system);
        let HEARTBEAT_DATA {
            autopilot: firmware,
            mavtype,
            ..
        } = heartbeat;
        let note = match Autopilot::of(*firmware, *mavtype) {
            Some(autopilot) => format!(
                "system_id: expected an autopilot with system id {wanted}, found {} with system id {found}: it is ignored",
                autopilot.name()
            ),
            None if wanted == 0 || wanted == found => format!(
                "expected PX4 or ArduPilot of a multirotor, found {firmware:?} of {mavtype:?} with system id {found}: it is ignored"
            ),
            // Others may share the link with the one that is waited for.
            None => return,
        };
        self.hints.another = true;
        self.notes.push(note);
    }

    /// Says once that no autopilot has been heard for long.
    pub(super) fn notice_silence(&mut self) {
        let began = *self.hints.began.get_or_insert(self.times.now);
        if self.vehicle.is_none()
            && !self.hints.silence
            && !self.hints.another
            && self.times.now - began > UNHEARD_US
        {
            self.hints.silence = true;
            self.notes.push(format!(
                "no heartbeat of an autopilot for {} s: `link` must be the port to which it sends, at its speed",
                UNHEARD_US / 1_000_000
            ));
        }
    }

    /// The autopilot reports its mode.
    fn mode(&mut self, custom_mode: u32, armed: bool) {
        let now = self.times.now;
        let Some(vehicle) = &mut self.vehicle else {
            return;
        };
        let following = vehicle.autopilot.follows(custom_mode);
        let switched = following && !vehicle.following;
        (vehicle.following, vehicle.armed) = (following, armed);
        // A report that has waited does not show who flies now, unless it is somebody else.
        if !following || !self.times.catches_up() {
            vehicle.mode_us = now;
        }
        match self.stage {
            Stage::Ready if switched && armed => {
                self.echo.begin(now);
                self.enter(Stage::InControl);
            }
            Stage::Waiting | Stage::Checking | Stage::Checked if switched => self.refuse_early(),
            Stage::InControl | Stage::HandingOver if !following => self.end(Ending::PilotTookOver),
            Stage::InControl | Stage::HandingOver if !armed => self.end(Ending::Disarmed),
            Stage::Landed if !armed => self.end(Ending::Landed),
            Stage::Landed if !following => self.end(Ending::PilotTookOver),
            _ => {}
        }
    }

    /// The vehicle is in the mode that follows setpoints before the companion is ready.
    fn refuse_early(&mut self) {
        if let Some(vehicle) = &self.vehicle {
            let mode = vehicle.autopilot.follows_in();
            self.notes.push(format!(
                "{mode} before the companion is ready: no setpoints until the pilot leaves {mode} and switches to it again"
            ));
        }
    }

    /// Whether the vehicle is in the air and does not follow setpoints.
    pub(super) fn flies(&self, vehicle: &Vehicle) -> bool {
        let airborne = self.inbox.range_m().is_some_and(|range| range > AIRBORNE_M);
        vehicle.armed && !vehicle.following && airborne
    }

    /// The autopilot reports the thrust that it follows.
    fn echoed(&mut self, thrust: f64) {
        let (Some(vehicle), now) = (self.vehicle, self.times.now) else {
            return;
        };
        self.echo.hears(thrust, now);
        let fresh = self.inbox.age_s(Source::Imu, now) < self.settings.limits.stale_s;
        if self.flies(&vehicle) && fresh {
            let gravity = self.settings.vehicle.gravity_mps2;
            self.echo.hovers(thrust, self.inbox.force_mps2() / gravity);
        }
    }

    /// Takes the answer to a command, and notes a refusal.
    fn answered(&mut self, answer: &COMMAND_ACK_DATA) {
        let ours = [0, self.encoder.system].contains(&answer.target_system);
        let refused = !matches!(
            answer.result,
            MavResult::MAV_RESULT_ACCEPTED | MavResult::MAV_RESULT_IN_PROGRESS
        );
        let told = matches!(
            answer.command,
            MavCmd::MAV_CMD_DO_SET_MODE | MavCmd::MAV_CMD_COMPONENT_ARM_DISARM
        );
        let mode = answer.command == MavCmd::MAV_CMD_DO_SET_MODE;
        let accepted = answer.result == MavResult::MAV_RESULT_ACCEPTED;
        if ours && mode && accepted && self.stage == Stage::HandingOver {
            self.hold_accepted = true;
        }
        if ours && refused && told {
            let (command, result) = (answer.command, answer.result);
            self.notes
                .push(format!("the autopilot answers {command:?} with {result:?}"));
        }
    }

    /// Two autopilots share a system id, so the origin of readings is ambiguous.
    fn other_autopilot(&mut self) {
        match self.stage {
            Stage::InControl => self.hand_over(Ending::OtherAutopilot),
            Stage::HandingOver | Stage::Restoring | Stage::Ended => {}
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
        match self.clock.answered(sync.ts1 / 1000, sync.tc1 / 1000, now) {
            SyncEvent::Nothing => return,
            SyncEvent::TwoClocks => {
                self.other_autopilot();
                return;
            }
            SyncEvent::Stepped => {}
        }
        self.inbox.forget();
        self.notes.push("the autopilot's clock stepped".to_string());
        match self.stage {
            Stage::InControl => self.hand_over(Ending::ClockStepped),
            Stage::Waiting | Stage::Checking | Stage::Checked | Stage::Ready => {
                // A restarted autopilot has forgotten rates, and maybe changed parameters.
                self.parameters.forget();
                self.rates_hz = None;
                self.memory = self.computer.initial(self.hover_throttle);
                self.enter(Stage::Checking);
            }
            Stage::Landed | Stage::HandingOver | Stage::Restoring | Stage::Ended => {}
        }
    }
}

/// Whether a message of another component contains the vehicle's pose.
fn places_the_vehicle(message: &MavMessage) -> bool {
    matches!(
        message,
        MavMessage::VISION_POSITION_ESTIMATE(_) | MavMessage::ODOMETRY(_)
    )
}
