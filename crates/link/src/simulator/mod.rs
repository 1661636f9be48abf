//! The simulator's side of an autopilot: sensors out, motor signals in. The caller computes the world.
//!
//! | module | content |
//! | --- | --- |
//! | [`px4`] | PX4's simulator protocol: MAVLink over TCP, in lockstep |
//! | [`ardupilot`] | ArduPilot's JSON interface: binary motor signals and a line of JSON, over UDP |
//! | [`pilot`] | a pilot who arms, takes off, holds, and lands if asked |
//! | [`sighting`] | the deck in the simulated camera, sent to a companion |
//! | [`place`] | where on Earth the simulated deck is |
//!
//! Axes here are those of the rest of this crate: east-north-up, and forward-left-up in the body. Each protocol turns them
//! into its own.

pub mod ardupilot;
mod asked;
pub mod pilot;
pub mod place;
pub mod px4;
pub mod sighting;

use touchdown_flight::{Attitude, Vector};

/// Satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GnssReport {
    /// Place, east-north-up from the deck's mean place, m.
    pub position_m: Vector<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector<f64>,
}

/// Readings of the vehicle's sensors; none of a sensor without a new one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorReport {
    /// Time since the start, µs.
    pub time_us: u64,
    /// Specific force, body axes, m/s².
    pub specific_force_mps2: Option<Vector<f64>>,
    /// Angular velocity, body axes, rad/s.
    pub rates: Option<Vector<f64>>,
    /// Magnetic field, body axes, gauss.
    pub magnetic_field_gauss: Option<Vector<f64>>,
    /// Height of the barometer above the deck's mean place, m.
    pub barometer_m: Option<f64>,
    /// Satellite navigation.
    pub gnss: Option<GnssReport>,
    /// Distance along the range finder's beam, m.
    pub range_m: Option<f64>,
    /// Smallest and largest distance of the range finder, m.
    pub range_limits_m: [f64; 2],
}

/// The true state of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateReport {
    /// Place, east-north-up from the deck's mean place, m.
    pub position_m: Vector<f64>,
    /// Velocity, m/s.
    pub velocity_mps: Vector<f64>,
    /// Acceleration, m/s².
    pub acceleration_mps2: Vector<f64>,
    /// Attitude.
    pub attitude: Attitude<f64>,
    /// Angular velocity, body axes, rad/s.
    pub rates: Vector<f64>,
}

/// Signals of the four motors, in [0, 1]: front left, rear left, rear right, front right.
///
/// Both autopilots number the motors of a quadrotor in X form alike: 1 front right, 2 rear left (both counterclockwise
/// seen from above), 3 front left, 4 rear right (both clockwise).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motors(pub [f64; 4]);

impl Motors {
    /// From the autopilots' order. A signal that is not a number stops its motor.
    fn numbered([front_right, rear_left, front_left, rear_right]: [f64; 4]) -> Self {
        let usable = |s: f64| {
            if s.is_finite() {
                s.clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        Self([front_left, rear_left, rear_right, front_right].map(usable))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_motors_are_sorted_from_the_autopilots_numbers_to_the_rotors_places() {
        assert_eq!(
            Motors::numbered([0.1, 0.2, 0.3, 0.4]).0,
            [0.3, 0.2, 0.4, 0.1]
        );
        assert_eq!(
            Motors::numbered([f64::NAN, 2.0, -1.0, 0.5]).0,
            [0.0, 1.0, 0.5, 0.0]
        );
    }
}
