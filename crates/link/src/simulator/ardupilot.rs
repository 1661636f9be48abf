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
use crate::transport::is_quiet;

/// Port of ArduPilot's instance 0.
pub const PORT: u16 = 9002;
/// Real time for which a datagram is waited for.
const WAIT: Duration = Duration::from_millis(200);
/// Waits in vain, in a row, that are an error: 10 s of silence. Motor signals that are repeated count as one each, so that a
/// peer that repeats them for ever does not hold the simulation.
const MOST_WAITS: u32 = 50;
/// ArduPilot cuts the difference of two stamps to whole microseconds. With stamps that are half a millionth long, rounding
/// never makes one of 2 ms a microsecond short.
const NEVER_SHORT: f64 = 1.0 + 5e-7;
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

/// Appends the line of a sample. Missing values of an inertial unit that fails are zero.
pub fn line(sensors: &SensorReport, state: &StateReport, out: &mut String) {
    let triple = |v: touchdown_flight::Vector<f64>| format!("[{:.7}, {:.7}, {:.7}]", v.x, v.y, v.z);
    let rates = axes::body(sensors.rates.unwrap_or_default());
    let force = axes::body(sensors.specific_force_mps2.unwrap_or_default());
    let [w, x, y, z] = axes::quaternion(state.attitude).unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let _ = write!(
        out,
        "\n{{\"timestamp\":{:.10},\"imu\":{{\"gyro\":{},\"accel_body\":{}}},\"position\":{},\"velocity\":{},\
         \"quaternion\":[{w:.9}, {x:.9}, {y:.9}, {z:.9}]",
        sensors.time_us as f64 * 1e-6 * NEVER_SHORT,
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
    /// ArduPilot is silent for 10 s, repeats itself without end, or has restarted.
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
                Some(frame) if before == Some(frame.count) && waits < MOST_WAITS => {
                    waits += 1;
                    self.repeated += 1;
                    self.send()?;
                }
                Some(frame) if before == Some(frame.count) => {
                    return Err(broken(ErrorKind::TimedOut.into()));
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
            Err(e) if is_quiet(&e) => Ok(None),
            Err(e) => Err(broken(e)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use touchdown_flight::{Attitude, Vector};

    /// A datagram of motor signals.
    fn datagram(count: u32, pulses: [u16; 4]) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend(MAGIC_16.to_le_bytes());
        bytes.extend(500_u16.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        for k in 0..16 {
            let pulse = pulses.get(k).copied().unwrap_or(0);
            bytes.extend(pulse.to_le_bytes());
        }
        bytes
    }

    fn state() -> StateReport {
        StateReport {
            position_m: Vector::new(1.0, 2.0, 3.0),
            velocity_mps: Vector::new(0.5, 0.25, -0.125),
            acceleration_mps2: Vector::ZERO,
            attitude: Attitude::LEVEL,
            rates: Vector::ZERO,
        }
    }

    fn report() -> SensorReport {
        SensorReport {
            time_us: 2_000,
            specific_force_mps2: Some(Vector::new(0.5, 0.25, 9.75)),
            rates: Some(Vector::new(0.125, 0.25, 0.5)),
            range_m: Some(0.85),
            ..SensorReport::default()
        }
    }

    #[test]
    fn analytic_pulses_become_signals_of_the_rotors() {
        let frame = ServoFrame::read(&datagram(70_000, [1000, 1250, 1500, 2000])).unwrap();
        assert_eq!((frame.rate_hz, frame.count), (500, 70_000));
        assert_eq!(frame.motors(), Motors([0.5, 0.25, 1.0, 0.0]));
    }

    #[test]
    fn analytic_a_line_is_json_in_north_east_down_that_a_search_for_its_keys_finds() {
        let mut text = String::new();
        line(&report(), &state(), &mut text);
        assert!(text.starts_with('\n') && text.ends_with('\n'));
        let json: serde_json::Value = serde_json::from_str(text.trim()).unwrap();
        assert_eq!(json["position"].to_string(), "[2.0,1.0,-3.0]");
        assert_eq!(json["velocity"].to_string(), "[0.25,0.5,0.125]");
        assert_eq!(json["imu"]["gyro"].to_string(), "[0.125,-0.25,-0.5]");
        assert_eq!(json["imu"]["accel_body"].to_string(), "[0.5,-0.25,-9.75]");
        // Level and pointing east: a yaw of 90 degrees.
        let half = 0.5_f64.sqrt();
        for (component, expected) in [half, 0.0, 0.0, half].into_iter().enumerate() {
            let found = json["quaternion"][component].as_f64().unwrap();
            // Nine decimals are printed.
            assert!((found - expected).abs() < 1e-9, "{json}");
        }
        assert_eq!(json["rng_1"], 0.85);
        // ArduPilot's parser looks for the first occurrence of a key, after which the value must follow at once.
        for key in ["position", "velocity", "quaternion", "gyro", "accel_body"] {
            assert_eq!(text.matches(key).count(), 1, "{key}");
            assert!(text.contains(&format!("\"{key}\":[")), "{key}");
        }
    }

    #[test]
    fn prop_stamps_of_2_ms_are_never_cut_to_less() {
        let stamp = |step: u64| {
            let sensors = SensorReport {
                time_us: 2_000 * step,
                ..report()
            };
            let mut text = String::new();
            line(&sensors, &state(), &mut text);
            let json: serde_json::Value = serde_json::from_str(text.trim()).unwrap();
            json["timestamp"].as_f64().unwrap()
        };
        // From the start, and after an hour.
        for step in (1..1000).chain(1_800_000..1_801_000) {
            // What ArduPilot computes.
            let cut_us = ((stamp(step + 1) - stamp(step)) * 1e6) as u64;
            assert_eq!(cut_us, 2_000, "{step}");
        }
    }

    #[test]
    fn prop_a_repeated_frame_is_answered_again_and_a_restart_is_an_error() {
        let mut ours = ArduPilot::bind(0).unwrap();
        let port = ours.port().unwrap();
        let theirs = UdpSocket::bind("127.0.0.1:0").unwrap();
        let send = |bytes: &[u8]| theirs.send_to(bytes, ("127.0.0.1", port)).unwrap();
        send(b"garbage");
        assert_eq!(ours.connect().unwrap(), None);
        send(&datagram(5, [1000; 4]));
        assert_eq!(ours.connect().unwrap(), Some(Motors::default()));
        send(&datagram(5, [1000; 4]));
        send(&datagram(6, [1500; 4]));
        let motors = ours.exchange(&report(), &state()).unwrap();
        assert_eq!(motors, Motors([0.5; 4]));
        assert_eq!((ours.repeated, ours.strays), (1, 1));
        let mut buffer = [0; 2048];
        let [first, again] = [0, 1].map(|_| theirs.recv(&mut buffer).unwrap());
        assert_eq!(first, again);
        send(&datagram(0, [1000; 4]));
        assert!(ours.exchange(&report(), &state()).is_err());
    }

    #[test]
    fn regress_a_flood_of_repeated_frames_is_an_error() {
        let mut ours = ArduPilot::bind(0).unwrap();
        let port = ours.port().unwrap();
        let theirs = UdpSocket::bind("127.0.0.1:0").unwrap();
        for _ in 0..=MOST_WAITS + 1 {
            theirs
                .send_to(&datagram(5, [1500; 4]), ("127.0.0.1", port))
                .unwrap();
        }
        assert!(ours.connect().unwrap().is_some());
        assert!(ours.exchange(&report(), &state()).is_err());
        assert_eq!(ours.repeated, u64::from(MOST_WAITS));
    }

    proptest! {
        #[test]
        fn prop_any_datagram_is_signals_in_their_range_or_none(
            bytes in proptest::collection::vec(any::<u8>(), 0..80), whole in any::<[u8; 36]>()) {
            let _ = ServoFrame::read(&bytes);
            let mut frame = MAGIC_16.to_le_bytes().to_vec();
            frame.extend(whole);
            frame.extend([0; 2]);
            let frame = ServoFrame::read(&frame).unwrap();
            prop_assert!(frame.motors().0.iter().all(|s| (0.0..=1.0).contains(s)));
        }
    }
}
