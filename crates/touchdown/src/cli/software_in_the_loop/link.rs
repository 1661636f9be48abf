//! The autopilot's link to the simulator: first an open port, then a connection.

use std::net::{TcpListener, TcpStream};
use std::time::Duration;

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
    /// Waits for the autopilot, with its first motor signals, until `given_up`.
    pub(super) fn connect(
        self,
        given_up: impl Fn() -> bool,
    ) -> Result<Option<(Link, Motors)>, LinkError> {
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
