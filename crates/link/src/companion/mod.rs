//! The control state machine of a companion: bytes with their arrival times and clock ticks go in, bytes to send come out.
//!
//! ```text
//! Waiting ─> Checking ─> Checked <─> Ready ─> InControl ─> Landed ─> Ended
//!                                                 │                   ^
//!                                                 └──> HandingOver ───┘
//! ```
//!
//! | from | when | to |
//! | --- | --- | --- |
//! | `Waiting` | heartbeat of PX4 or ArduPilot with a multirotor | `Checking` |
//! | `Checking` | nothing on the checklist waits or is refused | `Checked` |
//! | `Checked` | armed, and position relative to the deck known | `Ready` |
//! | `Checked`, `Ready` | the checklist is refused | `Checking` |
//! | `Ready` | disarmed, or the position is no longer known | `Checked` |
//! | `Ready` | the pilot switches to OFFBOARD or GUIDED | `InControl` |
//! | `InControl`, `Landed`, `HandingOver` | another mode | `Ended` |
//! | `InControl` | disarmed by another | `Ended` |
//! | `InControl` | the landing computer has stopped the rotors | `Landed` |
//! | `InControl` | silence, stale readings, a stepped clock, another autopilot, landing given up, a command that is not finite, Ctrl-C | `HandingOver` |
//! | `Landed` | disarmed, or 5 s of silence | `Ended` |
//! | `HandingOver` | 5 s | `Ended` |
//!
//! - A mode in which the vehicle already is does not count: the pilot must switch while the companion is `Ready`.
//! - Setpoints are sent in `Ready` (PX4 demands a stream before the switch), `InControl` and `Landed` (thrust zero).
//! - In `HandingOver` the companion sends no setpoint. It asks for a mode that holds the position, later for one that
//!   holds the altitude. The autopilot's own failsafe acts at the same time, because setpoints have ended.
//! - `Ended` is for good: nothing but heartbeats is sent.
//!
//! The landing computer runs from `Checking` on, so that it knows the deck when control begins. Until then its controller
//! starts again in every step: its integrals do not wind up while the pilot flies.

mod messages;
mod step;
#[cfg(test)]
mod tests;
mod vehicle;

use std::collections::BTreeMap;

use mavlink::dialects::common::MavMessage;
use serde::Serialize;
use touchdown_flight::SettingsError;
use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_lander::computer::{Computer, ComputerOutput, ComputerState};

use crate::autopilot::Autopilot;
use crate::checklist::{Checklist, Facts, Verdict};
use crate::clock::{ClockSync, SyncReport};
use crate::readings::{IgnoredReadings, Inbox};
use crate::settings::FlightSettings;
use crate::wire::{Decoder, Encoder, WireCounts};
use vehicle::Vehicle;

type Memory = ComputerState<f64, <Guarded<f64> as GroundEffect<f64>>::State>;

/// Where the companion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// No autopilot has been heard.
    Waiting,
    /// The checklist is being filled.
    Checking,
    /// The checklist is good; the vehicle is not armed, or the deck not seen.
    Checked,
    /// Setpoints are streamed; the pilot may switch.
    Ready,
    /// The landing computer flies.
    InControl,
    /// On the deck; the rotors are being disarmed.
    Landed,
    /// The autopilot is asked to hold.
    HandingOver,
    /// Over.
    Ended,
}

/// Why control ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Landed and disarmed.
    Landed,
    /// The mode was changed.
    PilotTookOver,
    /// Another one disarmed the vehicle.
    Disarmed,
    /// The autopilot fell silent.
    Silent,
    /// Attitude or specific force fell silent.
    Stale,
    /// The autopilot's clock stepped, as after a restart.
    ClockStepped,
    /// A heartbeat of another autopilot with the same system id.
    OtherAutopilot,
    /// The landing computer gave up.
    GivenUp,
    /// The landing computer's command was not finite.
    NotFinite,
    /// Ctrl-C, or the recording failed.
    Stopped,
}

/// What happens to a companion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// Bytes have arrived.
    Received(&'a [u8]),
    /// A hundredth of a second has passed.
    Tick,
    /// The companion shall end.
    Stop,
}

/// What is said of a flight at its end.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The stage.
    pub stage: Stage,
    /// Why control ended, or was handed over.
    pub ending: Option<Ending>,
    /// The autopilot.
    pub autopilot: Option<Autopilot>,
    /// System id of the vehicle.
    pub system_id: Option<u8>,
    /// The checklist as it was last.
    pub checklist: Checklist,
    /// Synchronisation of the clocks.
    pub time: Option<SyncReport>,
    /// Time in control, s.
    pub in_control_s: f64,
    /// Setpoints sent while in control.
    pub setpoints: u64,
    /// Ticks that came more than 5 ms late.
    pub late_ticks: u64,
    /// Last phase of the landing computer in control.
    pub phase: Option<touchdown_lander::state_machine::Phase>,
    /// Frames on the wire.
    pub wire: WireCounts,
    /// Messages of other systems and components.
    pub other_senders: u64,
    /// Readings that were not used.
    pub ignored_readings: IgnoredReadings,
}

/// The companion; see the [module](self).
pub struct Companion {
    settings: FlightSettings,
    take_control: bool,
    computer: Computer<f64>,
    memory: Memory,
    hover_throttle: f64,
    decoder: Decoder,
    encoder: Encoder,
    clock: ClockSync,
    inbox: Inbox,
    vehicle: Option<Vehicle>,
    parameters: BTreeMap<&'static str, f64>,
    rates_hz: Option<[f64; 5]>,
    checklist: Checklist,
    stage: Stage,
    ending: Option<Ending>,
    notes: Vec<String>,
    other_senders: u64,
    times: Times,
    output: Option<ComputerOutput<f64>>,
    in_control_us: i64,
    setpoints: u64,
    late_ticks: u64,
    /// Requests for a holding mode so far.
    hold_requests: u32,
}

/// When things were last done, our time, µs.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    now: i64,
    tick: Option<i64>,
    heartbeat: Option<i64>,
    sync: Option<i64>,
    requests: Option<i64>,
    rates: Option<i64>,
    checklist: Option<i64>,
    /// When the present stage began.
    stage: i64,
    /// The last command (mode or disarm).
    command: Option<i64>,
}

/// Whether `period_us` have passed since `last`, which then becomes now.
fn due(last: &mut Option<i64>, now: i64, period_us: i64) -> bool {
    let due = last.is_none_or(|last| now - last >= period_us);
    if due {
        *last = Some(now);
    }
    due
}

impl Companion {
    /// A companion that has heard nothing yet. With `take_control` it switches the vehicle itself, for simulators.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn new(settings: &FlightSettings, take_control: bool) -> Result<Self, SettingsError> {
        let computer = settings.computer()?;
        let weight_n = settings.vehicle.mass_kg * settings.vehicle.gravity_mps2;
        let hover_throttle = settings.models.thrust.throttle_for(weight_n);
        Ok(Self {
            take_control,
            memory: computer.initial(hover_throttle),
            computer,
            hover_throttle,
            decoder: Decoder::default(),
            encoder: Encoder::new(settings.system_id.max(1), settings.component_id),
            clock: ClockSync::default(),
            inbox: Inbox::new(settings),
            vehicle: None,
            parameters: BTreeMap::new(),
            rates_hz: None,
            checklist: Checklist::default(),
            stage: Stage::Waiting,
            ending: None,
            notes: Vec::new(),
            other_senders: 0,
            times: Times::default(),
            output: None,
            in_control_us: 0,
            setpoints: 0,
            late_ticks: 0,
            hold_requests: 0,
            settings: settings.clone(),
        })
    }

    /// Handles an event at `at_us`, a time of a clock that never steps back. What is to be sent is appended to `out`.
    pub fn handle(&mut self, at_us: u64, event: Event<'_>, out: &mut Vec<u8>) {
        let now = i64::try_from(at_us).unwrap_or(i64::MAX).max(self.times.now);
        self.times.now = now;
        match event {
            Event::Received(bytes) => {
                self.decoder.push(bytes);
                while let Some(frame) = self.decoder.next_frame() {
                    self.receive(&frame, out);
                }
            }
            Event::Tick => self.tick(out),
            Event::Stop => self.stop(out),
        }
    }

    /// The stage.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// The checklist as it was last judged.
    #[must_use]
    pub fn checklist(&self) -> &Checklist {
        &self.checklist
    }

    /// What is worth saying since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// The bytes that ask for a holding mode, while the companion is in control: for a caller that fails.
    #[must_use]
    pub fn hold_bytes(&self) -> Option<Vec<u8>> {
        let vehicle = self.vehicle.filter(|_| self.stage == Stage::InControl)?;
        let mut bytes = Vec::new();
        let mut encoder = self.encoder;
        let mode = vehicle.autopilot.holding_modes()[0];
        encoder.write(&messages::set_mode(vehicle.system, mode), &mut bytes);
        Some(bytes)
    }

    /// What is said of the flight.
    #[must_use]
    pub fn summary(&self) -> Summary {
        Summary {
            stage: self.stage,
            ending: self.ending,
            autopilot: self.vehicle.map(|vehicle| vehicle.autopilot),
            system_id: self.vehicle.map(|vehicle| vehicle.system),
            checklist: self.checklist.clone(),
            time: self.clock.report(),
            in_control_s: self.in_control_us as f64 * 1e-6,
            setpoints: self.setpoints,
            late_ticks: self.late_ticks,
            phase: self.output.map(|output| output.state_machine.phase),
            wire: self.decoder.counts,
            other_senders: self.other_senders,
            ignored_readings: self.inbox.ignored,
        }
    }

    fn enter(&mut self, stage: Stage) {
        if stage == self.stage {
            return;
        }
        self.stage = stage;
        self.times.stage = self.times.now;
        self.times.command = None;
        let note = match (stage, self.ending) {
            (Stage::Ended | Stage::HandingOver, Some(ending)) => format!("{stage:?}: {ending:?}"),
            _ => format!("{stage:?}"),
        };
        self.notes.push(note);
    }

    /// Ends for good, because of `ending` or of what led to the hand-over before.
    fn end(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
        self.enter(Stage::Ended);
    }

    fn hand_over(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
        self.enter(Stage::HandingOver);
    }

    fn stop(&mut self, out: &mut Vec<u8>) {
        match self.stage {
            Stage::InControl => {
                self.hand_over(Ending::Stopped);
                self.ask_to_hold(out);
            }
            Stage::Landed => {
                self.disarm(out);
                self.end(Ending::Stopped);
            }
            Stage::HandingOver | Stage::Ended => {}
            _ => self.end(Ending::Stopped),
        }
    }

    fn send(&mut self, message: &MavMessage, out: &mut Vec<u8>) {
        self.encoder.write(message, out);
    }

    /// Judges the checklist anew.
    fn judge(&mut self) -> Verdict {
        let Some(vehicle) = self.vehicle else {
            return Verdict::Waiting;
        };
        self.checklist = Checklist::of(&Facts {
            settings: &self.settings,
            autopilot: vehicle.autopilot,
            parameters: &self.parameters,
            rates_hz: self.rates_hz,
            sync: self.clock.report(),
            battery: vehicle.battery,
            hover_throttle: self.hover_throttle,
        });
        self.checklist.verdict()
    }
}
