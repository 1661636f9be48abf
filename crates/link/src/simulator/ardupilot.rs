//! ArduPilot's JSON interface: `arducopter --model JSON`. Each datagram of motor signals is answered by a line of JSON.
//!
//! Motor signals, little endian: magic number 18458 (16 channels) or 29569 (32), frame rate (16 bits, Hz), frame count
//! (32 bits), then the channels as pulse widths (16 bits each, µs). 1000 µs stop a motor, 2000 µs are its greatest signal.
//!
//! The line has the keys `timestamp` (s), `imu` with `gyro` (rad/s) and `accel_body` (m/s²), `position` (m), `quaternion`,
//! `velocity` (m/s), `rng_1` (m) and `no_time_sync`, in north-east-down and forward-right-down. ArduPilot simulates GNSS,
//! barometer and magnetometer itself, from place and attitude. Its parser searches for each key as text, so that no key may
//! be part of another one before it.
//!
//! ArduPilot waits for the line. If none comes for a second it sends its motor signals again, with the same frame count;
//! such a datagram is answered by the same line. A frame count that begins again is an ArduPilot that has restarted.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use super::{Motors, SensorReport, StateReport};
use crate::axes;
use crate::error::LinkError;

/// Port of ArduPilot's instance 0.
pub const PORT: u16 = 9002;
/// Real time for which a datagram is waited for.
const WAIT: Duration = Duration::from_millis(200);
/// Waits in vain, in a row, that are an error: 10 s of silence.
const MOST_WAITS: u32 = 50;
const MAGIC_16: u16 = 18_458;
const MAGIC_32: u16 = 29_569;
const HEADER: usize = 8;

/// Motor signals of ArduPilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoFrame {
    /// Steps per second that ArduPilot asks for, Hz.
    pub rate_hz: u16,
    /// Number of the frame.
    pub count: u32,
    /// Pulse widths of the first 16 channels, µs.
    pub pulse_us: [u16; 16],
}

impl ServoFrame {
    /// Reads a datagram; none if it is not one of motor signals.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let word = |at: usize| Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]));
        let channels = match word(0)? {
            MAGIC_16 => 16,
            MAGIC_32 => 32,
            _ => return None,
        };
        if bytes.len() != HEADER + 2 * channels {
            return None;
        }
        let mut pulse_us = [0; 16];
        for (k, pulse) in pulse_us.iter_mut().enumerate() {
            *pulse = word(HEADER + 2 * k)?;
        }
        Some(Self {
            rate_hz: word(2)?,
            count: u32::from(word(4)?) | u32::from(word(6)?) << 16,
            pulse_us,
        })
    }

    /// Signals of the motors on the first four channels.
    #[must_use]
    pub fn motors(&self) -> Motors {
        let signal = |k: usize| (f64::from(self.pulse_us[k]) - 1000.0) / 1000.0;
        Motors::numbered([signal(0), signal(1), signal(2), signal(3)])
    }
}

/// Appends the line of a sample. What is missing of an inertial unit that fails is zero.
pub fn line(sensors: &SensorReport, state: &StateReport, out: &mut String) {
    let triple = |v: touchdown_flight::Vector<f64>| format!("[{:.7}, {:.7}, {:.7}]", v.x, v.y, v.z);
    let rates = axes::body(sensors.rates.unwrap_or_default());
    let force = axes::body(sensors.specific_force_mps2.unwrap_or_default());
    let [w, x, y, z] = axes::quaternion(state.attitude).unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let _ = write!(
        out,
        "\n{{\"timestamp\":{:.6},\"imu\":{{\"gyro\":{},\"accel_body\":{}}},\"position\":{},\"velocity\":{},\
         \"quaternion\":[{w:.9}, {x:.9}, {y:.9}, {z:.9}]",
        sensors.time_us as f64 * 1e-6,
        triple(rates),
        triple(force),
        triple(axes::world(state.position_m)),
        triple(axes::world(state.velocity_mps)),
    );
    if let Some(range_m) = sensors.range_m {
        let _ = write!(out, ",\"rng_1\":{range_m:.4}");
    }
    out.push_str(",\"no_time_sync\":1}\n");
}

/// An ArduPilot that sends to our port.
pub struct ArduPilot {
    socket: UdpSocket,
    peer: Option<SocketAddr>,
    last: Option<u32>,
    line: String,
    /// Datagrams that were no motor signals.
    pub strays: u64,
    /// Lines that were sent again.
    pub repeated: u64,
}

fn broken(source: std::io::Error) -> LinkError {
    LinkError::Link {
        address: "ArduPilot's simulator link".to_string(),
        source,
    }
}

impl ArduPilot {
    /// Waits on a UDP port; 0 for a free one.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn bind(port: u16) -> Result<Self, LinkError> {
        let socket = UdpSocket::bind(("127.0.0.1", port)).map_err(broken)?;
        socket.set_read_timeout(Some(WAIT)).map_err(broken)?;
        Ok(Self {
            socket,
            peer: None,
            last: None,
            line: String::with_capacity(512),
            strays: 0,
            repeated: 0,
        })
    }

    /// The port.
    ///
    /// # Errors
    /// A broken socket.
    pub fn port(&self) -> Result<u16, LinkError> {
        self.socket
            .local_addr()
            .map(|address| address.port())
            .map_err(broken)
    }

    /// The first motor signals, if they have come within 200 ms.
    ///
    /// # Errors
    /// A broken socket.
    pub fn connect(&mut self) -> Result<Option<Motors>, LinkError> {
        Ok(self.receive()?.map(|frame| frame.motors()))
    }

    /// Answers the last motor signals with a sample and waits for the next ones.
    ///
    /// # Errors
    /// ArduPilot is silent for 10 s, or has restarted.
    pub fn exchange(
        &mut self,
        sensors: &SensorReport,
        state: &StateReport,
    ) -> Result<Motors, LinkError> {
        self.line.clear();
        line(sensors, state, &mut self.line);
        self.send()?;
        let mut waits = 0;
        loop {
            let before = self.last;
            match self.receive()? {
                Some(frame) if before == Some(frame.count) => {
                    self.repeated += 1;
                    self.send()?;
                }
                Some(frame) if before.is_some_and(|before| frame.count < before) => {
                    return Err(broken(ErrorKind::ConnectionReset.into()));
                }
                Some(frame) => return Ok(frame.motors()),
                None if waits == MOST_WAITS => return Err(broken(ErrorKind::TimedOut.into())),
                None => waits += 1,
            }
        }
    }

    fn send(&mut self) -> Result<(), LinkError> {
        let Some(peer) = self.peer else { return Ok(()) };
        match self.socket.send_to(self.line.as_bytes(), peer) {
            Ok(_) => Ok(()),
            Err(e) if e.kind() == ErrorKind::ConnectionRefused => Ok(()),
            Err(e) => Err(broken(e)),
        }
    }

    fn receive(&mut self) -> Result<Option<ServoFrame>, LinkError> {
        let mut buffer = [0; 256];
        match self.socket.recv_from(&mut buffer) {
            Ok((length, from)) => {
                let Some(frame) = ServoFrame::read(&buffer[..length]) else {
                    self.strays += 1;
                    return Ok(None);
                };
                self.peer = Some(from);
                self.last = Some(frame.count);
                Ok(Some(frame))
            }
            Err(e)
                if matches!(
                    e.kind(),
                    ErrorKind::WouldBlock
                        | ErrorKind::TimedOut
                        | ErrorKind::Interrupted
                        | ErrorKind::ConnectionRefused
                ) =>
            {
                Ok(None)
            }
            Err(e) => Err(broken(e)),
        }
    }
}
