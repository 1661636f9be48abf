//! Allocation of a force in world axes to collective thrust and attitude.

use touchdown_flight::real::Real;
use touchdown_flight::space::{Attitude, Vector};

/// Least vertical force for the direction of thrust, as a share of the weight. In a fast
/// descent the vertical force vanishes, and the attitude would otherwise become horizontal.
pub(crate) const VERTICAL_SHARE_MIN: f64 = 0.5;

/// An attitude, and whether its horizontal force is less than the demanded one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Allocated<R> {
    pub(crate) attitude: Attitude<R>,
    pub(crate) limited: bool,
}

/// The attitude at heading `yaw_rad` in which a force along the rotors' axis has
/// the vertical part `vertical_n` and the horizontal part `horizontal_n`.
///
/// The vertical part has priority: within the greatest force F = `greatest_n`, the
/// horizontal part gets at most `√(F² - V²)`. The tilt stays within its limit, and is that of a
/// vertical part of at least `least_up_n`. None if a number is not finite.
pub(crate) fn allocate<R: Real>(
    horizontal_n: Vector<R>,
    vertical_n: R,
    least_up_n: R,
    greatest_n: R,
    tilt_limit_rad: R,
    yaw_rad: R,
) -> Option<Allocated<R>> {
    let up_n = vertical_n.max(least_up_n);
    let wanted_n = horizontal_n.horizontal();
    let norm_n = wanted_n.norm();
    let by_thrust = (greatest_n * greatest_n - up_n * up_n).max(R::ZERO).sqrt();
    // tan α is at least α, so most steps need no tangent.
    let given = if norm_n <= (up_n * tilt_limit_rad).min(by_thrust) {
        wanted_n
    } else {
        let by_tilt = up_n * tilt_limit_rad.sin() / tilt_limit_rad.cos();
        wanted_n.limited(by_tilt.min(by_thrust))
    };
    let direction = given + Vector::UP * up_n;
    let attitude = Attitude::from_thrust_direction(direction, yaw_rad)?;
    Some(Allocated {
        attitude,
        limited: given != wanted_n,
    })
}

#[cfg(test)]
mod tests {
    use super::{VERTICAL_SHARE_MIN, allocate};
    use touchdown_flight::space::{Attitude, Vector};

    const W: f64 = 13.4397;
    const LEAST: f64 = VERTICAL_SHARE_MIN * W;

    #[test]
    fn analytic_the_force_points_where_it_should() {
        let force = Vector::new(1.2, -0.7, 13.0);
        for yaw in [0.0, 0.8, -2.5] {
            let found = allocate(force, force.z, LEAST, 30.0, 0.3, yaw).unwrap();
            assert!(!found.limited);
            let up = found.attitude.up();
            // Roundings of a product of three quaternions.
            assert!(up.cross(force).norm() < 1e-13, "{up:?}");
            let forward = found.attitude.rotate(Vector::new(1.0, 0.0, 0.0));
            // The heading is that of the plane in which it pitches.
            let seen = Attitude::from_yaw(yaw).unrotate(forward);
            assert!(seen.y.abs() < 1e-14 && seen.x > 0.0);
        }
        // Straight up is level, to the bit.
        let level = allocate(Vector::new(0.0, 0.0, 1.0), W, LEAST, 20.0, 0.3, 0.0).unwrap();
        assert_eq!(level.attitude, Attitude::LEVEL);
        assert!(!level.limited);
    }

    #[test]
    fn analytic_limits_of_tilt_and_thrust() {
        let far = Vector::new(30.0, 40.0, 0.0);
        let found = allocate(far, W, LEAST, 100.0, 0.3, 0.0).unwrap();
        assert!(found.limited);
        assert!((found.attitude.tilt_rad() - 0.3).abs() < 1e-14);
        let up = found.attitude.up();
        // In the direction asked for, 3 to 4.
        assert!((up.x / up.y - 0.75).abs() < 1e-13);
        // 15 N at most: the horizontal part is √(15² - W²).
        let found = allocate(far, W, LEAST, 15.0, 0.9, 0.0).unwrap();
        let left = (15.0_f64.powi(2) - W * W).sqrt();
        assert!((found.attitude.tilt_rad() - left.atan2(W)).abs() < 1e-14);
        // More asked for upward than there is: level.
        let found = allocate(far, 16.0, LEAST, 15.0, 0.9, 0.0).unwrap();
        assert!(found.attitude.tilt_rad() < 1e-15 && found.limited);
        // Let down without thrust: tilted as with half the weight.
        let found = allocate(Vector::new(1.0, 0.0, 0.0), -3.0, LEAST, 20.0, 0.3, 0.0).unwrap();
        assert!((found.attitude.tilt_rad() - 1.0_f64.atan2(0.5 * W)).abs() < 1e-14);
        // Let down in the wind: the tilt is that of the least vertical part.
        let found = allocate(Vector::new(5.0, 0.0, 0.0), 8.0, 0.9 * W, 20.0, 0.7, 0.0).unwrap();
        assert!((found.attitude.tilt_rad() - 5.0_f64.atan2(0.9 * W)).abs() < 1e-14);
        let nan = Vector::new(f64::NAN, 0.0, 0.0);
        assert!(allocate(nan, W, LEAST, 20.0, 0.3, 0.0).is_none());
    }
}
