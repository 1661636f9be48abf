//! Positions of the deck as readings of a tag.

use touchdown_flight::Vector;
use touchdown_lander::estimate::relative::{Reading, TagReading};

/// Error of `LANDING_TARGET` on each axis: √(`sd_m`² + (`share` · distance)²).
#[derive(Clone, Copy, Debug)]
pub(super) struct TargetError {
    /// Close to the deck, m.
    pub(super) sd_m: f64,
    /// Share of the distance.
    pub(super) share: f64,
}

impl TargetError {
    /// Variance on each axis of a position relative to the vehicle, m².
    pub(super) fn variance_m2(&self, position_m: Vector<f64>) -> f64 {
        let grows_m = self.share * position_m.norm();
        self.sd_m * self.sd_m + grows_m * grows_m
    }
}

/// The reading of a position in body axes, with the same variance on each of them.
pub(super) fn reading(position_m: Vector<f64>, variance_m2: f64) -> Reading<f64> {
    let mut covariance_m2 = [[0.0; 3]; 3];
    for (k, row) in covariance_m2.iter_mut().enumerate() {
        row[k] = variance_m2;
    }
    Reading::Tag(TagReading {
        position_m,
        covariance_m2,
        age_s: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_error_of_a_target_grows_with_its_distance() {
        let error = TargetError {
            sd_m: 0.003,
            share: 0.01,
        };
        // 3, 4 and 5 mm: exact but for rounding.
        let far = error.variance_m2(Vector::new(0.0, 0.24, -0.32));
        assert!((far - 0.005_f64.powi(2)).abs() < 1e-18);
        let near = error.variance_m2(Vector::ZERO);
        assert!((near - 0.003_f64.powi(2)).abs() < 1e-18);
    }
}
