//! Landings as ULog files with the topics of PX4.
//!
//! | topic | rate | what it holds |
//! | --- | --- | --- |
//! | `sensor_combined` | 250 Hz | specific force and rates, axes forward, right, down |
//! | `actuator_motors` | 250 Hz | throttles, NaN with motors off; `THR_MDL_FAC` is 0 |
//! | `vehicle_attitude` | 250 Hz | attitude, north, east, down being the world's x, -y, -z |
//! | `vehicle_local_position` | 100 Hz | place and velocity as the landing computer believes them |
//! | `distance_sensor` | as read | the range finder that looks down |
//! | `battery_status` | 50 Hz | voltage |
//! | `touchdown_truth` | 100 Hz | height above the deck, deck, rotors' forces and ground effect, true |
//!
//! Stamps count from the start of the trial, which is one second after the vehicle was switched on.

use std::io;

use touchdown_log::{UlogTopic, UlogWriter};
use touchdown_sim::landing::space::{ImuRow, RangeRow, SpaceTrace, TraceRow};

use crate::error::{Error, Result};

/// Stamp at the start of a trial, µs.
const START_US: u64 = 1_000_000;
/// Samples of the inertial unit between two of the battery.
const BATTERY_EVERY: usize = 5;
/// What looks down, in the words of MAVLink's sensor orientations.
const DOWN: f64 = 25.0;

/// Topic and its fields.
const FORMATS: [(&str, &str); 7] = [
    (
        "sensor_combined",
        "float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;\
         uint32_t accelerometer_integral_dt",
    ),
    (
        "actuator_motors",
        "uint64_t timestamp_sample;uint16_t reversible_flags;float[12] control",
    ),
    ("vehicle_attitude", "uint64_t timestamp_sample;float[4] q"),
    (
        "vehicle_local_position",
        "uint64_t timestamp_sample;float x;float y;float z;float vx;float vy;float vz",
    ),
    (
        "distance_sensor",
        "float min_distance;float max_distance;float current_distance;float variance;int8_t signal_quality;uint8_t orientation",
    ),
    ("battery_status", "float voltage_v"),
    (
        "touchdown_truth",
        "float height_m;float[3] relative_m;float[3] relative_mps;float[3] deck_mps;float[4] rotor_n;float ground_effect_n",
    ),
];

/// The bytes of a ULog with a landing's log.
///
/// # Errors
/// None that a landing's trace gives reason for.
pub fn ulog(trace: &SpaceTrace) -> Result<Vec<u8>> {
    written(trace)
        .map_err(|e| Error::Arguments(format!("the landing cannot be written as ULog: {e}")))
}

/// What is to be written at a time.
#[derive(Clone, Copy)]
enum Event<'a> {
    Imu(usize, &'a ImuRow),
    Range(&'a RangeRow),
    LandingRow(&'a TraceRow),
}

fn written(trace: &SpaceTrace) -> io::Result<Vec<u8>> {
    let mut writer = UlogWriter::new(Vec::new(), START_US)?;
    for (name, fields) in FORMATS {
        writer.format(name, fields)?;
    }
    writer.info("sys_name", "touchdown")?;
    writer.info("ver_sw", env!("CARGO_PKG_VERSION"))?;
    let finder = &trace.log.range_finder;
    writer.parameter("THR_MDL_FAC", 0.0)?;
    writer.parameter("EKF2_RNG_POS_Z", -finder.place_m[2] as f32)?;
    let mut topics = Vec::with_capacity(FORMATS.len());
    for (name, _) in FORMATS {
        topics.push(writer.topic(name, 0)?);
    }
    let log = &trace.log;
    let mut events: Vec<(u64, Event<'_>)> = Vec::new();
    let imu = log.imu.iter().enumerate();
    events.extend(imu.map(|(k, row)| (stamp_us(row.time_s), Event::Imu(k, row))));
    let ranges = log.ranges.iter();
    events.extend(ranges.map(|row| (stamp_us(row.time_s), Event::Range(row))));
    let rows = trace.rows.iter();
    events.extend(rows.map(|row| (stamp_us(row.time_s), Event::LandingRow(row))));
    events.sort_by_key(|(stamp, _)| *stamp);
    for (stamp, event) in events {
        match event {
            Event::Imu(k, row) => sample(&mut writer, &topics, stamp, k, row)?,
            Event::Range(row) => {
                let (least, greatest) = (finder.least_m, finder.greatest_m);
                let variance = finder.noise_sd_m.powi(2);
                let values = [least, greatest, row.distance_m, variance, 100.0, DOWN];
                writer.message(topics[4], stamp, &values)?;
            }
            Event::LandingRow(row) => {
                let ([x, y, z], [u, v, w]) = (row.estimated_m, row.estimated_velocity_mps);
                let at = stamp as f64;
                writer.message(topics[3], stamp, &[at, x, -y, -z, u, -v, -w])?;
                let mut truth = vec![row.relative_m[2]];
                truth.extend(row.relative_m);
                truth.extend(row.relative_mps);
                truth.extend(row.deck_mps);
                truth.extend(row.rotor_n);
                truth.push(row.ground_effect_n);
                writer.message(topics[6], stamp, &truth)?;
            }
        }
    }
    writer.finish()
}

/// A sample of the inertial unit, and the channels that are logged with it.
fn sample(
    writer: &mut UlogWriter<Vec<u8>>,
    topics: &[UlogTopic],
    stamp: u64,
    index: usize,
    row: &ImuRow,
) -> io::Result<()> {
    let at = stamp as f64;
    let ([p, q, r], [x, y, z]) = (row.rates, row.specific_force_mps2);
    // Sampled over 4 ms, in µs.
    let force = [p, -q, -r, 4000.0, 0.0, x, -y, -z, 4000.0];
    writer.message(topics[0], stamp, &force)?;
    let mut motors = [f64::NAN; 14];
    (motors[0], motors[1]) = (at, 0.0);
    if let Some(throttle) = row.throttle {
        motors[2..6].copy_from_slice(&throttle);
    }
    writer.message(topics[1], stamp, &motors)?;
    let [w, i, j, k] = row.attitude;
    writer.message(topics[2], stamp, &[at, w, i, -j, -k])?;
    if index.is_multiple_of(BATTERY_EVERY) {
        writer.message(topics[5], stamp, &[row.battery_v])?;
    }
    Ok(())
}

fn stamp_us(time_s: f64) -> u64 {
    START_US + (time_s * 1e6).round() as u64
}
