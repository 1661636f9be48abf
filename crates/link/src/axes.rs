//! Axes: MAVLink has north-east-down and forward-right-down, the landing computer east-north-up and forward-left-up.
//!
//! Both turns are half turns, so each of them is its own inverse.

use touchdown_flight::{Attitude, Vector};

/// World axes: north-east-down to east-north-up, and back.
#[must_use]
pub fn world(v: Vector<f64>) -> Vector<f64> {
    Vector::new(v.y, v.x, -v.z)
}

/// Body axes: forward-right-down to forward-left-up, and back.
#[must_use]
pub fn body(v: Vector<f64>) -> Vector<f64> {
    Vector::new(v.x, -v.y, -v.z)
}

/// The attitude of a MAVLink quaternion (w, x, y, z; forward-right-down to north-east-down). None where it is zero or not
/// finite.
#[must_use]
pub fn attitude(quaternion: [f64; 4]) -> Option<Attitude<f64>> {
    let turned = Attitude::from_quaternion(quaternion)?;
    Some(world_turn()? * turned * body_turn()?)
}

/// The MAVLink quaternion of an attitude.
#[must_use]
pub fn quaternion(attitude: Attitude<f64>) -> Option<[f64; 4]> {
    let [w, x, y, z] = (world_turn()? * attitude * body_turn()?).to_quaternion();
    // q and -q are the same attitude; autopilots expect w ≥ 0.
    Some(if w < 0.0 {
        [-w, -x, -y, -z]
    } else {
        [w, x, y, z]
    })
}

/// Half a turn about north-east.
fn world_turn() -> Option<Attitude<f64>> {
    Attitude::from_quaternion([0.0, 1.0, 1.0, 0.0])
}

/// Half a turn about forward.
fn body_turn() -> Option<Attitude<f64>> {
    Attitude::from_quaternion([0.0, 1.0, 0.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn close(a: Vector<f64>, b: Vector<f64>) {
        assert!((a - b).norm() < 1e-12, "{a:?} {b:?}");
    }

    #[test]
    fn analytic_north_is_y_east_is_x_down_is_minus_z() {
        close(
            world(Vector::new(1.0, 2.0, 3.0)),
            Vector::new(2.0, 1.0, -3.0),
        );
        close(
            body(Vector::new(1.0, 2.0, 3.0)),
            Vector::new(1.0, -2.0, -3.0),
        );
    }

    #[test]
    fn analytic_a_level_vehicle_that_points_north_has_a_yaw_of_90_degrees() {
        let north = attitude([1.0, 0.0, 0.0, 0.0]).unwrap();
        close(
            north.rotate(Vector::new(1.0, 0.0, 0.0)),
            Vector::new(0.0, 1.0, 0.0),
        );
        close(north.up(), Vector::UP);
        // East: yaw of 90° in north-east-down.
        let east = attitude([FRAC_PI_4.cos(), 0.0, 0.0, FRAC_PI_4.sin()]).unwrap();
        assert!(east.yaw_rad().abs() < 1e-12);
    }

    #[test]
    fn analytic_pitch_up_and_roll_right_tilt_the_thrust_back_and_right() {
        let half = 0.05_f64;
        // Pointing north: pitch up tilts the thrust south, roll right tilts it east.
        let pitched = attitude([half.cos(), 0.0, half.sin(), 0.0]).unwrap();
        close(
            pitched.up(),
            Vector::new(0.0, -(0.1_f64.sin()), 0.1_f64.cos()),
        );
        let rolled = attitude([half.cos(), half.sin(), 0.0, 0.0]).unwrap();
        close(rolled.up(), Vector::new(0.1_f64.sin(), 0.0, 0.1_f64.cos()));
    }

    #[test]
    fn analytic_specific_force_of_a_hover_points_up_in_both_axes() {
        // At rest an accelerometer in forward-right-down reads -g along z.
        let force = body(Vector::new(0.0, 0.0, -9.81));
        close(force, Vector::new(0.0, 0.0, 9.81));
    }

    #[test]
    fn prop_attitudes_come_back() {
        for q in [
            [0.9, 0.1, -0.2, 0.3],
            [0.1, 0.0, 0.0, 1.0],
            [0.5, -0.5, 0.5, 0.5],
        ] {
            let there = attitude(q).unwrap();
            let back = attitude(quaternion(there).unwrap()).unwrap();
            close(
                there.rotate(Vector::new(1.0, 2.0, 3.0)),
                back.rotate(Vector::new(1.0, 2.0, 3.0)),
            );
        }
        assert!(attitude([f64::NAN, 0.0, 0.0, 0.0]).is_none());
        assert!(attitude([0.0; 4]).is_none());
    }
}
