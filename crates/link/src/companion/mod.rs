//! The control state machine of a companion: bytes with their arrival times and clock ticks go in, bytes to send come out.
//!
//! ```text
//! Waiting ─> Checking ─> Checked <─> Ready ─> InControl ─> Landed ──┬─> Restoring ─> Ended
//!                                                 │                 │
//!                                                 └──> HandingOver ─┘
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
//! | `InControl`, `Landed`, `HandingOver` | another mode | over |
//! | `InControl`, `HandingOver` | disarmed by another | over |
//! | `InControl` | the landing computer has stopped the rotors | `Landed` |
//! | `InControl` | a fault of [`Ending`], landing given up, Ctrl-C | `HandingOver` |
//! | `Landed` | disarmed, 5 s of silence, 5 s after Ctrl-C | over |
//! | `HandingOver` | 5 s | over |
//!
//! *Over* is `Restoring` if the companion has changed parameters, until all are written back or 5 s have passed, and
//! then `Ended`.
//!
//! - A mode in which the vehicle already is does not count: the pilot must switch while the companion is `Ready`.
//! - The mode is that of the newest heartbeat or `CURRENT_MODE`.
//! - Setpoints are sent in `Ready` (PX4 demands a stream before the switch), `InControl` and `Landed` (thrust zero).
//! - In `HandingOver` the companion sends no setpoint. It asks for a mode that holds the position, later for one that
//!   holds the altitude, until the autopilot accepts, and as long as a mode report younger than 1.5 s shows that nobody
//!   else has changed the mode. The autopilot's own failsafe acts at the same time, because setpoints have ended.
//! - The disarm in `Landed` is repeated under the same condition: a pilot who takes off again is not disarmed.
//! - Parameters are written back only after the vehicle has left OFFBOARD or GUIDED, or is disarmed.
//! - `Ended` is for good: nothing but heartbeats is sent.
//!
//! The landing computer runs from `Checking` on, so that it knows the deck when control begins. Until then its controller
//! starts again in every step: its integrals do not wind up while the pilot flies.

mod camera;
mod echo;
mod lift;
mod messages;
mod restore;
mod send;
pub(crate) mod state;
mod status;
mod step;
mod summary;
#[cfg(test)]
mod tests;
mod touch;
mod vehicle;

pub use state::{FlightState, Publication};
pub use summary::Summary;
pub use touch::EstimatedTouch;

use mavlink::dialects::common::MavMessage;
use serde::Serialize;
use touchdown_flight::ground_effect::{GroundEffect, Guarded};
use touchdown_flight::{Attitude, SettingsError};
use touchdown_lander::computer::{Computer, ComputerOutput, ComputerState};

use crate::camera::{CameraReport, CameraWatch};
use crate::checklist::{Checklist, Facts, Thrust, Verdict};
use crate::clock::ClockSync;
use crate::parameters::Parameters;
use crate::readings::Inbox;
use crate::settings::FlightSettings;
use crate::timing::Distribution;
use crate::wire::signing::{Signer, Signing, Verifier};
use crate::wire::{Decoder, Encoder};
use echo::Echo;
use lift::Lift;
use state::Timing;
use touch::TouchWatch;
use vehicle::{Hints, Vehicle};

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
    /// Changed parameters are written back.
    Restoring,
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
    /// The autopilot talks, but its mode is no longer known.
    ModeUnknown,
    /// Attitude or specific force fell silent.
    Stale,
    /// The autopilot's clock stepped, as after a restart.
    ClockStepped,
    /// The attitude jumped, as by a reset of the autopilot's estimator.
    EstimatorReset,
    /// Another autopilot with the same system id.
    OtherAutopilot,
    /// The autopilot follows other setpoints than those that were sent.
    Rejected,
    /// The landing computer gave up.
    GivenUp,
    /// The landing computer's command was not finite.
    NotFinite,
    /// Ctrl-C, or the recording failed.
    Stopped,
}

/// What happens to a companion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// Bytes have arrived.
    Received(&'a [u8]),
    /// The camera has news.
    Camera(&'a CameraReport),
    /// A hundredth of a second has passed.
    Tick,
    /// The companion shall end.
    Stop,
}

/// What an operator allows in a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Session {
    /// Switch the vehicle to OFFBOARD or GUIDED, for simulators.
    pub take_control: bool,
    /// Change parameters that do not fit, and write them back at the end.
    pub set_parameters: bool,
    /// Sign outgoing frames, and ignore unsigned ones.
    pub signing: Option<Signing>,
}

/// The companion; see the [module](self).
#[derive(Clone)]
pub struct Companion {
    settings: FlightSettings,
    session: Session,
    computer: Computer<f64>,
    memory: Memory,
    hover_throttle: f64,
    decoder: Decoder,
    encoder: Encoder,
    clock: ClockSync,
    inbox: Inbox,
    camera: Option<CameraWatch>,
    vehicle: Option<Vehicle>,
    parameters: Parameters,
    /// From the throttle of the card to the thrust setpoint, as judged before control.
    thrust: Option<Thrust>,
    rates_hz: Option<[f64; 5]>,
    checklist: Checklist,
    stage: Stage,
    ending: Option<Ending>,
    notes: Vec<String>,
    other_senders: u64,
    /// What has been said before an autopilot was heard.
    hints: Hints,
    times: Times,
    echo: Echo,
    /// Whether the accelerometer feels the motors, in control.
    lift: Lift,
    /// Time between the newest two ticks, µs.
    elapsed_us: i64,
    /// Results of the landing computer at the newest tick.
    computed: Option<ComputerOutput<f64>>,
    /// The newest ones in control.
    output: Option<ComputerOutput<f64>>,
    touch: TouchWatch,
    in_control_us: i64,
    setpoints: u64,
    late_ticks: u64,
    /// Deviations of the period from a hundredth of a second.
    jitter: Distribution,
    /// Ages of the newest reading when a setpoint was sent.
    reading_ages: Distribution,
    /// Requests for a holding mode so far.
    hold_requests: u32,
    /// Whether the autopilot has accepted one of them: another one could take the mode from a pilot.
    hold_accepted: bool,
}

/// When things were last done, our time, µs.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    now: i64,
    tick: Option<i64>,
    /// When this process went on after it had stood still.
    resumed: Option<i64>,
    heartbeat: Option<i64>,
    sync: Option<i64>,
    requests: Option<i64>,
    rates: Option<i64>,
    checklist: Option<i64>,
    /// When the present stage began.
    stage: i64,
    /// The last command (mode, disarm or parameter).
    command: Option<i64>,
    /// Ctrl-C.
    stop: Option<i64>,
}

/// Time without a tick after which this process has stood still, µs: ten ticks. Half of it takes a busy computer for one; with
/// twice of it, a setpoint follows a take-over that was not read for 0.2 s.
const STANDSTILL_US: i64 = 100_000;
/// Time for which what is read afterwards may have waited, µs. The thread that reads the link needs some milliseconds.
const BACKLOG_US: i64 = 100_000;

impl Times {
    fn notice_a_standstill(&mut self) {
        if self
            .tick
            .is_some_and(|tick| self.now - tick > STANDSTILL_US)
        {
            self.resumed = Some(self.now);
        }
    }

    /// Whether reports may be older than they seem, because this process stood still.
    fn catches_up(&self) -> bool {
        let since = self.resumed.map(|resumed| self.now - resumed);
        since.is_some_and(|since| since < BACKLOG_US)
    }
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
    /// A companion that has heard nothing yet.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn new(settings: &FlightSettings, session: &Session) -> Result<Self, SettingsError> {
        let computer = settings.computer()?;
        let weight_n = settings.vehicle.mass_kg * settings.vehicle.gravity_mps2;
        let hover_throttle = settings.models.thrust.throttle_for(weight_n);
        let encoder = Encoder::new(settings.system_id.max(1), settings.component_id);
        Ok(Self {
            session: *session,
            memory: computer.initial(hover_throttle),
            computer,
            hover_throttle,
            decoder: Decoder::new(session.signing.map(Verifier::new)),
            encoder: encoder.signed(session.signing.map(Signer::new)),
            clock: ClockSync::default(),
            inbox: Inbox::new(settings),
            camera: settings.has_camera().then(CameraWatch::default),
            vehicle: None,
            parameters: Parameters::default(),
            thrust: None,
            rates_hz: None,
            checklist: Checklist::default(),
            stage: Stage::Waiting,
            ending: None,
            notes: Vec::new(),
            other_senders: 0,
            hints: Hints::default(),
            times: Times::default(),
            echo: Echo::default(),
            lift: Lift::default(),
            elapsed_us: 0,
            computed: None,
            output: None,
            touch: TouchWatch::default(),
            in_control_us: 0,
            setpoints: 0,
            late_ticks: 0,
            jitter: Distribution::default(),
            reading_ages: Distribution::default(),
            hold_requests: 0,
            hold_accepted: false,
            settings: settings.clone(),
        })
    }

    /// Handles an event at `at_us`, a time of a clock that never steps back. The bytes to send are appended to `out`.
    pub fn handle(&mut self, at_us: u64, event: Event<'_>, out: &mut Vec<u8>) {
        let now = i64::try_from(at_us).unwrap_or(i64::MAX).max(self.times.now);
        self.times.now = now;
        self.times.notice_a_standstill();
        match event {
            Event::Received(bytes) => {
                let unsigned = self.decoder.counts.unsigned;
                self.decoder.push(bytes);
                while let Some(frame) = self.decoder.next_frame() {
                    self.receive(&frame, out);
                }
                if unsigned == 0 && self.decoder.counts.unsigned > 0 {
                    self.notes.push(
                        "frames come that are not signed with the key of `signing.key_file`: they are ignored".to_string(),
                    );
                }
            }
            Event::Camera(report) => self.take_camera(report),
            Event::Tick => self.tick(out),
            Event::Stop => self.stop(out),
        }
    }

    /// The newest attitude, for whoever looks for the deck in images.
    #[must_use]
    pub fn attitude(&self) -> Option<Attitude<f64>> {
        self.inbox.attitude()
    }

    /// The state at the newest tick.
    #[must_use]
    pub fn state(&self) -> FlightState {
        let time_us = u64::try_from(self.times.now).unwrap_or_default();
        let computed = self.computed.as_ref();
        let computed = computed.map(|output| (output, self.inbox.attitude().unwrap_or_default()));
        let timing = Timing {
            period_s: self.elapsed_us as f64 * 1e-6,
            reading_age_s: self
                .inbox
                .newest_age_us(self.times.now)
                .map(|age_us| age_us as f64 * 1e-6),
            latency_s: self.latency_s(),
        };
        FlightState::new(time_us, (self.stage, self.ending), computed, timing)
    }

    /// Appends the request for a holding mode, while the companion is in control: for a caller that fails.
    pub fn hold_bytes(&self, out: &mut Vec<u8>) {
        if let (Some(vehicle), Stage::InControl) = (self.vehicle, self.stage) {
            let mut encoder = self.encoder.clone();
            let mode = vehicle.autopilot.modes().given_back[0];
            encoder.write_at(
                &messages::set_mode(vehicle.system, mode),
                self.times.now,
                out,
            );
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

    /// Ends the flight, because of `ending` or of the reason of the hand-over before.
    fn end(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
        let changed = self.parameters.unrestored().next().is_some();
        self.enter(if changed {
            Stage::Restoring
        } else {
            Stage::Ended
        });
    }

    fn hand_over(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
        self.enter(Stage::HandingOver);
    }

    fn stop(&mut self, out: &mut Vec<u8>) {
        self.times.stop.get_or_insert(self.times.now);
        match self.stage {
            Stage::InControl => {
                self.hand_over(Ending::Stopped);
                self.ask_to_hold(out);
            }
            // Rotors that idle on the deck are disarmed first.
            Stage::Landed | Stage::HandingOver | Stage::Restoring | Stage::Ended => {}
            _ => self.end(Ending::Stopped),
        }
    }

    fn send(&mut self, message: &MavMessage, out: &mut Vec<u8>) {
        self.encoder.write_at(message, self.times.now, out);
    }

    /// Judges the checklist again.
    fn judge(&mut self) -> Verdict {
        let Some(vehicle) = self.vehicle else {
            return Verdict::Waiting;
        };
        self.thrust = Thrust::of(
            vehicle.autopilot,
            self.settings.vehicle.throttle,
            &self.parameters,
        );
        self.checklist = Checklist::of(&Facts {
            settings: &self.settings,
            autopilot: vehicle.autopilot,
            firmware: vehicle.firmware,
            parameters: &self.parameters,
            rates_hz: self.rates_hz,
            sync: self.clock.report(),
            battery: vehicle.battery,
            hover_throttle: self.hover_throttle,
            hover_found: self.echo.hover(),
            echoes: self.echo.heard(),
            flies: self.flies(&vehicle),
            camera: self.camera.as_ref(),
        });
        self.checklist.verdict()
    }
}
