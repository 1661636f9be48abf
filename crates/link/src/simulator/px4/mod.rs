//! PX4's simulator protocol: MAVLink over TCP. PX4 connects as a client to port 4560 plus its instance, and we listen.
//!
//! | message | direction | when |
//! | --- | --- | --- |
//! | `HIL_SENSOR` | out | every 4 ms; its time becomes PX4's clock |
//! | `HIL_GPS`, `DISTANCE_SENSOR` | out | with each new reading |
//! | `HIL_STATE_QUATERNION` | out | every 8 ms, for PX4's log of the truth |
//! | `HIL_ACTUATOR_CONTROLS` | in | the answer to each `HIL_SENSOR` |
//!
//! In lockstep PX4's time stands between two `HIL_SENSOR`, so the next one is sent only after the answer. While PX4
//! starts, nothing drives its outputs yet and answers are missing: samples then follow each other after [`STARTUP_WAIT`].
//! Later an answer that is missing for [`ANSWER_WAIT`], or among [`MOST_READS`] pieces, is counted and the last signals stay.
//! [`MOST_MISSED`] missing answers in a row are an error. Without specific force and angular velocity PX4 does not answer:
//! while the inertial unit fails, the motors keep their last signals.
mod messages;
#[cfg(test)]
mod tests;

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use super::{Motors, SensorReport, StateReport};
use crate::error::LinkError;

pub use messages::{Answer, Px4Codec, clock_us};

/// Port of instance 0.
pub const PORT: u16 = 4560;
/// Time between two `HIL_SENSOR`, µs: PX4's start-up script sets 250 Hz for simulators.
pub const PERIOD_US: u64 = 4_000;
/// Real time between two samples while PX4 starts.
pub const STARTUP_WAIT: Duration = Duration::from_millis(4);
/// Real time after which an answer counts as missing. PX4 answers within 1 ms; a busy machine needs some tens.
pub const ANSWER_WAIT: Duration = Duration::from_millis(200);
/// Missing answers in a row that are an error: 10 s of silence.
pub const MOST_MISSED: u32 = 50;
/// Pieces of at most 4 KiB that are read while one answer is awaited. PX4 sends less than 1 KiB per sample. Without this
/// bound a peer that sends without end, and never the answer, would hold the simulation for ever. Half or twice the bound
/// changes nothing for PX4.
pub const MOST_READS: u32 = 64;

/// PX4, connected.
pub struct Px4<S> {
    stream: S,
    codec: Px4Codec,
    motors: Motors,
    /// Whether PX4 drives its outputs.
    answering: bool,
    missed_in_a_row: u32,
    /// Answers that were missing after the first one.
    pub missed: u64,
    bytes: Vec<u8>,
}

/// Listens for the PX4 of an instance.
///
/// # Errors
/// A port that is taken.
pub fn listen(instance: u16) -> Result<TcpListener, LinkError> {
    let port = PORT + instance;
    let listener = TcpListener::bind(("127.0.0.1", port)).and_then(|listener| {
        listener.set_nonblocking(true)?;
        Ok(listener)
    });
    listener.map_err(|source| LinkError::Link {
        address: format!("tcp port {port}"),
        source,
    })
}

/// The PX4 that has connected, if one has.
///
/// # Errors
/// A broken port.
pub fn accept(listener: &TcpListener) -> Result<Option<Px4<TcpStream>>, LinkError> {
    let accepted = match listener.accept() {
        Ok((stream, _)) => stream
            .set_nonblocking(false)
            .and_then(|()| stream.set_nodelay(true))
            .and_then(|()| stream.set_write_timeout(Some(ANSWER_WAIT * MOST_MISSED)))
            .map(|()| Some(Px4::new(stream))),
        Err(e) if e.kind() == ErrorKind::WouldBlock => Ok(None),
        Err(e) => Err(e),
    };
    accepted.map_err(broken)
}

fn broken(source: std::io::Error) -> LinkError {
    LinkError::Link {
        address: "PX4's simulator link".to_string(),
        source,
    }
}

/// A stream whose patience can be set.
pub trait PatientStream: Read + Write {
    /// Sets the longest time that a read waits.
    ///
    /// # Errors
    /// A broken stream.
    fn set_patience(&mut self, patience: Duration) -> std::io::Result<()>;
}

impl PatientStream for TcpStream {
    fn set_patience(&mut self, patience: Duration) -> std::io::Result<()> {
        self.set_read_timeout(Some(patience))
    }
}

impl<S: PatientStream> Px4<S> {
    /// A PX4 at the other end of a stream.
    pub fn new(stream: S) -> Self {
        Self {
            stream,
            codec: Px4Codec::default(),
            motors: Motors::default(),
            answering: false,
            missed_in_a_row: 0,
            missed: 0,
            bytes: Vec::with_capacity(512),
        }
    }

    /// Whether PX4 drives its outputs.
    #[must_use]
    pub fn answering(&self) -> bool {
        self.answering
    }

    /// Sends a sample and waits for the answer: the motors' signals until the next sample.
    ///
    /// # Errors
    /// PX4 has ended, or does not answer for 10 s.
    pub fn exchange(
        &mut self,
        sensors: &SensorReport,
        state: &StateReport,
    ) -> Result<Motors, LinkError> {
        self.bytes.clear();
        self.codec.write(sensors, state, &mut self.bytes);
        self.stream.write_all(&self.bytes).map_err(broken)?;
        let sent_us = clock_us(sensors.time_us);
        let felt = sensors.specific_force_mps2.is_some() && sensors.rates.is_some();
        let patience = if self.answering && felt {
            ANSWER_WAIT
        } else {
            STARTUP_WAIT
        };
        self.stream.set_patience(patience).map_err(broken)?;
        let mut buffer = [0; 4096];
        for _ in 0..MOST_READS {
            while let Some(answer) = self.codec.answer() {
                self.motors = answer.motors;
                self.answering = true;
                // An answer to an earlier sample came late: the one to this follows.
                if answer.time_us >= sent_us {
                    self.missed_in_a_row = 0;
                    return Ok(self.motors);
                }
            }
            match self.stream.read(&mut buffer) {
                Ok(0) => return Err(broken(ErrorKind::ConnectionAborted.into())),
                Ok(length) => self.codec.push(&buffer[..length]),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    return self.without_answer(felt);
                }
                Err(e) => return Err(broken(e)),
            }
        }
        self.without_answer(felt)
    }

    /// `expected`: PX4 has what it answers to.
    fn without_answer(&mut self, expected: bool) -> Result<Motors, LinkError> {
        if self.answering && expected {
            self.missed += 1;
            self.missed_in_a_row += 1;
            if self.missed_in_a_row >= MOST_MISSED {
                return Err(broken(ErrorKind::TimedOut.into()));
            }
        }
        Ok(self.motors)
    }
}
