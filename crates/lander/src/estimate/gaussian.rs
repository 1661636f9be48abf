//! A normal distribution: linear propagation and correction.

use touchdown_flight::real::{Real, r};

/// Mean and covariance of N numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gaussian<R, const N: usize> {
    pub(crate) mean: [R; N],
    pub(crate) covariance: [[R; N]; N],
}

/// A scalar measurement `y = h x + noise`, compared with what was expected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation<R, const N: usize> {
    h: [R; N],
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

impl<R: Real, const N: usize> Gaussian<R, N> {
    /// Independent numbers of mean zero.
    pub(crate) fn from_sd(sd: [R; N]) -> Self {
        let mut covariance = [[R::ZERO; N]; N];
        for i in 0..N {
            covariance[i][i] = sd[i] * sd[i];
        }
        Self {
            mean: [R::ZERO; N],
            covariance,
        }
    }

    /// `x ← F x + u`, `P ← F P Fᵀ + Q`.
    pub(crate) fn propagate(&mut self, f: &[[R; N]; N], u: &[R; N], q: &[[R; N]; N]) {
        let mut mean = *u;
        let mut fp = [[R::ZERO; N]; N];
        for i in 0..N {
            for k in 0..N {
                let factor = f[i][k];
                mean[i] += factor * self.mean[k];
                for j in 0..N {
                    fp[i][j] += factor * self.covariance[k][j];
                }
            }
        }
        self.mean = mean;
        for i in 0..N {
            for j in i..N {
                let mut sum = q[i][j];
                for k in 0..N {
                    sum += fp[i][k] * f[j][k];
                }
                self.covariance[i][j] = sum;
                self.covariance[j][i] = sum;
            }
        }
    }

    /// Compares a measurement `value = h x` with what is expected.
    pub(crate) fn innovation(&self, h: [R; N], value: R, noise: R) -> Innovation<R, N> {
        let mut spread = [R::ZERO; N];
        let (mut residual, mut variance) = (value, noise);
        for i in 0..N {
            for j in 0..N {
                spread[i] += self.covariance[i][j] * h[j];
            }
            residual -= h[i] * self.mean[i];
            variance += h[i] * spread[i];
        }
        Innovation {
            h,
            spread,
            residual,
            noise,
            variance,
        }
    }

    /// Corrects by a measurement `value` of the number that `h` selects, whose error of the variance
    /// `noise` does not average out: the number is not known better afterwards, and a better known one is kept.
    pub(crate) fn learn_at_most(&mut self, h: [R; N], value: R, noise: R) {
        let innovation = self.innovation(h, value, noise);
        if innovation.variance < r::<R>(2.0) * noise {
            return;
        }
        self.correct(&innovation);
        for i in 0..N {
            if h[i] > R::ZERO {
                self.covariance[i][i] = self.covariance[i][i].max(noise);
            }
        }
    }

    /// Kalman correction in Joseph's form,
    /// `P ← (1 - K h) P (1 - K h)ᵀ + K noise Kᵀ`, which stays symmetric and
    /// positive under rounding. It changes nothing where the residual has no variance.
    pub(crate) fn correct(&mut self, innovation: &Innovation<R, N>) {
        if !(innovation.variance > R::ZERO) {
            return;
        }
        let gain = innovation.spread.map(|c| c / innovation.variance);
        // A = (1 - K h) P, then A (1 - K h)ᵀ = A - (A hᵀ) Kᵀ.
        let mut a = self.covariance;
        let mut ah = [R::ZERO; N];
        for i in 0..N {
            for j in 0..N {
                a[i][j] -= gain[i] * innovation.spread[j];
                ah[i] += a[i][j] * innovation.h[j];
            }
            self.mean[i] += gain[i] * innovation.residual;
        }
        for i in 0..N {
            for j in i..N {
                let c = a[i][j] - ah[i] * gain[j] + gain[i] * innovation.noise * gain[j];
                self.covariance[i][j] = c;
                self.covariance[j][i] = c;
            }
            // Rounding can make a vanishing variance negative.
            self.covariance[i][i] = self.covariance[i][i].max(R::ZERO);
        }
    }

    /// Standard deviation of number i.
    pub(crate) fn sd(&self, i: usize) -> R {
        self.covariance[i][i].max(R::ZERO).sqrt()
    }

    /// Standard deviation of number i less number j.
    pub(crate) fn sd_of_difference(&self, i: usize, j: usize) -> R {
        let p = &self.covariance;
        (p[i][i] + p[j][j] - r::<R>(2.0) * p[i][j])
            .max(R::ZERO)
            .sqrt()
    }

    /// Whether all numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.mean.iter().all(|c| c.is_finite())
            && self.covariance.iter().flatten().all(|c| c.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_measurements_of_one_number() {
        // Precisions add: prior 1/4, measurements 1/1 and 1/0.25.
        let mut g = Gaussian::<f64, 2>::from_sd([2.0, 3.0]);
        for (value, noise) in [(1.0, 1.0), (2.0, 0.25)] {
            g.correct(&g.innovation([1.0, 0.0], value, noise));
        }
        let precision = 0.25 + 1.0 + 4.0;
        // A few roundings of numbers of order one.
        assert!((g.covariance[0][0] - 1.0 / precision).abs() < 1e-15);
        assert!((g.mean[0] - (1.0 + 8.0) / precision).abs() < 1e-15);
        // The other one is untouched.
        assert_eq!((g.mean[1], g.sd(1)), (0.0, 3.0));
    }

    #[test]
    fn analytic_measured_without_error() {
        let mut g = Gaussian::<f32, 2>::from_sd([1e3, 1e-3]);
        g.correct(&g.innovation([1.0, 0.0], 5.0, 0.0));
        assert_eq!((g.mean[0], g.sd(0)), (5.0, 0.0));
        // Again, the same: nothing to divide by.
        let again = g.innovation([1.0, 0.0], 5.0, 0.0);
        assert_eq!(again.nis(), 0.0);
        g.correct(&again);
        assert_eq!((g.mean[0], g.sd(0)), (5.0, 0.0));
        assert!(g.innovation([1.0, 0.0], 5.1, 0.0).nis() > 1e30);
    }

    #[test]
    fn analytic_propagation_of_an_integrator() {
        let mut g = Gaussian::<f64, 2>::from_sd([1.0, 2.0]);
        g.mean = [1.0, -1.0];
        let f = [[1.0, 0.5], [0.0, 1.0]];
        g.propagate(&f, &[0.25, 0.0], &[[0.1, 0.0], [0.0, 0.2]]);
        assert_eq!(g.mean, [0.75, -1.0]);
        assert_eq!(g.covariance, [[2.1, 2.0], [2.0, 4.2]]);
        // (1, -1): 2.1 + 4.2 - 4.
        assert!((g.sd_of_difference(0, 1) - 2.3_f64.sqrt()).abs() < 1e-15);
    }
}
