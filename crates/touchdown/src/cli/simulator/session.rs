//! One landing: the world, the autopilot's links, pilot and companion, all in simulated time.
//!
//! The companion is the one of `touchdown fly`. Here its clock is the simulation's: bytes of the autopilot are given to it
//! at the simulated time at which they arrive, and it ticks every 10 ms of simulated time. So it flies at any speed of the
//! simulation, and no operating system delays its ticks.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use touchdown::{Error, Result};
use touchdown_lander::state_machine::Phase;
use touchdown_link::LinkError;
use touchdown_link::companion::Stage as CompanionStage;
use touchdown_link::simulator::ardupilot::ArduPilot;
use touchdown_link::simulator::pilot::{Pilot, Stage};
use touchdown_link::simulator::px4::{self, Px4};
use touchdown_link::simulator::{Motors, SensorReport, StateReport};
use touchdown_sim::landing::space::{MotorFlight, MotorLanding, SpaceOutcome};

use super::process::AutopilotProcess;
use super::seat::Seat;
use super::truth::TruthTable;
use super::world;
use crate::cli::context::Context;

/// Steps of the world in which the autopilot gets one sample: 4 ms for PX4, 2 ms for ArduPilot.
const PX4_STEPS: u64 = px4::PERIOD_US / 1000;
const ARDUPILOT_STEPS: u64 = 2;
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
/// Height at which the deck is released where no pilot is, m.
const RELEASE_M: f64 = 0.5;

/// The autopilot's link to the simulator.
pub(super) enum Link {
    /// PX4 has not connected.
    Px4Waiting(TcpListener),
    /// PX4.
    Px4(Px4<TcpStream>),
    /// ArduPilot.
    ArduPilot(ArduPilot),
}

/// Who lands.
pub(super) enum Lands {
    /// Whoever sits at the user's own ground station.
    Anyone,
    /// The autopilot's own mode.
    Autopilot,
    /// The companion.
    Companion(Box<Seat>),
}

/// What a landing needs beside the world.
pub(super) struct Crew {
    pub(super) link: Link,
    pub(super) process: Option<AutopilotProcess>,
    /// Port at which the autopilot's MAVLink arrives, if this command listens.
    pub(super) mavlink: Option<UdpSocket>,
    pub(super) lands: Lands,
}

/// A landing that has ended.
pub(super) struct Flown {
    pub(super) landing: MotorLanding,
    pub(super) truth: TruthTable,
    pub(super) seat: Option<Box<Seat>>,
    /// Real time factor while flying.
    pub(super) speed: f64,
    /// Answers that PX4 did not give, or lines that ArduPilot asked for again.
    pub(super) missed_answers: u64,
}

/// The landing while it runs.
pub(super) struct Session<'a> {
    context: &'a Context,
    world: MotorFlight<'a>,
    crew: Crew,
    pilot: Pilot,
    peer: Option<SocketAddr>,
    range_limits_m: [f64; 2],
    timeout_s: f64,
    speed: f64,
    step: u64,
    motors: Motors,
    released_s: Option<f64>,
    landing: bool,
    ended_s: Option<f64>,
    phase: Option<Phase>,
    truth: TruthTable,
    bytes: Vec<u8>,
}

/// Limits of a landing.
pub(super) struct Limits {
    pub(super) range_limits_m: [f64; 2],
    pub(super) hold_height_m: f64,
    pub(super) timeout_s: f64,
    pub(super) speed: f64,
}

impl<'a> Session<'a> {
    pub(super) fn new(
        context: &'a Context,
        world: MotorFlight<'a>,
        crew: Crew,
        limits: &Limits,
    ) -> Self {
        Self {
            context,
            world,
            crew,
            pilot: Pilot::new(limits.hold_height_m),
            peer: None,
            range_limits_m: limits.range_limits_m,
            timeout_s: limits.timeout_s,
            speed: limits.speed,
            step: 0,
            motors: Motors::default(),
            released_s: None,
            landing: false,
            ended_s: None,
            phase: None,
            truth: TruthTable::default(),
            bytes: Vec::with_capacity(2048),
        }
    }

    /// Flies until the landing has ended.
    pub(super) fn run(mut self) -> Result<Flown> {
        self.connect()?;
        let start = Instant::now();
        let (sampled, outcome) = loop {
            match self.sample(start) {
                Ok(None) => {}
                Ok(Some(outcome)) => break (self.world.time_s(), outcome),
                Err(error) => return Err(self.explained(error)),
            }
        };
        let missed_answers = match &self.crew.link {
            Link::Px4(px4) => px4.missed,
            Link::ArduPilot(ardupilot) => ardupilot.repeated,
            Link::Px4Waiting(_) => 0,
        };
        let seat = match self.crew.lands {
            Lands::Companion(seat) => Some(seat),
            Lands::Anyone | Lands::Autopilot => None,
        };
        Ok(Flown {
            landing: self.world.finish(outcome),
            truth: self.truth,
            seat,
            speed: sampled / start.elapsed().as_secs_f64(),
            missed_answers,
        })
    }

    /// Waits for the autopilot.
    fn connect(&mut self) -> Result<()> {
        let asked = Instant::now();
        loop {
            match &mut self.crew.link {
                Link::Px4Waiting(listener) => {
                    if let Some(px4) = px4::accept(listener)? {
                        self.crew.link = Link::Px4(px4);
                        return Ok(());
                    }
                    std::thread::sleep(Duration::from_millis(5));
                }
                Link::ArduPilot(ardupilot) => {
                    if let Some(motors) = ardupilot.connect()? {
                        self.motors = motors;
                        return Ok(());
                    }
                }
                Link::Px4(_) => return Ok(()),
            }
            let Some(process) = &self.crew.process else {
                continue;
            };
            if process.has_ended() || asked.elapsed() > CONNECT {
                let silent = LinkError::Link {
                    address: "the autopilot's simulator link".to_string(),
                    source: ErrorKind::TimedOut.into(),
                };
                return Err(self.explained(silent.into()));
            }
        }
    }

    /// One exchange with the autopilot, and the steps until the next.
    fn sample(&mut self, start: Instant) -> Result<Option<SpaceOutcome>> {
        let readings = self.world.take_readings();
        let truth = self.world.truth();
        let report = world::sensors(&readings, self.range_limits_m);
        let (motors, steps) = self.exchange(&report, &world::state(&truth))?;
        self.motors = motors;
        let now_us = world::microseconds(self.world.time_s());
        for sighting in &readings.sightings {
            if let (Lands::Companion(seat), Some(system)) =
                (&mut self.crew.lands, self.pilot.system_id())
            {
                let age_us = world::microseconds(sighting.age_s);
                let taken_us = self.pilot.autopilot_us(now_us.saturating_sub(age_us));
                seat.sees(now_us, system, sighting.position_m, taken_us)?;
            }
        }
        for _ in 0..steps {
            if let Some(outcome) = self.world.advance(world::signals(self.motors))? {
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

    fn exchange(&mut self, report: &SensorReport, state: &StateReport) -> Result<(Motors, u64)> {
        match &mut self.crew.link {
            Link::Px4(px4) => Ok((px4.exchange(report, state)?, PX4_STEPS)),
            Link::ArduPilot(ardupilot) => Ok((ardupilot.exchange(report, state)?, ARDUPILOT_STEPS)),
            Link::Px4Waiting(_) => Ok((Motors::default(), PX4_STEPS)),
        }
    }

    /// Waits until as much real time has passed as the speed allows.
    fn pace(&self, start: Instant) {
        if self.speed > 0.0 {
            let due = Duration::from_secs_f64(self.world.time_s() / self.speed);
            if let Some(left) = due.checked_sub(start.elapsed()) {
                std::thread::sleep(left);
            }
        }
    }

    /// What is done beside the physics after a step.
    fn attend(&mut self) -> Result<Option<SpaceOutcome>> {
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
        while let Some(socket) = &self.crew.mavlink {
            match socket.recv_from(&mut buffer) {
                Ok((length, from)) => {
                    self.peer = Some(from);
                    let bytes = &buffer[..length];
                    self.pilot.receive(now_us, bytes);
                    if let Lands::Companion(seat) = &mut self.crew.lands {
                        self.bytes.clear();
                        seat.receives(now_us, bytes, &mut self.bytes)?;
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
            self.context.aside(&format!("autopilot: {note}"));
        }
        Ok(())
    }

    /// Sends what is waiting. A datagram that is lost is as on any link.
    fn send(&mut self) {
        if let (Some(socket), Some(peer), false) =
            (&self.crew.mavlink, self.peer, self.bytes.is_empty())
        {
            let _ = socket.send_to(&self.bytes, peer);
        }
    }

    fn tick(&mut self, now_us: u64) -> Result<Option<SpaceOutcome>> {
        let truth = self.world.truth();
        let now_s = self.world.time_s();
        let [u, v, w] = truth.state.velocity_mps;
        let speed_mps = (u * u + v * v + w * w).sqrt();
        let height_m = truth.relative_m[2];
        self.bytes.clear();
        if self.crew.mavlink.is_some() {
            let mut bytes = std::mem::take(&mut self.bytes);
            self.pilot.tick(now_us, height_m, speed_mps, &mut bytes);
            self.bytes = bytes;
            self.send();
        }
        let holds = match self.crew.lands {
            Lands::Anyone => height_m > RELEASE_M,
            _ => self.pilot.stage() == Stage::Holding,
        };
        let Some(released_s) = self.released_s else {
            if holds {
                self.context.aside(&format!(
                    "{now_s:.1} s: above the deck, which moves from now on"
                ));
                self.world.release_deck();
                self.released_s = Some(now_s);
            } else if now_s > TAKE_OFF_S && self.crew.process.is_some() {
                return Err(Error::data(
                    "the autopilot",
                    format!("to hold above the deck within {TAKE_OFF_S} s"),
                    "a vehicle that does not; its messages are above",
                ));
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
        let over = now_s - released_s > self.timeout_s;
        let gave_up = self
            .ended_s
            .is_some_and(|ended_s| now_s - ended_s > GIVEN_UP_S);
        let forever = matches!(self.crew.lands, Lands::Anyone);
        Ok(match (over && !forever, gave_up) {
            (true, _) => Some(SpaceOutcome::TimedOut),
            (_, true) => Some(SpaceOutcome::GivenUp { reason: None }),
            _ => None,
        })
    }

    /// The landing begins.
    fn begin(&mut self) {
        match &self.crew.lands {
            Lands::Autopilot => {
                self.world.begin_descent();
                self.pilot.land();
            }
            Lands::Anyone => self.world.begin_descent(),
            Lands::Companion(_) => {}
        }
    }

    /// A tick of the companion, and what its landing computer does.
    fn companion(&mut self, now_us: u64) -> Result<()> {
        let Lands::Companion(seat) = &mut self.crew.lands else {
            return Ok(());
        };
        self.bytes.clear();
        let mut bytes = std::mem::take(&mut self.bytes);
        let said = seat.tick(now_us, &mut bytes)?;
        self.bytes = bytes;
        for note in said.notes {
            let now_s = self.world.time_s();
            self.context
                .aside(&format!("{now_s:.1} s: companion: {note}"));
        }
        if said.phase != self.phase {
            match said.phase {
                Some(Phase::Descend) => self.world.begin_descent(),
                Some(Phase::GoAround) => self.world.break_off(),
                _ => {}
            }
            self.phase = said.phase;
        }
        if said.stage == CompanionStage::Ended && !self.world.has_touched() {
            self.ended_s.get_or_insert(self.world.time_s());
        }
        self.send();
        Ok(())
    }

    /// An error with the end of what the autopilot printed.
    fn explained(&self, error: Error) -> Error {
        match &self.crew.process {
            Some(process) => Error::data(
                "the autopilot",
                "an autopilot that flies",
                format!("{error}; it printed last:\n{}", process.last_words()),
            ),
            None => error,
        }
    }
}

/// Opens the port to which the autopilot sends MAVLink.
pub(super) fn mavlink_port(port: u16) -> Result<UdpSocket> {
    let opened = UdpSocket::bind(("127.0.0.1", port)).and_then(|socket| {
        socket.set_nonblocking(true)?;
        Ok(socket)
    });
    opened.map_err(|source| {
        LinkError::Link {
            address: format!("udp port {port}"),
            source,
        }
        .into()
    })
}

/// The file of a trial in the folder of results.
pub(super) fn file(out: &Path, stem: &str, trial: u64, ending: &str) -> PathBuf {
    out.join(format!("{stem}-{trial}.{ending}"))
}
