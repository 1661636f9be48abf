//! The simulated world, as the simulator's links and the companion know it.

use touchdown_flight::{Attitude, Vector};
use touchdown_link::simulator::{GnssReport, Motors, SensorReport, StateReport};
use touchdown_sim::landing::space::{AutopilotReadings, MotorSignals, VehicleTruth};

/// What the sensors report. The start's clock counts microseconds.
pub(super) fn sensors(readings: &AutopilotReadings, range_limits_m: [f64; 2]) -> SensorReport {
    let vector = Vector::from_array;
    SensorReport {
        time_us: microseconds(readings.time_s),
        specific_force_mps2: readings.specific_force_mps2.map(vector),
        rates: readings.rates.map(vector),
        magnetic_field_gauss: Some(vector(readings.magnetic_field_gauss)),
        barometer_m: readings.barometer_m,
        gnss: readings.gnss.map(|gnss| GnssReport {
            position_m: vector(gnss.position_m),
            velocity_mps: vector(gnss.velocity_mps),
        }),
        range_m: readings.range_m,
        range_limits_m,
    }
}

/// The true state.
pub(super) fn state(truth: &VehicleTruth) -> StateReport {
    let vector = Vector::from_array;
    StateReport {
        position_m: vector(truth.state.position_m),
        velocity_mps: vector(truth.state.velocity_mps),
        acceleration_mps2: vector(truth.acceleration_mps2),
        attitude: Attitude::from_quaternion(truth.state.attitude).unwrap_or_default(),
        rates: vector(truth.state.rates),
    }
}

/// The signals that the vehicle flies.
pub(super) fn signals(motors: Motors) -> MotorSignals {
    MotorSignals(motors.0)
}

/// Whole microseconds of a time.
pub(super) fn microseconds(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}
