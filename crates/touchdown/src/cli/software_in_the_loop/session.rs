//! One landing: the world, the autopilot's links, pilot and companion, all in simulated time.
//!
//! The companion is the one of `touchdown fly`. Here its clock is the simulation's: bytes of the autopilot are given to it
//! at the simulated time at which they arrive, and it ticks every 10 ms of simulated time. So it flies at any speed of the
//! simulation, and no operating system delays its ticks.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use touchdown::{Error, Result};
use touchdown_lander::state_machine::{Phase, Reason};
use touchdown_link::LinkError;
use touchdown_link::companion::Stage as CompanionStage;
use touchdown_link::simulator::Motors;
use touchdown_link::simulator::pilot::{Pilot, Stage};
use touchdown_sim::landing::space::{MotorFlight, SpaceOutcome, Waits};

use super::companion::SimulatedCompanion;
use super::failure::{Attempt, Cause, Failure};
use super::frames::RenderedFrames;
use super::link::{Link, Opening};
use super::process::AutopilotProcess;
use super::truth::TruthTable;
use super::{Flown, world};
use crate::cli::context::Context;

/// Steps between two looks at the MAVLink port.
const LISTEN_STEPS: u64 = 2;
/// Steps between two ticks of pilot and companion.
const TICK_STEPS: u64 = 10;
/// Steps between two rows of the truth.
const TRUTH_STEPS: u64 = 10;
/// Longest time before the vehicle holds above the deck, s: ArduPilot's filter takes 40 s to trust its GNSS.
const TAKE_OFF_S: f64 = 150.0;
/// Time from the release of the deck to the landing's begin, s: the deck speeds up within 2 s.
const RELEASED_S: f64 = 3.0;
/// Real time in which an autopilot must connect.
const CONNECT: Duration = Duration::from_secs(60);
/// Time that is flown on after the companion has given up, s.
const GIVEN_UP_S: f64 = 2.0;
/// Time after which a companion that still checks tells what it refuses, s: its checklist takes 2 s where nothing is wrong.
const CHECKS_S: f64 = 5.0;
/// Height at which the deck is released where no pilot is, m.
const RELEASE_M: f64 = 0.5;

/// Who lands the vehicle.
pub(super) enum LandedBy {
    /// The user's own ground station.
    GroundStation,
    /// The autopilot's own landing mode.
    AutopilotMode,
    /// The companion.
    Companion(Box<SimulatedCompanion>),
}

/// The autopilot and who lands it.
pub(super) struct Participants<'a> {
    /// The autopilot's process, if this command has started it.
    pub(super) process: Option<&'a AutopilotProcess>,
    /// Port at which the autopilot's MAVLink arrives, if this command listens.
    pub(super) mavlink: Option<UdpSocket>,
    pub(super) landed_by: LandedBy,
    /// The camera, if it renders its frames.
    pub(super) camera: Option<RenderedFrames>,
}

/// The landing while it runs.
pub(super) struct Session<'a> {
    context: &'a Context,
    world: MotorFlight<'a>,
    link: Link,
    participants: Participants<'a>,
    pilot: Pilot,
    peer: Option<SocketAddr>,
    limits: Limits,
    step: u64,
    motors: Motors,
    released_s: Option<f64>,
    landing: bool,
    ended_s: Option<f64>,
    phase: Option<Phase>,
    waits: Waits,
    /// Time at which the refused items of the checklist are printed, s.
    tells_s: Option<f64>,
    /// Why the landing was interrupted or given up last.
    reason: Option<Reason>,
    truth: TruthTable,
    bytes: Vec<u8>,
}

/// Limits of a landing.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub(super) range_limits_m: [f64; 2],
    pub(super) hold_height_m: f64,
    pub(super) timeout_s: f64,
    pub(super) speed: f64,
    /// Whether progress is reported on the terminal.
    pub(super) verbose: bool,
}

impl<'a> Session<'a> {
    /// Waits for the autopilot at an open port.
    pub(super) fn connect(
        context: &'a Context,
        world: MotorFlight<'a>,
        opening: Opening,
        participants: Participants<'a>,
        limits: Limits,
        parameters: &[(String, f64)],
    ) -> Attempt<Self> {
        let asked = Instant::now();
        let process = participants.process;
        let given_up = || process.is_some_and(|p| p.ended().is_some() || asked.elapsed() > CONNECT);
        let report = |text: &str| {
            if limits.verbose {
                context.aside(text);
            }
        };
        let Some((link, motors)) = opening.connect(given_up, report)? else {
            return Err(Failure::of_autopilot(
                process,
                false,
                LinkError::Link {
                    address: "the autopilot's simulator link".to_string(),
                    source: ErrorKind::TimedOut.into(),
                },
            ));
        };
        Ok(Self {
            context,
            world,
            link,
            participants,
            pilot: Pilot::new(limits.hold_height_m, parameters),
            peer: None,
            limits,
            step: 0,
            motors,
            released_s: None,
            landing: false,
            ended_s: None,
            phase: None,
            waits: Waits::default(),
            tells_s: None,
            reason: None,
            truth: TruthTable::default(),
            bytes: Vec::with_capacity(2048),
        })
    }

    /// Flies until the landing has ended.
    pub(super) fn run(mut self) -> Attempt<Flown> {
        let start = Instant::now();
        let outcome = loop {
            if let Some(outcome) = self.sample(start)? {
                break outcome;
            }
        };
        // A vehicle that fails above a deck that stands has not begun to land.
        if self.released_s.is_none() {
            return Err(Failure::at_take_off(&outcome));
        }
        let speed = self.world.time_s() / start.elapsed().as_secs_f64();
        let mut landing = self.world.finish(outcome);
        landing.landing.last_phase = self.phase;
        landing.landing.waits_for = self.phase.and_then(|phase| self.waits.longest(phase));
        Ok(Flown {
            speed,
            missed_answers: self.link.missed_answers(),
            landing,
            truth: self.truth,
            companion: match self.participants.landed_by {
                LandedBy::Companion(companion) => Some(companion.finish()?),
                LandedBy::GroundStation | LandedBy::AutopilotMode => None,
            },
            kept: None,
        })
    }

    /// One exchange with the autopilot, and the steps until the next.
    fn sample(&mut self, start: Instant) -> Attempt<Option<SpaceOutcome>> {
        let readings = self.world.take_readings();
        let truth = self.world.truth();
        let report = world::sensors(&readings, self.limits.range_limits_m);
        let exchanged = self.link.exchange(&report, &world::state(&truth));
        let (motors, steps) = exchanged.map_err(|error| {
            Failure::of_autopilot(self.participants.process, self.released_s.is_some(), error)
        })?;
        self.motors = motors;
        let now_us = world::microseconds(self.world.time_s());
        for sighting in &readings.sightings {
            if let Some(camera) = &mut self.participants.camera {
                camera.frame(sighting, now_us, &mut self.participants.landed_by)?;
            } else if let (LandedBy::Companion(companion), Some(system)) =
                (&mut self.participants.landed_by, self.pilot.system_id())
            {
                let age_us = world::microseconds(sighting.age_s);
                let taken_us = self.pilot.autopilot_us(now_us.saturating_sub(age_us));
                companion.sees(now_us, system, sighting.position_m, taken_us)?;
            }
        }
        for _ in 0..steps {
            let advanced = self.world.advance(world::signals(self.motors));
            if let Some(outcome) = advanced.map_err(Error::from)? {
                return Ok(Some(outcome));
            }
            self.step += 1;
            if let Some(outcome) = self.attend()? {
                return Ok(Some(outcome));
            }
        }
        self.pace(start);
        Ok(None)
    }

    /// Waits until as much real time has passed as the speed allows.
    fn pace(&self, start: Instant) {
        if self.limits.speed > 0.0 {
            let due = Duration::from_secs_f64(self.world.time_s() / self.limits.speed);
            if let Some(left) = due.checked_sub(start.elapsed()) {
                std::thread::sleep(left);
            }
        }
    }

    /// What is done beside the physics after a step.
    fn attend(&mut self) -> Attempt<Option<SpaceOutcome>> {
        let now_us = world::microseconds(self.world.time_s());
        if self.step.is_multiple_of(LISTEN_STEPS) {
            self.listen(now_us)?;
        }
        if self.step.is_multiple_of(TRUTH_STEPS) {
            self.truth.push(&self.world.truth());
        }
        if self.step.is_multiple_of(TICK_STEPS) {
            return self.tick(now_us);
        }
        Ok(None)
    }

    /// Gives pilot and companion what the autopilot has sent.
    fn listen(&mut self, now_us: u64) -> Result<()> {
        let mut buffer = [0; 2048];
        while let Some(socket) = &self.participants.mavlink {
            match socket.recv_from(&mut buffer) {
                Ok((length, from)) => {
                    self.peer = Some(from);
                    let bytes = &buffer[..length];
                    self.pilot.receive(now_us, bytes);
                    if let LandedBy::Companion(companion) = &mut self.participants.landed_by {
                        self.bytes.clear();
                        companion.receives(now_us, bytes, &mut self.bytes)?;
                        self.send();
                    }
                }
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                // Nobody listens at the other end yet.
                Err(e)
                    if matches!(
                        e.kind(),
                        ErrorKind::ConnectionRefused | ErrorKind::Interrupted
                    ) => {}
                Err(e) => {
                    return Err(LinkError::Link {
                        address: "the autopilot's MAVLink port".to_string(),
                        source: e,
                    }
                    .into());
                }
            }
        }
        for note in self.pilot.take_notes() {
            self.note(&format!("autopilot: {note}"));
        }
        Ok(())
    }

    /// Sends what is waiting. A datagram that is lost is as on any link.
    fn send(&mut self) {
        if let (Some(socket), Some(peer), false) =
            (&self.participants.mavlink, self.peer, self.bytes.is_empty())
        {
            let _ = socket.send_to(&self.bytes, peer);
        }
    }

    fn tick(&mut self, now_us: u64) -> Attempt<Option<SpaceOutcome>> {
        let truth = self.world.truth();
        let now_s = self.world.time_s();
        let [u, v, w] = truth.state.velocity_mps;
        let speed_mps = (u * u + v * v + w * w).sqrt();
        let height_m = truth.relative_m[2];
        self.bytes.clear();
        if self.participants.mavlink.is_some() {
            let mut bytes = std::mem::take(&mut self.bytes);
            self.pilot.tick(now_us, height_m, speed_mps, &mut bytes);
            self.bytes = bytes;
            self.send();
        }
        if let Some(fault) = self.pilot.fault(now_us) {
            return Err(Error::Arguments(fault).into());
        }
        let holds = match self.participants.landed_by {
            LandedBy::GroundStation => height_m > RELEASE_M,
            _ => self.pilot.stage() == Stage::Holding,
        };
        let Some(released_s) = self.released_s else {
            if holds {
                self.note(&format!(
                    "{now_s:.1} s: above the deck, which moves from now on"
                ));
                self.world.release_deck();
                self.released_s = Some(now_s);
            } else if now_s > TAKE_OFF_S && self.participants.process.is_some() {
                return Err(Failure::NotFlown(Cause::NeverHeld));
            }
            return Ok(None);
        };
        if now_s - released_s > RELEASED_S && !self.landing {
            self.landing = true;
            self.begin();
        }
        if self.landing {
            self.companion(now_us)?;
        }
        let over = now_s - released_s > self.limits.timeout_s;
        let gave_up = self
            .ended_s
            .is_some_and(|ended_s| now_s - ended_s > GIVEN_UP_S);
        let forever = matches!(self.participants.landed_by, LandedBy::GroundStation);
        Ok(match (over && !forever, gave_up) {
            (true, _) => Some(SpaceOutcome::TimedOut),
            (_, true) => Some(SpaceOutcome::GivenUp {
                reason: self.reason,
            }),
            _ => None,
        })
    }

    /// The landing begins.
    fn begin(&mut self) {
        match &self.participants.landed_by {
            LandedBy::AutopilotMode => {
                self.world.begin_descent();
                self.pilot.land();
            }
            LandedBy::GroundStation => self.world.begin_descent(),
            LandedBy::Companion(_) => {}
        }
    }

    /// A tick of the companion, and what its landing computer does.
    fn companion(&mut self, now_us: u64) -> Result<()> {
        let LandedBy::Companion(companion) = &mut self.participants.landed_by else {
            return Ok(());
        };
        self.bytes.clear();
        let mut bytes = std::mem::take(&mut self.bytes);
        let mut state = companion.tick(now_us, &mut bytes)?;
        self.bytes = bytes;
        let now_s = self.world.time_s();
        if state.stage != CompanionStage::Checking {
            self.tells_s = None;
        } else if now_s >= *self.tells_s.get_or_insert(now_s + CHECKS_S) {
            self.tells_s = Some(f64::INFINITY);
            state.notes.extend(companion.refusals());
        }
        for note in state.notes {
            self.note(&format!("{now_s:.1} s: companion: {note}"));
        }
        self.reason = state.reason.or(self.reason);
        if let Some(phase) = state.phase {
            self.waits.update(phase, state.waits_for);
        }
        if state.phase != self.phase {
            match state.phase {
                Some(Phase::Descend) => self.world.begin_descent(),
                Some(Phase::GoAround) => self.world.break_off(state.reason),
                _ => {}
            }
            self.phase = state.phase;
        }
        if state.stage == CompanionStage::Ended && !self.world.has_touched() {
            self.ended_s.get_or_insert(self.world.time_s());
        }
        self.send();
        Ok(())
    }

    fn note(&self, text: &str) {
        if self.limits.verbose {
            self.context.aside(text);
        }
    }
}
