//! Products of noisy fields without the bias of their noise.
//!
//! With `u = u₀ + ε`, ε normal with variance σ², the Hermite polynomials `He_n(u)` (`u² - σ²`, `u³ - 3 σ² u`, ...) have
//! the mean `u₀ⁿ`, and
//!
//! ```text
//! E[He_a He_b] = Σ_k k! C(a,k) C(b,k) σ^2k u₀^(a + b - 2 k)
//! ```
//!
//! in which `u₀ⁿ` may again be replaced by `He_n(u)`: products and covariances of noisy terms, with no bias at any noise.
//!
//! Source: M. Abramowitz, I. A. Stegun, "Handbook of Mathematical Functions" (1964), chapter 22; linearisation of products:
//! E. Feldheim, Journal of the London Mathematical Society 13 (1938).

use super::data::FieldData;

/// `He_n(u)` of variance `variance`.
fn hermite(n: u8, u: f64, variance: f64) -> f64 {
    let (mut before, mut now) = (0.0, 1.0);
    for k in 0..n {
        (before, now) = (now, u * now - f64::from(k) * variance * before);
    }
    now
}

/// The fields at a point, with their noise.
#[derive(Clone, Copy)]
pub(super) struct NoisyFields<'a> {
    pub(super) data: &'a FieldData,
    /// Variances of the fields' noise.
    pub(super) variances: &'a [f64],
    /// By axis, the correlation of noise 0, 1, 2, ... samples apart.
    pub(super) correlations: &'a [Vec<f64>],
}

impl NoisyFields<'_> {
    /// The product of powers at every point, without the bias of noise.
    pub(super) fn product(self, powers: &[u8]) -> Vec<f64> {
        let at = |i: usize| self.factors(powers, i).product();
        (0..self.data.points()).map(at).collect()
    }

    fn factors(self, powers: &[u8], i: usize) -> impl Iterator<Item = f64> {
        let fields = powers.iter().enumerate().filter(|(_, p)| **p > 0);
        fields.map(move |(f, p)| hermite(*p, self.data.values(f)[i], self.variances[f]))
    }

    /// The derivative of the product by a field at every point.
    pub(super) fn derivative(self, powers: &[u8], field: usize) -> Vec<f64> {
        let power = powers[field];
        if power == 0 {
            return vec![0.0; self.data.points()];
        }
        let mut lower = powers.to_vec();
        lower[field] -= 1;
        let mut out = self.product(&lower);
        out.iter_mut().for_each(|v| *v *= f64::from(power));
        out
    }

    /// The covariance of two products at every point; 0 where a field is missing.
    pub(super) fn covariance(self, a: &[u8], b: &[u8]) -> Vec<f64> {
        let at = |i: usize| {
            // Means of the product without noise, and what noise that both share adds: not as a difference, which would lose it.
            let (mut apart, mut covariance) = (1.0, 0.0);
            for (f, (&a, &b)) in a
                .iter()
                .zip(b)
                .enumerate()
                .filter(|(_, (a, b))| **a + **b > 0)
            {
                let (u, variance) = (self.data.values(f)[i], self.variances[f]);
                let (mut shared, mut factor) = (0.0, 1.0);
                for k in 0..a.min(b) {
                    factor *= variance * f64::from(a - k) * f64::from(b - k) / f64::from(k + 1);
                    shared += factor * hermite(a + b - 2 * k - 2, u, variance);
                }
                let own = hermite(a + b, u, variance);
                covariance = covariance * (own + shared) + apart * shared;
                apart *= own;
            }
            if covariance.is_finite() {
                covariance
            } else {
                0.0
            }
        };
        (0..self.data.points()).map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::pde::data::Axis;

    #[test]
    fn analytic_products_and_covariances_have_no_bias() {
        // 160 000 draws about (u, v) = (1.3, -0.4) with standard deviations 0.5 and 0.3.
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let mut draw = |mean: f64, sigma: f64| -> Vec<f64> {
            let one = |z: f64| mean + sigma * z;
            (0..160_000)
                .map(|_| one(StandardNormal.sample(&mut rng)))
                .collect()
        };
        let fields = vec![
            ("u".to_owned(), draw(1.3, 0.5)),
            ("v".to_owned(), draw(-0.4, 0.3)),
        ];
        let axes = [Axis::even("t", 1.0, 400), Axis::even("x", 1.0, 400)];
        let data = FieldData::new(axes.map(Result::unwrap).to_vec(), fields).unwrap();
        let noisy = NoisyFields {
            data: &data,
            variances: &[0.25, 0.09],
            correlations: &[vec![1.0], vec![1.0]],
        };
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (a, b) = ([3, 1], [1, 2]);
        let (of_a, of_b) = (noisy.product(&a), noisy.product(&b));
        let (mean_a, mean_b) = (1.3_f64.powi(3) * -0.4, 1.3 * 0.16);
        // Standard errors of these means, from the draws: 0.0045, 0.0011 and 0.004.
        assert!((mean(&of_a) - mean_a).abs() < 0.014, "{}", mean(&of_a));
        assert!((mean(&of_b) - mean_b).abs() < 0.004, "{}", mean(&of_b));
        let pairs = of_a.iter().zip(&of_b);
        let seen = mean(
            &pairs
                .map(|(x, y)| (x - mean_a) * (y - mean_b))
                .collect::<Vec<_>>(),
        );
        let told = mean(&noisy.covariance(&a, &b));
        assert!(
            (seen - told).abs() < 0.03 * seen.abs().max(1.0),
            "{seen} {told}"
        );
        let slope = mean(&noisy.derivative(&a, 0));
        assert!((slope - 3.0 * 1.69 * -0.4).abs() < 0.02, "{slope}");
    }
}
