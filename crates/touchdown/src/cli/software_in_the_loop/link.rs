//! The autopilot's link to the simulator: first an open port, then a connection.

use std::cell::Cell;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use touchdown_link::LinkError;
use touchdown_link::simulator::ardupilot::ArduPilot;
use touchdown_link::simulator::px4::{self, Px4};
use touchdown_link::simulator::{Motors, SensorReport, StateReport};

/// Steps of the world per sample of PX4: 4 ms.
const PX4_STEPS: u64 = px4::PERIOD_US / 1000;
/// Steps of the world per sample of ArduPilot: 2 ms.
const ARDUPILOT_STEPS: u64 = 2;
/// Real time between two looks for PX4.
const LOOK: Duration = Duration::from_millis(5);
/// Real time after which a wait for an autopilot is reported: one that is started along with this command connects within a second.
const REPORTED: Duration = Duration::from_secs(3);

/// A port at which an autopilot is expected.
pub(super) enum Opening {
    /// PX4 connects to it.
    Px4(TcpListener),
    /// ArduPilot sends its motor signals to it.
    ArduPilot(ArduPilot),
}

/// A connected autopilot.
pub(super) enum Link {
    /// PX4.
    Px4(Px4<TcpStream>),
    /// ArduPilot.
    ArduPilot(ArduPilot),
}

impl Opening {
    /// The port, in words.
    fn address(&self) -> String {
        match self {
            Self::Px4(listener) => match listener.local_addr() {
                Ok(address) => format!("PX4 at TCP {address}"),
                Err(_) => "PX4".to_string(),
            },
            Self::ArduPilot(ardupilot) => match ardupilot.port() {
                Ok(port) => format!("ArduPilot at UDP 127.0.0.1:{port}"),
                Err(_) => "ArduPilot".to_string(),
            },
        }
    }

    /// Waits for the autopilot, with its first motor signals, until `given_up`; `report` gets a line if that takes long.
    pub(super) fn connect(
        self,
        given_up: impl Fn() -> bool,
        report: impl Fn(&str),
    ) -> Result<Option<(Link, Motors)>, LinkError> {
        let (asked, reported) = (Instant::now(), Cell::new(false));
        let address = self.address();
        let given_up = || {
            if asked.elapsed() > REPORTED && !reported.replace(true) {
                report(&format!("waits for {address}; Ctrl-C ends it"));
            }
            given_up()
        };
        match self {
            Self::Px4(listener) => {
                while !given_up() {
                    if let Some(px4) = px4::accept(&listener)? {
                        return Ok(Some((Link::Px4(px4), Motors::default())));
                    }
                    std::thread::sleep(LOOK);
                }
            }
            Self::ArduPilot(mut ardupilot) => {
                while !given_up() {
                    if let Some(motors) = ardupilot.connect()? {
                        return Ok(Some((Link::ArduPilot(ardupilot), motors)));
                    }
                }
            }
        }
        Ok(None)
    }
}

impl Link {
    /// Gives the autopilot a sample; returns its motor signals, and the steps of the world until the next sample.
    pub(super) fn exchange(
        &mut self,
        report: &SensorReport,
        state: &StateReport,
    ) -> Result<(Motors, u64), LinkError> {
        match self {
            Self::Px4(px4) => Ok((px4.exchange(report, state)?, PX4_STEPS)),
            Self::ArduPilot(ardupilot) => Ok((ardupilot.exchange(report, state)?, ARDUPILOT_STEPS)),
        }
    }

    /// Answers that PX4 did not give, or lines that ArduPilot asked for again.
    pub(super) fn missed_answers(&self) -> u64 {
        match self {
            Self::Px4(px4) => px4.missed,
            Self::ArduPilot(ardupilot) => ardupilot.repeated,
        }
    }
}
