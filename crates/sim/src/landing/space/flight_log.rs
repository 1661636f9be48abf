//! The log that an autopilot would write of a landing: inertial unit, motors and battery at 250 Hz, and
//! every reading of the range finder at the time of its measurement.
//!
//! The noise of the samples has a separate random stream, so recording does not change a landing.

use serde::Serialize;
use touchdown_lander::estimate::relative::Reading;

use super::flight::Flight;
use crate::STEP_S;
use crate::sensors::RangeSettings;
use crate::sensors::{LOG_STEPS, RangeRow, suite::nan_if};

/// Voltage of a full battery of four lithium-polymer cells (4.2 V each). Under load it sags
/// as the motors' drive does.
const FULL_V: f64 = 16.8;

/// A sample of the inertial unit, with throttles and rotor speeds at its time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImuRow {
    /// Time at the end of the sample, s.
    pub time_s: f64,
    /// Mean specific force over the sample, body axes (forward, port, up), m/s².
    pub specific_force_mps2: [f64; 3],
    /// Rates, body axes, rad/s.
    pub rates: [f64; 3],
    /// Attitude w, x, y, z.
    pub attitude: [f64; 4],
    /// Throttles; none with rotors off.
    pub throttle: Option<[f64; 4]>,
    /// Voltage of the battery, V.
    pub battery_v: f64,
}

/// A pose of the tag, as it arrives at the landing computer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TagRow {
    /// Time of the image by its stamp, s.
    pub time_s: f64,
    /// Place of the tag in camera axes (right, down, ahead), m.
    pub position_m: [f64; 3],
}

/// The log of a landing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FlightLog {
    /// Samples of the inertial unit.
    pub imu: Vec<ImuRow>,
    /// Readings of the range finder, in the order in which they were taken.
    pub ranges: Vec<RangeRow>,
    /// Poses of the tag, in the order of their arrival.
    pub tags: Vec<TagRow>,
    /// The range finder.
    pub range_finder: RangeSettings,
}

impl Flight<'_> {
    /// Logs the poses of the tag that have arrived, if the landing is traced.
    pub(super) fn log_tags(&mut self, now_s: f64, readings: &[Reading<f64>]) {
        let Some(trace) = &mut self.landing.trace else {
            return;
        };
        let rows = readings.iter().filter_map(|reading| match reading {
            Reading::Tag(tag) => Some(TagRow {
                time_s: now_s - tag.age_s,
                position_m: tag.position_m.to_array(),
            }),
            _ => None,
        });
        trace.log.tags.extend(rows);
    }

    /// Logs the samples that are due at a step, if the landing is traced.
    pub(super) fn log_sample(&mut self, step: u64) {
        let since_s = self.since_s(step);
        let Some(trace) = &mut self.landing.trace else {
            return;
        };
        if let Some(readings) = &mut self.sensors.range_finder.log {
            trace.log.ranges.append(readings);
        }
        if !step.is_multiple_of(LOG_STEPS) {
            return;
        }
        let scenario = &self.lander.scenario;
        let nan = scenario.faults.of_sensors(since_s).nan;
        let imu = &scenario.sensors.imu;
        let noise = imu.noise_density / (LOG_STEPS as f64 * STEP_S).sqrt();
        let stream = &mut self.log_noise;
        let load = 0.25 * self.throttle.iter().sum::<f64>();
        let force = self.sensors.inertial.logged_force_mps2();
        let attitude = self.sensors.inertial.believed(self.state.attitude);
        trace.log.imu.push(ImuRow {
            time_s: step as f64 * STEP_S,
            specific_force_mps2: force
                .map(|f| nan_if(nan.specific_force, f + noise * stream.normal())),
            rates: self
                .state
                .rates
                .map(|rate| nan_if(nan.rates, rate + imu.gyro_sd * stream.normal())),
            attitude: attitude.map(|q| nan_if(nan.attitude, q)),
            throttle: self.setpoint.map(|_| self.throttle),
            battery_v: FULL_V * (1.0 - scenario.plant.motor.sag * load),
        });
    }
}
