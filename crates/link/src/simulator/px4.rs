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
//! Later an answer that is missing for [`ANSWER_WAIT`] is counted and the last signals stay; [`MOST_MISSED`] in a row are an
//! error.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use mavlink::dialects::common::{
    DISTANCE_SENSOR_DATA, HIL_GPS_DATA, HIL_SENSOR_DATA, HIL_STATE_QUATERNION_DATA,
    HilSensorUpdatedFlags, MavDistanceSensor, MavMessage, MavSensorOrientation,
};
use touchdown_flight::Vector;

use super::{GnssReport, Motors, SensorReport, StateReport, place};
use crate::axes;
use crate::error::LinkError;
use crate::wire::{Decoder, Encoder, WireCounts};

/// Port of instance 0.
pub const PORT: u16 = 4560;
/// Time between two `HIL_SENSOR`, µs: PX4's start-up script sets 250 Hz for simulators.
pub const PERIOD_US: u64 = 4_000;
/// PX4's clock at the first sample, µs: PX4 takes a time of zero for no time.
const BOOT_US: u64 = 1_000_000;
/// Real time between two samples while PX4 starts.
pub const STARTUP_WAIT: Duration = Duration::from_millis(4);
/// Real time after which an answer counts as missing. PX4 answers within 1 ms; a busy machine needs some tens.
pub const ANSWER_WAIT: Duration = Duration::from_millis(200);
/// Missing answers in a row that are an error: 10 s of silence.
pub const MOST_MISSED: u32 = 50;
/// System id of the simulator.
const SYSTEM: u8 = 142;
const MAG_EVERY: u64 = 5;
const STATE_EVERY: u64 = 2;

/// The bytes of the protocol, without a socket.
#[derive(Clone, Debug)]
pub struct Px4Codec {
    decoder: Decoder,
    encoder: Encoder,
    samples: u64,
}

impl Default for Px4Codec {
    fn default() -> Self {
        Self {
            decoder: Decoder::default(),
            encoder: Encoder::new(SYSTEM, 1),
            samples: 0,
        }
    }
}

/// An answer of PX4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// PX4's time, µs.
    pub time_us: u64,
    /// The signals.
    pub motors: Motors,
}

/// PX4's time of a time since the start, µs.
#[must_use]
pub fn clock_us(time_us: u64) -> u64 {
    time_us + BOOT_US
}

impl Px4Codec {
    /// Appends the messages of a sample.
    pub fn write(&mut self, sensors: &SensorReport, state: &StateReport, out: &mut Vec<u8>) {
        let with_mag = self.samples.is_multiple_of(MAG_EVERY);
        let mut write = |message| self.encoder.write(&message, out);
        if let Some(gnss) = &sensors.gnss {
            write(MavMessage::HIL_GPS(gps(sensors.time_us, gnss)));
        }
        if let Some(range_m) = sensors.range_m {
            write(MavMessage::DISTANCE_SENSOR(distance(sensors, range_m)));
        }
        if self.samples.is_multiple_of(STATE_EVERY) {
            write(MavMessage::HIL_STATE_QUATERNION(truth(
                sensors.time_us,
                state,
            )));
        }
        // Last, because PX4 computes with everything that has arrived before.
        write(MavMessage::HIL_SENSOR(inertial(sensors, with_mag)));
        self.samples += 1;
    }

    /// Adds bytes of PX4.
    pub fn push(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
    }

    /// The next answer among them.
    pub fn answer(&mut self) -> Option<Answer> {
        while let Some(frame) = self.decoder.next_frame() {
            if let MavMessage::HIL_ACTUATOR_CONTROLS(controls) = frame.message {
                let [a, b, c, d, ..] = controls.controls.map(f64::from);
                return Some(Answer {
                    time_us: controls.time_usec,
                    motors: Motors::numbered([a, b, c, d]),
                });
            }
        }
        None
    }

    /// What was found among the bytes of PX4.
    #[must_use]
    pub fn counts(&self) -> WireCounts {
        self.decoder.counts
    }
}

fn parts(v: Vector<f64>) -> [f32; 3] {
    v.to_array().map(|c| c as f32)
}

fn inertial(sensors: &SensorReport, with_mag: bool) -> HIL_SENSOR_DATA {
    use HilSensorUpdatedFlags as Flags;
    let mut updated = Flags::empty();
    let mut message = HIL_SENSOR_DATA {
        time_usec: clock_us(sensors.time_us),
        temperature: 20.0,
        ..HIL_SENSOR_DATA::default()
    };
    if let Some(force) = sensors.specific_force_mps2 {
        [message.xacc, message.yacc, message.zacc] = parts(axes::body(force));
        updated |= Flags::HIL_SENSOR_UPDATED_XACC
            | Flags::HIL_SENSOR_UPDATED_YACC
            | Flags::HIL_SENSOR_UPDATED_ZACC;
    }
    if let Some(rates) = sensors.rates {
        [message.xgyro, message.ygyro, message.zgyro] = parts(axes::body(rates));
        updated |= Flags::HIL_SENSOR_UPDATED_XGYRO
            | Flags::HIL_SENSOR_UPDATED_YGYRO
            | Flags::HIL_SENSOR_UPDATED_ZGYRO;
    }
    if let Some(field) = sensors.magnetic_field_gauss.filter(|_| with_mag) {
        [message.xmag, message.ymag, message.zmag] = parts(axes::body(field));
        updated |= Flags::HIL_SENSOR_UPDATED_XMAG
            | Flags::HIL_SENSOR_UPDATED_YMAG
            | Flags::HIL_SENSOR_UPDATED_ZMAG;
    }
    if let Some(height_m) = sensors.barometer_m {
        message.abs_pressure = place::pressure_hpa(height_m) as f32;
        message.pressure_alt = (place::ALTITUDE_M + height_m) as f32;
        updated |= Flags::HIL_SENSOR_UPDATED_ABS_PRESSURE
            | Flags::HIL_SENSOR_UPDATED_PRESSURE_ALT
            | Flags::HIL_SENSOR_UPDATED_TEMPERATURE;
    }
    message.fields_updated = updated;
    message
}

fn gps(time_us: u64, gnss: &GnssReport) -> HIL_GPS_DATA {
    let (lat, lon, alt) = place::geodetic(gnss.position_m);
    let ned = axes::world(gnss.velocity_mps);
    let centimetres = |v: f64| (v * 100.0).round() as i16;
    let course = ned.y.atan2(ned.x).to_degrees().rem_euclid(360.0);
    HIL_GPS_DATA {
        time_usec: clock_us(time_us),
        lat,
        lon,
        alt,
        // Horizontal and vertical accuracy, cm: those of a receiver without corrections under an open sky.
        eph: 70,
        epv: 110,
        vel: (ned.horizontal().norm() * 100.0).round() as u16,
        vn: centimetres(ned.x),
        ve: centimetres(ned.y),
        vd: centimetres(ned.z),
        cog: (course * 100.0).round() as u16,
        fix_type: 3,
        satellites_visible: 12,
        ..HIL_GPS_DATA::default()
    }
}

fn distance(sensors: &SensorReport, range_m: f64) -> DISTANCE_SENSOR_DATA {
    let centimetres = |m: f64| (m * 100.0).round() as u16;
    let [least_m, greatest_m] = sensors.range_limits_m;
    DISTANCE_SENSOR_DATA {
        time_boot_ms: u32::try_from(clock_us(sensors.time_us) / 1000).unwrap_or(u32::MAX),
        min_distance: centimetres(least_m),
        max_distance: centimetres(greatest_m),
        current_distance: centimetres(range_m),
        mavtype: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
        orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
        signal_quality: 100,
        ..DISTANCE_SENSOR_DATA::default()
    }
}

fn truth(time_us: u64, state: &StateReport) -> HIL_STATE_QUATERNION_DATA {
    let (lat, lon, alt) = place::geodetic(state.position_m);
    let velocity = axes::world(state.velocity_mps);
    let specific = state.attitude.unrotate(state.acceleration_mps2);
    let [vx, vy, vz] = (velocity * 100.0).to_array().map(|v| v.round() as i16);
    let milli_g = axes::body(specific) * (1000.0 / 9.80665);
    let [xacc, yacc, zacc] = milli_g.to_array().map(|a| a.round() as i16);
    let [rollspeed, pitchspeed, yawspeed] = parts(axes::body(state.rates));
    HIL_STATE_QUATERNION_DATA {
        time_usec: clock_us(time_us),
        attitude_quaternion: axes::quaternion(state.attitude)
            .unwrap_or([1.0, 0.0, 0.0, 0.0])
            .map(|c| c as f32),
        rollspeed,
        pitchspeed,
        yawspeed,
        lat,
        lon,
        alt,
        vx,
        vy,
        vz,
        ind_airspeed: 0,
        true_airspeed: 0,
        xacc,
        yacc,
        zacc,
    }
}

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
        let patience = if self.answering {
            ANSWER_WAIT
        } else {
            STARTUP_WAIT
        };
        self.stream.set_patience(patience).map_err(broken)?;
        let mut buffer = [0; 4096];
        loop {
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
                    return self.without_answer();
                }
                Err(e) => return Err(broken(e)),
            }
        }
    }

    fn without_answer(&mut self) -> Result<Motors, LinkError> {
        if self.answering {
            self.missed += 1;
            self.missed_in_a_row += 1;
            if self.missed_in_a_row >= MOST_MISSED {
                return Err(broken(ErrorKind::TimedOut.into()));
            }
        }
        Ok(self.motors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, HilActuatorControlsFlags};
    use proptest::prelude::*;
    use touchdown_flight::Attitude;

    fn report() -> SensorReport {
        SensorReport {
            time_us: 4_000,
            specific_force_mps2: Some(Vector::new(0.5, 0.25, 9.75)),
            rates: Some(Vector::new(0.125, 0.25, 0.5)),
            magnetic_field_gauss: Some(Vector::new(0.25, -0.125, -0.5)),
            range_limits_m: [0.02, 12.0],
            ..SensorReport::default()
        }
    }

    fn state() -> StateReport {
        StateReport {
            position_m: Vector::new(1.0, 2.0, 3.0),
            velocity_mps: Vector::new(0.1, 0.2, 0.3),
            acceleration_mps2: Vector::ZERO,
            attitude: Attitude::LEVEL,
            rates: Vector::ZERO,
        }
    }

    /// The messages of a sample.
    fn messages(codec: &mut Px4Codec, sensors: &SensorReport) -> Vec<MavMessage> {
        let (mut bytes, mut decoder) = (Vec::new(), Decoder::default());
        codec.write(sensors, &state(), &mut bytes);
        decoder.push(&bytes);
        std::iter::from_fn(|| decoder.next_frame().map(|frame| frame.message)).collect()
    }

    fn answer(time_usec: u64, signals: [f32; 4]) -> Vec<u8> {
        let mut controls = [0.0; 16];
        controls[..4].copy_from_slice(&signals);
        let message = MavMessage::HIL_ACTUATOR_CONTROLS(HIL_ACTUATOR_CONTROLS_DATA {
            time_usec,
            controls,
            flags: HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP,
            ..HIL_ACTUATOR_CONTROLS_DATA::default()
        });
        let mut bytes = Vec::new();
        Encoder::new(1, 1).write(&message, &mut bytes);
        bytes
    }

    #[test]
    fn analytic_a_sample_turns_forward_left_up_into_forward_right_down() {
        let all = messages(&mut Px4Codec::default(), &report());
        let Some(MavMessage::HIL_SENSOR(sensor)) = all.last() else {
            panic!("{all:?}");
        };
        assert_eq!([sensor.xacc, sensor.yacc, sensor.zacc], [0.5, -0.25, -9.75]);
        assert_eq!(
            [sensor.xgyro, sensor.ygyro, sensor.zgyro],
            [0.125, -0.25, -0.5]
        );
        assert_eq!([sensor.xmag, sensor.ymag, sensor.zmag], [0.25, 0.125, 0.5]);
        assert_eq!(sensor.time_usec, 1_004_000);
        // Inertial unit and magnetometer; no barometer in this sample.
        assert_eq!(sensor.fields_updated.bits(), 0x1ff);
    }

    #[test]
    fn prop_a_reading_is_sent_once_and_a_sensor_that_fails_not_at_all() {
        let mut codec = Px4Codec::default();
        let mut sensors = report();
        sensors.gnss = Some(GnssReport {
            position_m: Vector::ZERO,
            velocity_mps: Vector::new(0.0, -1.0, 0.5),
        });
        sensors.range_m = Some(0.834);
        sensors.barometer_m = Some(0.0);
        let all = messages(&mut codec, &sensors);
        let gps = all.iter().find_map(|m| match m {
            MavMessage::HIL_GPS(gps) => Some(gps),
            _ => None,
        });
        let gps = gps.unwrap();
        // One metre per second southwards, half a one up.
        assert_eq!([gps.vn, gps.ve, gps.vd], [-100, 0, -50]);
        assert_eq!((gps.cog, gps.vel), (18_000, 100));
        let range = all.iter().find_map(|m| match m {
            MavMessage::DISTANCE_SENSOR(range) => Some(range.current_distance),
            _ => None,
        });
        assert_eq!(range, Some(83));
        let Some(MavMessage::HIL_SENSOR(sensor)) = all.last() else {
            panic!("{all:?}");
        };
        // PX4 ignores a barometer that lacks one of these three bits.
        assert_eq!(sensor.fields_updated.bits() & 0x1a00, 0x1a00);
        let failed = SensorReport {
            specific_force_mps2: None,
            rates: None,
            ..report()
        };
        let all = messages(&mut codec, &failed);
        assert_eq!(all.len(), 1, "{all:?}");
        let MavMessage::HIL_SENSOR(sensor) = &all[0] else {
            panic!("{all:?}");
        };
        assert_eq!(sensor.fields_updated.bits() & 0x3f, 0);
    }

    /// A peer whose answers are given.
    struct Peer {
        answers: std::collections::VecDeque<Vec<u8>>,
        sent: usize,
    }

    impl Read for Peer {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            match self.answers.pop_front() {
                None => Err(ErrorKind::WouldBlock.into()),
                Some(bytes) => {
                    buffer[..bytes.len()].copy_from_slice(&bytes);
                    Ok(bytes.len())
                }
            }
        }
    }

    impl Write for Peer {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.sent += 1;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    impl PatientStream for Peer {
        fn set_patience(&mut self, _: Duration) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn px4(answers: Vec<Vec<u8>>) -> Px4<Peer> {
        Px4::new(Peer {
            answers: answers.into(),
            sent: 0,
        })
    }

    #[test]
    fn prop_a_late_answer_is_not_taken_for_that_of_the_sample() {
        let late = answer(1_000_000, [0.9; 4]);
        let own = answer(1_004_000, [0.1, 0.2, 0.3, 0.4]);
        let mut px4 = px4(vec![late, own]);
        let motors = px4.exchange(&report(), &state()).unwrap();
        assert_eq!(
            motors,
            Motors([0.3, 0.2, 0.4, 0.1].map(|s: f32| f64::from(s)))
        );
        assert_eq!((px4.missed, px4.answering()), (0, true));
    }

    #[test]
    fn prop_missing_answers_keep_the_signals_and_are_an_error_in_the_end() {
        let mut starting = px4(vec![]);
        for _ in 0..500 {
            let motors = starting.exchange(&report(), &state()).unwrap();
            assert_eq!(motors, Motors::default());
        }
        assert_eq!(starting.missed, 0, "PX4 has not started yet");
        let mut px4 = px4(vec![answer(1_004_000, [0.5; 4])]);
        for k in 0..MOST_MISSED {
            assert_eq!(px4.missed, u64::from(k.saturating_sub(1)));
            assert_eq!(px4.exchange(&report(), &state()).unwrap(), Motors([0.5; 4]));
        }
        assert!(px4.exchange(&report(), &state()).is_err());
    }

    #[test]
    fn prop_an_answer_may_come_in_pieces_and_amid_garbage() {
        let whole = answer(1_004_000, [0.5; 4]);
        let (head, tail) = whole.split_at(11);
        let mut px4 = px4(vec![vec![0xfd, 3, 1, 2], head.to_vec(), tail.to_vec()]);
        assert_eq!(px4.exchange(&report(), &state()).unwrap(), Motors([0.5; 4]));
    }

    proptest! {
        #[test]
        fn prop_any_bytes_give_signals_in_their_range(chunks in proptest::collection::vec(
            proptest::collection::vec(prop_oneof![Just(0xfd_u8), any::<u8>()], 0..200), 0..5),
            signals in any::<[f32; 4]>()) {
            let mut codec = Px4Codec::default();
            for chunk in &chunks {
                codec.push(chunk);
                while codec.answer().is_some() {}
            }
            let mut codec = Px4Codec::default();
            codec.push(&answer(1, signals));
            let motors = codec.answer().unwrap().motors;
            prop_assert!(motors.0.iter().all(|s| (0.0..=1.0).contains(s)));
        }
    }
}
