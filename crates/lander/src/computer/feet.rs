//! Height of the lowest foot of a tilted vehicle.

use crate::check::positive;
use touchdown_flight::error::SettingsError;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// Four feet at the corners of a square under the arms, as the contact of a landing sees
/// them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Feet<R> {
    /// Distance of the feet from the vertical axis, m.
    pub radius_m: R,
    /// Depth of the feet below the reference point, m.
    pub depth_m: R,
}

impl<R: Real> Default for Feet<R> {
    /// 0.15 m and 0.10 m, those of the default airframe.
    fn default() -> Self {
        Self {
            radius_m: r(0.15),
            depth_m: r(0.10),
        }
    }
}

impl<R: Real> Feet<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Both must be positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("feet.radius_m", self.radius_m)?;
        positive("feet.depth_m", self.depth_m)
    }

    /// How much lower the lowest foot is than in an attitude along the deck's normal n, m:
    ///
    /// ```text
    /// d (b_z·n - 1) + r/√2 (|b_x·n| + |b_y·n|)
    /// ```
    ///
    /// with the body's axes b, the feet's depth d and radius r. At 0.39 rad about an axis
    /// through two arms it is 0.05 m.
    #[must_use]
    pub fn drop_m(&self, attitude: Attitude<R>, normal: Vector<R>) -> R {
        let Some(normal) = normal.direction() else {
            return R::ZERO;
        };
        let along = attitude.unrotate(normal);
        let corner_m = self.radius_m * r(core::f64::consts::FRAC_1_SQRT_2);
        self.depth_m * (along.z - R::ONE) + corner_m * (along.x.abs() + along.y.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_lowest_foot_of_a_tilted_vehicle() {
        let feet = Feet::<f64>::default();
        let about = |x: f64, y: f64| Attitude::from_rotation_vector(Vector::new(x, y, 0.0));
        assert_eq!(feet.drop_m(Attitude::LEVEL, Vector::UP), 0.0);
        // About the body's x axis both feet of a side come down: a sin α beside d (cos α - 1).
        let a = 0.15 / 2.0_f64.sqrt();
        for angle in [0.05, 0.2, 0.39, -0.39] {
            let (sin, cos) = f64::sin_cos(angle);
            let expected = a * sin.abs() + 0.10 * (cos - 1.0);
            // Roundings of a quaternion product.
            assert!((feet.drop_m(about(angle, 0.0), Vector::UP) - expected).abs() < 1e-15);
            assert!((feet.drop_m(about(0.0, angle), Vector::UP) - expected).abs() < 1e-15);
        }
        // About the diagonal one foot comes down, by the whole radius.
        let diagonal = about(0.2 / 2.0_f64.sqrt(), 0.2 / 2.0_f64.sqrt());
        let expected = 0.15 * 0.2_f64.sin() + 0.10 * (0.2_f64.cos() - 1.0);
        assert!((feet.drop_m(diagonal, Vector::UP) - expected).abs() < 1e-15);
        // A vehicle that stands on a tilted deck is level on it; an unknown normal counts as level.
        let tilted = about(0.14, 0.0);
        assert!(feet.drop_m(tilted, tilted.up()).abs() < 1e-15);
        assert_eq!(feet.drop_m(tilted, Vector::ZERO), 0.0);
    }
}
