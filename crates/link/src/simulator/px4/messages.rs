//! PX4's simulator messages: samples of the sensors become bytes, and bytes become answers.

use mavlink::dialects::common::{
    DISTANCE_SENSOR_DATA, HIL_GPS_DATA, HIL_SENSOR_DATA, HIL_STATE_QUATERNION_DATA,
    HilSensorUpdatedFlags, MavDistanceSensor, MavMessage, MavSensorOrientation,
};
use touchdown_flight::Vector;

use crate::axes;
use crate::simulator::{GnssReport, Motors, SensorReport, StateReport, place};
use crate::wire::{Decoder, Encoder, WireCounts};

/// PX4's clock at the first sample, µs: PX4 takes a time of zero for no time.
const BOOT_US: u64 = 1_000_000;
/// MAVLink system id of the simulator. PX4 does not read it. It differs from the ids of vehicles (1 plus the instance), so
/// that a log of both tells them apart.
const SYSTEM: u8 = 142;
/// Samples per reading of the magnetometer: 50 Hz, as fast as usual magnetometers. PX4's estimator uses at most about 20 Hz.
const MAG_EVERY: u64 = 5;
/// Samples per true state: 125 Hz. PX4 only writes it into its log.
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

/// The whole centimetres that PX4 reports, in its own `DISTANCE_SENSOR`, of whole centimetres that it gets: it computes metres
/// and centimetres again in single precision and drops the fraction. So it reports 10 cm as 9 and 80 cm as 79.
pub(super) fn reported_by_px4(centimetres: u16) -> u16 {
    (f32::from(centimetres) * 0.01 * 100.0) as u16
}

/// The whole centimetres for which PX4 reports what is nearest to a range. Always the nearest ones would put the deck under a
/// standing vehicle 1 cm too near. Where two reports are as near, the time decides as a coin does: a sensor of whole
/// centimetres finds 10 cm again and again, and always 9 would be an error that no filter averages out.
pub(super) fn for_px4(range_m: f64, time_us: u64) -> u16 {
    let nearest = (range_m * 100.0).round() as u16;
    // In thousandths of a centimetre, so that ties are exact.
    let error =
        |n: &u16| ((f64::from(reported_by_px4(*n)) - range_m * 100.0).abs() * 1e3).round() as u32;
    // The upper bit of the product with the golden ratio (Knuth's multiplicative hash).
    let below_first = time_us.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 63 == 0;
    let (above, below) = (nearest.saturating_add(1), nearest.saturating_sub(1));
    let order = if below_first {
        [nearest, below, above]
    } else {
        [above, nearest, below]
    };
    order.into_iter().min_by_key(error).unwrap_or(nearest)
}

fn distance(sensors: &SensorReport, range_m: f64) -> DISTANCE_SENSOR_DATA {
    let centimetres = |m: f64| (m * 100.0).round() as u16;
    let [least_m, greatest_m] = sensors.range_limits_m;
    DISTANCE_SENSOR_DATA {
        time_boot_ms: u32::try_from(clock_us(sensors.time_us) / 1000).unwrap_or(u32::MAX),
        min_distance: centimetres(least_m),
        max_distance: centimetres(greatest_m),
        current_distance: for_px4(range_m, sensors.time_us),
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
