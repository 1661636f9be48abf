//! The pilot of a simulated flight: arms, takes off, holds above the deck, and lands in the autopilot's own mode if asked.
//!
//! | | PX4 | ArduPilot |
//! | --- | --- | --- |
//! | take-off | AUTO.TAKEOFF, then armed | GUIDED, armed, `MAV_CMD_NAV_TAKEOFF` |
//! | hold | AUTO.LOITER, by itself | LOITER, with centred sticks (`RC_CHANNELS_OVERRIDE`) |
//! | landing | AUTO.LAND | LAND |
//!
//! A companion takes over from the hold. The pilot then keeps silent but for heartbeats and centred sticks.

use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavMessage, MavModeFlag, MavState,
    MavType, RC_CHANNELS_OVERRIDE_DATA, TIMESYNC_DATA,
};

use super::asked::AskedParameters;
use crate::autopilot::{Autopilot, Mode};
use crate::clock::ClockSync;
use crate::wire::{Decoder, Encoder};

/// Ground station, as autopilots know one.
const SYSTEM: u8 = 255;
const COMPONENT: u8 = 190;
pub(super) const AUTOPILOT: u8 = 1;
pub(super) const SECOND_US: u64 = 1_000_000;
/// Time between two commands that are not answered yet, µs.
const COMMAND_US: u64 = SECOND_US;
/// Time between two stick positions, µs: ArduPilot forgets them after 3 s.
const STICKS_US: u64 = SECOND_US / 5;
/// Time between two questions for the autopilot's clock, µs.
const SYNC_US: u64 = SECOND_US / 2;
/// What tells the pilot's questions for the clock from those of a companion, µs: a fraction of its period of 10 ms, and small
/// against the error of the clock.
const PILOT_ASKS_US: i64 = 1;
/// Share of the height from which on the vehicle counts as up, and the speed below which it holds, m/s.
const UP_SHARE: f64 = 0.7;
const HOLDS_MPS: f64 = 0.15;
/// Time for which it must hold, µs.
const HOLDS_US: u64 = 2 * SECOND_US;

/// Where the pilot is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Waits for the autopilot, asks for take-off and arming.
    TakingOff,
    /// Climbs, or waits for the vehicle to hold.
    Climbing,
    /// Holds above the deck.
    Holding,
    /// Lands in the autopilot's own mode.
    Landing,
}

/// The pilot.
#[derive(Clone, Debug)]
pub struct Pilot {
    height_m: f64,
    decoder: Decoder,
    encoder: Encoder,
    stage: Stage,
    vehicle: Option<Vehicle>,
    notes: Vec<String>,
    parameters: AskedParameters,
    clock: ClockSync,
    sync_us: Option<u64>,
    heartbeat_us: Option<u64>,
    command_us: Option<u64>,
    sticks_us: Option<u64>,
    still_since_us: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Vehicle {
    autopilot: Autopilot,
    system: u8,
    armed: bool,
    custom_mode: u32,
}

impl Vehicle {
    /// Whether its last heartbeat reported a mode.
    fn in_mode(self, mode: Mode) -> bool {
        self.autopilot.in_mode(self.custom_mode, mode)
    }
}

/// Whether `period_us` have passed since `last`, which then becomes now.
pub(super) fn due(last: &mut Option<u64>, now: u64, period_us: u64) -> bool {
    let due = last.is_none_or(|last| now - last >= period_us);
    if due {
        *last = Some(now);
    }
    due
}

impl Pilot {
    /// A pilot who holds at a height above the place of the take-off. He arms only once the autopilot has reported these
    /// parameters.
    #[must_use]
    pub fn new(height_m: f64, parameters: &[(String, f64)]) -> Self {
        Self {
            height_m,
            decoder: Decoder::default(),
            encoder: Encoder::new(SYSTEM, COMPONENT),
            stage: Stage::TakingOff,
            vehicle: None,
            notes: Vec::new(),
            parameters: AskedParameters::new(parameters),
            clock: ClockSync::default(),
            sync_us: None,
            heartbeat_us: None,
            command_us: None,
            sticks_us: None,
            still_since_us: None,
        }
    }

    /// Where the pilot is.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// System id of the vehicle that was heard.
    #[must_use]
    pub fn system_id(&self) -> Option<u8> {
        self.vehicle.map(|vehicle| vehicle.system)
    }

    /// Whether the autopilot reports that it is armed.
    #[must_use]
    pub fn armed(&self) -> bool {
        self.vehicle.is_some_and(|vehicle| vehicle.armed)
    }

    /// What is wrong with the parameters that were asked for, once it is known.
    #[must_use]
    pub fn fault(&self, now_us: u64) -> Option<String> {
        self.parameters.fault(now_us)
    }

    /// Texts of the autopilot since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// The autopilot's time of one of ours, µs, once it has answered `TIMESYNC`.
    #[must_use]
    pub fn autopilot_us(&self, ours_us: u64) -> Option<u64> {
        let theirs = self.clock.theirs_us(i64::try_from(ours_us).ok()?)?;
        u64::try_from(theirs).ok()
    }

    /// Takes bytes of the autopilot.
    pub fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next_frame() {
            if frame.component != AUTOPILOT {
                continue;
            }
            match frame.message {
                MavMessage::HEARTBEAT(heartbeat) => {
                    if let Some(autopilot) = Autopilot::of(heartbeat.autopilot, heartbeat.mavtype) {
                        let armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
                        self.vehicle = Some(Vehicle {
                            autopilot,
                            system: frame.system,
                            armed: heartbeat.base_mode.contains(armed),
                            custom_mode: heartbeat.custom_mode,
                        });
                    }
                }
                MavMessage::TIMESYNC(sync) if sync.tc1 != 0 => {
                    let now = i64::try_from(now_us).unwrap_or(i64::MAX);
                    let (asked, theirs) = (sync.ts1 / 1000, sync.tc1 / 1000);
                    self.clock.answered(asked, theirs, now);
                }
                MavMessage::PARAM_VALUE(answer) => {
                    if let Some(vehicle) = self.vehicle {
                        self.parameters.take(vehicle.autopilot, &answer);
                    }
                }
                MavMessage::STATUSTEXT(text) => {
                    if let Ok(text) = text.text.to_str() {
                        self.notes.push(text.to_string());
                    }
                }
                _ => {}
            }
        }
    }

    /// Advances to a time and appends the bytes to send to `out`. Height above the take-off and speed are the truth.
    pub fn tick(&mut self, now_us: u64, height_m: f64, speed_mps: f64, out: &mut Vec<u8>) {
        if due(&mut self.heartbeat_us, now_us, SECOND_US) {
            self.encoder.write(&heartbeat(), out);
        }
        let Some(vehicle) = self.vehicle else { return };
        if due(&mut self.sync_us, now_us, SYNC_US) {
            let now = i64::try_from(now_us).unwrap_or(i64::MAX);
            // Pilot and companion have the same clock. A question that both asked would get two answers, from which the
            // companion concludes that there are two autopilots.
            let asked = now.saturating_add(PILOT_ASKS_US);
            self.clock.asks(asked);
            self.encoder.write(&question(asked), out);
        }
        if vehicle.autopilot == Autopilot::ArduPilot && due(&mut self.sticks_us, now_us, STICKS_US)
        {
            self.encoder.write(&centred(vehicle.system), out);
        }
        self.parameters
            .ask(now_us, vehicle.system, &mut self.encoder, out);
        match self.stage {
            Stage::TakingOff if !self.parameters.known() => {}
            Stage::TakingOff if vehicle.armed && height_m > UP_SHARE * self.height_m => {
                self.stage = Stage::Climbing;
            }
            Stage::TakingOff => {
                if due(&mut self.command_us, now_us, COMMAND_US) {
                    self.take_off(vehicle, out);
                }
            }
            Stage::Climbing => self.climb(vehicle, now_us, speed_mps, out),
            Stage::Landing => {
                let wanted = vehicle.autopilot.modes().landing;
                let done = !vehicle.armed || vehicle.in_mode(wanted);
                if !done && due(&mut self.command_us, now_us, COMMAND_US) {
                    self.set_mode(vehicle, wanted, out);
                }
            }
            Stage::Holding => {}
        }
    }

    /// Lands in the autopilot's own mode from now on.
    pub fn land(&mut self) {
        self.stage = Stage::Landing;
        self.command_us = None;
    }

    fn take_off(&mut self, vehicle: Vehicle, out: &mut Vec<u8>) {
        let mode = vehicle.autopilot.modes().take_off;
        if !vehicle.in_mode(mode) {
            self.set_mode(vehicle, mode, out);
        }
        if !vehicle.armed {
            let arm = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
            self.command(vehicle, arm, [1.0, 0.0, 0.0], 0.0, out);
        } else if vehicle.autopilot == Autopilot::ArduPilot {
            let height = self.height_m as f32;
            self.command(vehicle, MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0; 3], height, out);
        }
    }

    fn climb(&mut self, vehicle: Vehicle, now_us: u64, speed_mps: f64, out: &mut Vec<u8>) {
        if speed_mps > HOLDS_MPS {
            self.still_since_us = None;
            return;
        }
        let since = *self.still_since_us.get_or_insert(now_us);
        let wanted = vehicle.autopilot.modes().hold;
        if !vehicle.in_mode(wanted) {
            // PX4 changes to it by itself at the end of the take-off.
            if due(&mut self.command_us, now_us, COMMAND_US) {
                self.set_mode(vehicle, wanted, out);
            }
        } else if now_us - since >= HOLDS_US {
            self.stage = Stage::Holding;
        }
    }

    fn set_mode(&mut self, vehicle: Vehicle, mode: Mode, out: &mut Vec<u8>) {
        let command = MavCmd::MAV_CMD_DO_SET_MODE;
        let [main, sub] = [mode.main, mode.sub].map(f32::from);
        self.command(vehicle, command, [1.0, main, sub], 0.0, out);
    }

    fn command(
        &mut self,
        vehicle: Vehicle,
        command: MavCmd,
        [param1, param2, param3]: [f32; 3],
        param7: f32,
        out: &mut Vec<u8>,
    ) {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            param1,
            param2,
            param3,
            param7,
            command,
            target_system: vehicle.system,
            target_component: AUTOPILOT,
            ..COMMAND_LONG_DATA::default()
        });
        self.encoder.write(&message, out);
    }
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_GCS,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}

/// A question for the autopilot's clock.
fn question(now_us: i64) -> MavMessage {
    MavMessage::TIMESYNC(TIMESYNC_DATA {
        ts1: now_us.saturating_mul(1000),
        ..TIMESYNC_DATA::default()
    })
}

/// Sticks in the middle; 0 leaves the other channels alone.
fn centred(system: u8) -> MavMessage {
    MavMessage::RC_CHANNELS_OVERRIDE(RC_CHANNELS_OVERRIDE_DATA {
        chan1_raw: 1500,
        chan2_raw: 1500,
        chan3_raw: 1500,
        chan4_raw: 1500,
        target_system: system,
        target_component: AUTOPILOT,
        ..RC_CHANNELS_OVERRIDE_DATA::default()
    })
}
