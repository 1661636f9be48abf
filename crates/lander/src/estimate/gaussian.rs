//! A normal distribution: correction by measurements of one of its numbers.

use touchdown_flight::real::{Real, r};

/// Mean and covariance of N numbers. The covariance is symmetric: the T = N (N + 1)/2 numbers on
/// and above its diagonal, row after row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gaussian<R, const N: usize, const T: usize> {
    pub(crate) mean: [R; N],
    pub(crate) covariance: [R; T],
}

/// Place of the element (i, j) of a symmetric matrix of N rows, j not below i.
pub(crate) const fn at<const N: usize>(i: usize, j: usize) -> usize {
    // Row i begins after rows of N, N - 1, ... numbers.
    i * (2 * N - i - 1) / 2 + j
}

/// A scalar measurement of one number, `y = h x + noise`, compared with what was expected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation<R, const N: usize> {
    /// The measured number.
    index: usize,
    h: R,
    /// P hᵀ.
    spread: [R; N],
    /// Measured less expected.
    residual: R,
    /// Variance of the measurement.
    noise: R,
    /// Variance of the residual, `h P hᵀ + noise`.
    variance: R,
}

impl<R: Real, const N: usize> Innovation<R, N> {
    /// Normalised innovation squared: the squared residual over its variance. It is
    /// χ² distributed with one degree of freedom if the model holds. It is infinite
    /// if a measurement without error contradicts an exact expectation.
    pub(crate) fn nis(&self) -> R {
        let square = self.residual * self.residual;
        if square > R::ZERO {
            square / self.variance
        } else {
            R::ZERO
        }
    }
}

/// An element of a list; zero beyond its end.
fn element<R: Real>(list: &[R], index: usize) -> R {
    list.get(index).copied().unwrap_or(R::ZERO)
}

/// The elements of a list from an index on.
fn after<R>(list: &[R], index: usize) -> &[R] {
    list.get(index..).unwrap_or(&[])
}

impl<R: Real, const N: usize, const T: usize> Gaussian<R, N, T> {
    /// Zeros.
    pub(crate) const BLANK: Self = Self {
        mean: [R::ZERO; N],
        covariance: [R::ZERO; T],
    };

    /// Independent numbers of mean zero.
    pub(crate) fn from_sd(sd: [R; N]) -> Self {
        const { assert!(T == N * (N + 1) / 2, "a symmetric matrix") };
        let mut covariance = [R::ZERO; T];
        for (i, sd) in sd.into_iter().enumerate() {
            if let Some(variance) = covariance.get_mut(at::<N>(i, i)) {
                *variance = sd * sd;
            }
        }
        Self {
            mean: [R::ZERO; N],
            covariance,
        }
    }

    /// Covariance of two numbers.
    pub(crate) fn covariance(&self, i: usize, j: usize) -> R {
        element(&self.covariance, at::<N>(i.min(j), i.max(j)))
    }

    /// Sets the covariance of two numbers.
    pub(crate) fn set_covariance(&mut self, i: usize, j: usize, value: R) {
        if let Some(place) = self.covariance.get_mut(at::<N>(i.min(j), i.max(j))) {
            *place = value;
        }
    }

    /// Sets the variance of a number that depends on no other one.
    pub(crate) fn set_independent(&mut self, i: usize, variance: R) {
        for j in 0..N {
            self.set_covariance(i, j, R::ZERO);
        }
        self.set_covariance(i, i, variance);
    }

    /// Compares a measurement `value = h x` of the number `index` with what is expected.
    pub(crate) fn innovation(&self, index: usize, h: R, value: R, noise: R) -> Innovation<R, N> {
        let mut spread = [R::ZERO; N];
        for (i, spread) in spread.iter_mut().enumerate() {
            *spread = self.covariance(i, index) * h;
        }
        Innovation {
            index,
            h,
            spread,
            residual: value - h * element(&self.mean, index),
            noise,
            variance: noise + h * element(&spread, index),
        }
    }

    /// Corrects by a measurement `value` of a number, whose error of the variance
    /// `noise` does not average out: the number is not known better afterwards, and a better known one is kept.
    pub(crate) fn learn_at_most(&mut self, index: usize, value: R, noise: R) {
        let innovation = self.innovation(index, R::ONE, value, noise);
        if innovation.variance < r::<R>(2.0) * noise {
            return;
        }
        self.correct(&innovation);
        let known = self.covariance(index, index).max(noise);
        self.set_covariance(index, index, known);
    }

    /// Kalman correction in Joseph's form,
    /// `P ← (1 - K h) P (1 - K h)ᵀ + K noise Kᵀ`, which stays symmetric and
    /// positive under rounding. It changes nothing where the residual has no variance.
    #[inline(never)]
    pub(crate) fn correct(&mut self, innovation: &Innovation<R, N>) {
        if !(innovation.variance > R::ZERO) {
            return;
        }
        let spread = &innovation.spread;
        let gain = spread.map(|c| c / innovation.variance);
        // A = (1 - K h) P, then A (1 - K h)ᵀ = A - (A hᵀ) Kᵀ.
        let own = element(spread, innovation.index);
        let mut ah = [R::ZERO; N];
        for (i, ah) in ah.iter_mut().enumerate() {
            *ah = (self.covariance(i, innovation.index) - element(&gain, i) * own) * innovation.h;
        }
        for (mean, gain) in self.mean.iter_mut().zip(gain) {
            *mean += gain * innovation.residual;
        }
        let mut cells = self.covariance.iter_mut();
        for (i, (gain_i, ah)) in gain.iter().zip(ah).enumerate() {
            let noise = *gain_i * innovation.noise;
            let columns = after(spread, i).iter().zip(after(&gain, i));
            for (k, ((spread, gain), cell)) in columns.zip(&mut cells).enumerate() {
                let c = (*cell - *gain_i * *spread) - ah * *gain + noise * *gain;
                // Rounding can make a vanishing variance negative.
                *cell = if k == 0 { c.max(R::ZERO) } else { c };
            }
        }
    }

    /// Standard deviation of number i.
    pub(crate) fn sd(&self, i: usize) -> R {
        self.covariance(i, i).max(R::ZERO).sqrt()
    }

    /// Standard deviation of number i less number j.
    pub(crate) fn sd_of_difference(&self, i: usize, j: usize) -> R {
        let covariance = self.covariance(i, j);
        (self.covariance(i, i) + self.covariance(j, j) - r::<R>(2.0) * covariance)
            .max(R::ZERO)
            .sqrt()
    }

    /// Whether all numbers are finite: zero times any of them is then zero.
    pub(crate) fn is_finite(&self) -> bool {
        let all = self.mean.iter().chain(&self.covariance);
        all.fold(R::ZERO, |sum, &c| sum + c * R::ZERO) == R::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_measurements_of_one_number() {
        // Precisions add: prior 1/4, measurements 1/1 and 1/0.25.
        let mut g = Gaussian::<f64, 2, 3>::from_sd([2.0, 3.0]);
        for (value, noise) in [(1.0, 1.0), (2.0, 0.25)] {
            g.correct(&g.innovation(0, 1.0, value, noise));
        }
        let precision = 0.25 + 1.0 + 4.0;
        // A few roundings of numbers of order one.
        assert!((g.covariance(0, 0) - 1.0 / precision).abs() < 1e-15);
        assert!((g.mean[0] - (1.0 + 8.0) / precision).abs() < 1e-15);
        // The other one is untouched.
        assert_eq!((g.mean[1], g.sd(1)), (0.0, 3.0));
    }

    #[test]
    fn analytic_measured_without_error() {
        let mut g = Gaussian::<f32, 2, 3>::from_sd([1e3, 1e-3]);
        g.correct(&g.innovation(0, 1.0, 5.0, 0.0));
        assert_eq!((g.mean[0], g.sd(0)), (5.0, 0.0));
        // Again, the same: nothing to divide by.
        let again = g.innovation(0, 1.0, 5.0, 0.0);
        assert_eq!(again.nis(), 0.0);
        g.correct(&again);
        assert_eq!((g.mean[0], g.sd(0)), (5.0, 0.0));
        assert!(g.innovation(0, 1.0, 5.1, 0.0).nis() > 1e30);
    }

    #[test]
    fn analytic_places_of_a_symmetric_matrix_follow_each_other() {
        let places = (0..5).flat_map(|i| (i..5).map(move |j| at::<5>(i, j)));
        assert!(places.eq(0..15));
        let mut g = Gaussian::<f64, 2, 3>::from_sd([1.0, 2.0]);
        g.set_covariance(1, 0, 0.5);
        assert_eq!((g.covariance(0, 1), g.covariance), (0.5, [1.0, 0.5, 4.0]));
        // 1 + 4 - 2/2.
        assert_eq!(g.sd_of_difference(0, 1), 2.0);
    }

    #[test]
    fn analytic_a_number_that_is_not_finite_is_found_anywhere() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in 0..5 {
                let mut g = Gaussian::<f64, 2, 3>::from_sd([1e150, 2.0]);
                assert!(g.is_finite());
                match place {
                    0..2 => g.mean[place] = bad,
                    _ => g.covariance[place - 2] = bad,
                }
                assert!(!g.is_finite());
            }
        }
    }
}
