//! Test functions along an axis: weights, the placing of windows, sums over them.

use rayon::prelude::*;

/// Power of the test functions `(1 - ξ²)^12`: eight derivatives of the fourth are smooth at the ends.
pub(super) const POWER: u32 = 12;
/// Samples on either side of a centre, at least: the trapezoid's error of a test function of fewer is above 1e-7.
pub(super) const REACH: usize = 4;
/// Centres lie a quarter of a half-width apart.
const SPACING: usize = 4;

/// The windows along one axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisWindows {
    /// Points of the axis.
    points: usize,
    step: f64,
    /// The half-width, in steps.
    reach: usize,
    spacing: usize,
    /// Windows along the axis.
    pub(super) count: usize,
}

impl AxisWindows {
    /// Windows of a half-width of `reach` steps; `reach` is at most a half of the axis's steps.
    pub(super) fn new(points: usize, step: f64, reach: usize) -> Self {
        let spacing = (reach / SPACING).max(1);
        Self {
            points,
            step,
            reach,
            spacing,
            count: (points - 1 - 2 * reach) / spacing + 1,
        }
    }

    /// Points of the axis.
    pub(super) fn points(&self) -> usize {
        self.points
    }

    /// The half-width, in the axis's unit.
    pub(super) fn half_width(&self) -> f64 {
        self.reach as f64 * self.step
    }

    /// The share of the windows that are independent: those half of a half-width apart.
    pub(super) fn independent(&self) -> f64 {
        (2.0 * self.spacing as f64 / self.reach as f64).min(1.0)
    }

    /// First sample of window `k`, whose weights are those of the inside of its support.
    fn first(&self, k: usize) -> usize {
        k * self.spacing + 1
    }

    /// `(-1)^order φ⁽ᵒʳᵈᵉʳ⁾(x_i) Δx` at the samples inside the support, divided by `∫ φ dx`.
    pub(super) fn weights(&self, order: u8) -> Vec<f64> {
        let reach = self.reach as i64;
        let inside = || (1 - reach)..reach;
        let at = |i: i64| i as f64 / self.reach as f64;
        let area: f64 = inside().map(|i| derivative(0, at(i))).sum();
        let scale = (-1.0 / self.half_width()).powi(i32::from(order)) / area;
        inside().map(|i| scale * derivative(order, at(i))).collect()
    }

    /// `Σ_k w_a(i - k) Σ_j ρ(i - j) w_b(j - k)` at every sample, for the weights of two orders and the correlation ρ of samples
    /// 0, 1, 2, ... apart.
    pub(super) fn overlap(&self, a: u8, b: u8, correlation: &[f64]) -> Vec<f64> {
        let spread = convolved(&self.weights(b), 1, correlation);
        let products: Vec<f64> = self
            .weights(a)
            .iter()
            .zip(spread)
            .map(|(a, b)| a * b)
            .collect();
        let mut out = vec![0.0; self.points];
        for k in 0..self.count {
            let covered = &mut out[self.first(k)..][..products.len()];
            covered.iter_mut().zip(&products).for_each(|(o, p)| *o += p);
        }
        out
    }

    /// Sums of `data`, an array of `outer` by this axis by `inner`, over the windows: `outer` by windows by `inner`.
    pub(super) fn sum(&self, data: &[f64], inner: usize, order: u8) -> Vec<f64> {
        let weights = self.weights(order);
        let outer = data.len() / (self.points * inner);
        let mut out = vec![0.0; outer * self.count * inner];
        out.par_chunks_mut(inner)
            .enumerate()
            .for_each(|(row, out)| {
                let (o, k) = (row / self.count, row % self.count);
                let start = (o * self.points + self.first(k)) * inner;
                let covered = &data[start..start + weights.len() * inner];
                if let [out] = out {
                    *out = covered.iter().zip(&weights).map(|(v, w)| v * w).sum();
                    return;
                }
                for (line, w) in covered.chunks_exact(inner).zip(&weights) {
                    out.iter_mut().zip(line).for_each(|(o, v)| *o += w * v);
                }
            });
        out
    }

    /// The transpose of [`sum`](Self::sum): from windows back to samples.
    pub(super) fn spread(&self, data: &[f64], inner: usize, order: u8) -> Vec<f64> {
        let weights = self.weights(order);
        let outer = data.len() / (self.count * inner);
        let mut out = vec![0.0; outer * self.points * inner];
        let parts = out.par_chunks_mut(self.points * inner);
        parts.enumerate().for_each(|(o, part)| {
            for k in 0..self.count {
                let line = &data[(o * self.count + k) * inner..][..inner];
                let covered = &mut part[self.first(k) * inner..][..weights.len() * inner];
                for (to, w) in covered.chunks_exact_mut(inner).zip(&weights) {
                    to.iter_mut().zip(line).for_each(|(t, v)| *t += w * v);
                }
            }
        });
        out
    }
}

/// `Σ_j ρ(i - j) v_j` along a line of samples that are each `inner` values.
pub(super) fn convolved(line: &[f64], inner: usize, correlation: &[f64]) -> Vec<f64> {
    let mut out = line.to_vec();
    for (lag, c) in correlation.iter().enumerate().skip(1) {
        let by = (lag * inner).min(line.len());
        let rest = line.len() - by;
        let later = out[..rest].iter_mut().zip(&line[by..]);
        later.for_each(|(o, v)| *o += c * v);
        let earlier = out[by..].iter_mut().zip(&line[..rest]);
        earlier.for_each(|(o, v)| *o += c * v);
    }
    out
}

/// The derivative of `(1 - ξ²)^p = (1 - ξ)^p (1 + ξ)^p` of an order up to p, by Leibniz's rule.
fn derivative(order: u8, xi: f64) -> f64 {
    let power = POWER as i32;
    let falling = |k: i32| (0..k).map(|i| f64::from(power - i)).product::<f64>();
    let mut binomial = 1.0;
    let mut sum = 0.0;
    for k in 0..=i32::from(order) {
        let rest = i32::from(order) - k;
        let left = falling(k) * (1.0 - xi).powi(power - k) * (-1.0_f64).powi(k);
        sum += binomial * left * falling(rest) * (1.0 + xi).powi(power - rest);
        binomial *= f64::from(rest) / f64::from(k + 1);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_sums_are_the_derivatives_of_polynomials() {
        // By parts, Σ w_q u = ∫ φ u⁽q⁾ / ∫ φ: for u = x^q it is q!. The trapezoid of a test function that vanishes with its
        // first derivatives at both ends has an error that falls as the power of the spacing: 1.3e-6 and some 1e-4 for the
        // third and fourth derivative of one with 12 steps.
        let windows = AxisWindows::new(41, 0.1, 12);
        for order in 0..=4 {
            let data: Vec<f64> = (0..41).map(|i| (0.1 * f64::from(i)).powi(order)).collect();
            let expected: f64 = (1..=order).map(f64::from).product();
            for found in windows.sum(&data, 1, order as u8) {
                assert!(
                    (found - expected).abs() < 1e-3 * expected,
                    "{order}: {found}"
                );
            }
        }
        // x² over a symmetric window, first derivative: twice the centre.
        let data: Vec<f64> = (0..41).map(|i| (0.1 * f64::from(i)).powi(2)).collect();
        let found = windows.sum(&data, 1, 1);
        assert!((found[0] - 2.4).abs() < 1e-8 && (found[1] - 3.0).abs() < 1e-8);
    }

    #[test]
    fn prop_spreading_is_the_transpose_of_summing() {
        let windows = AxisWindows::new(30, 0.5, 5);
        let wave = |n: usize, w: f64| (0..n).map(|i| (w * i as f64).sin()).collect::<Vec<f64>>();
        for order in [0, 1, 3] {
            let (data, rows) = (wave(2 * 30 * 3, 0.7), wave(2 * windows.count * 3, 1.3));
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let left = dot(&windows.sum(&data, 3, order), &rows);
            let right = dot(&data, &windows.spread(&rows, 3, order));
            assert!((left - right).abs() < 1e-10 * left.abs().max(1.0));
        }
    }

    #[test]
    fn prop_overlaps_are_sums_over_windows() {
        let windows = AxisWindows::new(30, 0.5, 5);
        let sum: f64 = windows.overlap(1, 2, &[1.0]).iter().sum();
        let weights = windows.weights(1).into_iter().zip(windows.weights(2));
        let one: f64 = weights.map(|(a, b)| a * b).sum();
        assert!((sum - one * windows.count as f64).abs() < 1e-12);
        let inside = windows.overlap(0, 0, &[1.0])[15];
        assert!(inside > 0.0);
    }
}
