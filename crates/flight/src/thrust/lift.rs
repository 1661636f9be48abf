//! Whether a thrust model carries a weight.

use super::ThrustModel;
use crate::error::{SettingsError, within};
use crate::real::{Real, r};

/// Greatest thrust over weight below which a vehicle is not flown: it could neither brake a descent nor answer a gust. At half
/// of the excess a landing at 1 m/s takes twice as long to stop; twice refuses heavy lifters that fly.
pub const LEAST_THRUST_TO_WEIGHT: f64 = 1.3;

/// Greatest error of the thrust at rest for a throttle that is to give it, as a share. Numerical errors are 1e-4 in `f32`. A
/// model that jumps past a thrust misses it by far more.
pub const THRUST_ERROR: f64 = 0.01;

impl<R: Real> ThrustModel<R> {
    /// Checks that a throttle gives `weight_n`, and one [`LEAST_THRUST_TO_WEIGHT`] times of it.
    ///
    /// # Errors
    /// Has the nearest thrust at rest, N.
    pub fn check_lift(&self, weight_n: R) -> Result<(), SettingsError> {
        let at_rest_n = |thrust_n: R| {
            let x = self.rest(self.throttle_for(thrust_n));
            x * x
        };
        let least_n = weight_n * r(LEAST_THRUST_TO_WEIGHT);
        let most_n = at_rest_n(least_n);
        within(
            "thrust.greatest_n",
            most_n,
            most_n >= least_n * r(1.0 - THRUST_ERROR),
            "a greatest thrust of at least 1.3 times the weight",
        )?;
        let hover_n = at_rest_n(weight_n);
        within(
            "thrust.hover_n",
            hover_n,
            (hover_n - weight_n).abs() <= weight_n * r(THRUST_ERROR),
            "a thrust equal to the weight at some throttle",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FirstOrder, LaggedThrottle, Library};
    use super::*;

    #[test]
    fn analytic_a_thrust_of_1_3_times_the_weight_is_the_limit() {
        // √T = 5 s: 25 N at full throttle.
        let model = ThrustModel::FirstOrder(FirstOrder {
            c0: 5.0,
            c1: 0.0,
            t_m_s: 0.05,
        });
        assert_eq!(model.check_lift(25.0 / 1.3), Ok(()));
        // 2 %: beyond the tolerance of 1 %.
        let heavy = model.check_lift(1.02 * 25.0 / 1.3).unwrap_err();
        let SettingsError::OutOfRange { key, found, .. } = heavy else {
            panic!("{heavy}");
        };
        assert_eq!(key, "thrust.greatest_n");
        // One rounding of the root and one of the square.
        assert!((found - 25.0).abs() < 1e-12, "{found}");
        assert_eq!(
            ThrustModel::<f32>::published().check_lift(1.37 * 9.81),
            Ok(())
        );
    }

    #[test]
    fn analytic_a_model_without_coefficients_carries_nothing() {
        let cubic = LaggedThrottle {
            coefficients: [0.0; 4],
            t_m_s: 0.05,
        };
        let library = Library::from_array([0.0; 8]);
        for model in [
            ThrustModel::LaggedThrottle(cubic),
            ThrustModel::Library(library),
        ] {
            assert!(model.check_lift(13.4_f64).is_err(), "{model:?}");
        }
    }
}
