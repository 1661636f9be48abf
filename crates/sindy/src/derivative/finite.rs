//! Finite differences of order 2, 4 and 6 on any increasing grid.
//!
//! The derivative at `t_i` is the slope there of the polynomial of degree `order` through `order + 1`
//! neighbouring samples, centred on `i` and shifted inward at the ends:
//!
//! ```text
//! ẏ_i = Σ_k w_k y_k,   error O(Δt^order),   noise gain σ √(Σ w²)  (0.71 σ/Δt for order 2, 0.95 for 4, 1.08 for 6)
//! ```
//!
//! Nothing is smoothed: on noisy data prefer any other method of [`super`].
//!
//! Source: B. Fornberg, "Generation of finite difference formulas on arbitrarily spaced grids",
//! Mathematics of Computation 51 (1988).

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::data::grid;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;

/// Finite differences of a given order, checked when built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FiniteDifference {
    order: usize,
}

impl FiniteDifference {
    /// Differences whose error falls with the `order`-th power of the period: 2, 4 or 6.
    ///
    /// # Errors
    /// Any other order.
    pub fn new(order: usize) -> Result<Self, SindyError> {
        if matches!(order, 2 | 4 | 6) {
            Ok(Self { order })
        } else {
            Err(SindyError::setting("order", "2, 4 or 6", order))
        }
    }

    /// The order of accuracy.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Differentiates `y` sampled at `time`; the values are handed back as they are.
    ///
    /// # Errors
    /// Fewer than `order + 1` samples, lengths that differ, non-finite values, times that do not increase.
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        grid::check(time, y, self.points())?;
        let mut derivative = vec![0.0; y.len()];
        match grid::uniform_period(time) {
            Some(dt) => self.uniform(dt, y, 0..y.len(), &mut derivative),
            None => self.non_uniform(time, y, 0..y.len(), &mut derivative),
        }
        Ok(Smoothed {
            value: y.to_vec(),
            derivative,
        })
    }

    /// Samples that one slope is taken from, and the fewest that a series may have.
    pub(crate) fn points(&self) -> usize {
        self.order + 1
    }

    /// The slopes at the samples `range` of a series with period `dt`.
    pub(crate) fn uniform(&self, dt: f64, y: &[f64], range: Range<usize>, out: &mut [f64]) {
        let (n, points, half) = (y.len(), self.points(), self.order / 2);
        let offsets: [f64; 7] = std::array::from_fn(|k| k as f64);
        let mut weights = [0.0; 7];
        for at in 0..points {
            slope_weights(&offsets[..points], at, &mut weights);
            let all = match at {
                a if a < half => a..a + 1,
                a if a > half => n - points + a..n - points + a + 1,
                _ => half..n - half,
            };
            let (from, to) = (all.start.max(range.start), all.end.min(range.end));
            if from < to {
                let part = &y[from - at..to - at + points - 1];
                let out = &mut out[from - range.start..to - range.start];
                pulp::Arch::new().dispatch(Convolution {
                    weights: weights.map(|w| w / dt),
                    points,
                    y: part,
                    out,
                });
            }
        }
    }

    /// The slopes at the samples `range` of a series at `time`.
    pub(crate) fn non_uniform(
        &self,
        time: &[f64],
        y: &[f64],
        range: Range<usize>,
        out: &mut [f64],
    ) {
        let (n, points, half) = (y.len(), self.points(), self.order / 2);
        let mut weights = [0.0; 7];
        for (i, out) in range.zip(out) {
            let s = i.saturating_sub(half).min(n - points);
            slope_weights(&time[s..s + points], i - s, &mut weights);
            *out = weights
                .iter()
                .zip(&y[s..s + points])
                .map(|(w, y)| w * y)
                .sum();
        }
    }
}

/// `out_i = Σ_k w_k y_{i+k}`, in whatever vector instructions the processor has: the same operations in the same
/// order, and so the same bits.
struct Convolution<'a> {
    weights: [f64; 7],
    points: usize,
    y: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Convolution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match self.points {
            3 => self.run::<3>(),
            5 => self.run::<5>(),
            _ => self.run::<7>(),
        }
    }
}

impl Convolution<'_> {
    #[inline(always)]
    fn run<const P: usize>(self) {
        let (w, n) = (self.weights, self.out.len());
        let mut y: [&[f64]; P] = [&[]; P];
        for (k, y) in y.iter_mut().enumerate() {
            *y = &self.y[k..k + n];
        }
        for (i, out) in self.out.iter_mut().enumerate() {
            let mut sum = w[0] * y[0][i];
            for k in 1..P {
                sum += w[k] * y[k][i];
            }
            *out = sum;
        }
    }
}

/// Weights of the slope at `points[at]` of the polynomial through `points`: the derivatives of the
/// Lagrange polynomials, `w_k = c_a / (c_k (t_a - t_k))` with `c_k = Π_{j≠k} (t_k - t_j)`, and `w_a` the
/// negative sum of the others.
fn slope_weights(points: &[f64], at: usize, weights: &mut [f64; 7]) {
    let product = |k: usize| -> f64 {
        points
            .iter()
            .enumerate()
            .filter(|&(j, _)| j != k)
            .map(|(_, &t)| points[k] - t)
            .product()
    };
    let own = product(at);
    let mut sum = 0.0;
    for k in (0..points.len()).filter(|&k| k != at) {
        let w = own / (product(k) * (points[at] - points[k]));
        weights[k] = w;
        sum += w;
    }
    weights[at] = -sum;
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grids() -> [Vec<f64>; 2] {
        let t = |i: i32| 0.1 * f64::from(i);
        [
            (0..30).map(t).collect(),
            (0..30)
                .map(|i| t(i) + 0.03 * (2.0 * f64::from(i)).sin())
                .collect(),
        ]
    }

    fn signal(t: f64) -> f64 {
        (1.7 * t).sin() + 0.2 * (5.0 * t).cos()
    }

    /// Made with PySINDy 2.1.0 on NumPy 2.4.6: `i = arange(30); t = 0.1*i` (grid 0) or
    /// `0.1*i + 0.03*sin(2*i)` (grid 1), `y = sin(1.7*t) + 0.2*cos(5*t)`,
    /// `FiniteDifference(order=o)._differentiate(y[:, None], t)`; slopes at samples 0, 1, 2, 14, 27, 28, 29.
    /// Those of order 2 are `numpy.gradient(y, t, edge_order=2)` as well.
    #[test]
    fn xval_pysindy_finite_difference() {
        let expected = [
            (
                2,
                0,
                [
                    1.686239462329199,
                    1.2077377665722118,
                    0.7881291288568868,
                    -1.8543890521696507,
                    -0.9772535734480794,
                    -0.8693259169520298,
                    -0.6483040390388286,
                ],
            ),
            (
                2,
                1,
                [
                    1.6838915308644422,
                    1.0744361647503222,
                    0.8635178038399949,
                    -1.915742554634428,
                    -0.9884245851825102,
                    -0.8823209136433072,
                    -0.5636860194953126,
                ],
            ),
            (
                4,
                0,
                [
                    1.708614546149593,
                    1.1937357321830075,
                    0.7628691245516497,
                    -1.8859782817485697,
                    -1.0096954635511688,
                    -0.9122801744603719,
                    -0.55713934031952,
                ],
            ),
            (
                4,
                1,
                [
                    1.7103222408567942,
                    1.064789757996953,
                    0.849573502873869,
                    -1.9326327222209239,
                    -1.0056510821859503,
                    -0.9440341591891268,
                    -0.3999540185628545,
                ],
            ),
            (
                6,
                0,
                [
                    1.6979781892839991,
                    1.196413099083014,
                    0.7610720281625729,
                    -1.8872709377905728,
                    -1.0113942013207398,
                    -0.9095120123411092,
                    -0.5690922106561944,
                ],
            ),
            (
                6,
                1,
                [
                    1.6977542985159546,
                    1.0662090012592527,
                    0.8484215569319817,
                    -1.93346751356681,
                    -1.0067311987371084,
                    -0.940978860571259,
                    -0.42408624654489735,
                ],
            ),
        ];
        for (order, grid, slopes) in expected {
            let t = &grids()[grid];
            let y: Vec<f64> = t.iter().map(|&t| signal(t)).collect();
            let out = FiniteDifference::new(order).unwrap().apply(t, &y).unwrap();
            for (k, slope) in [0, 1, 2, 14, 27, 28, 29].into_iter().zip(slopes) {
                // Two ways to the same weights, of up to 300 at the ends: rounding of some 1e-14 each.
                assert!(
                    (out.derivative[k] - slope).abs() < 1e-11,
                    "{order} {grid} {k}"
                );
            }
        }
    }

    #[test]
    fn prop_every_register_width_gives_the_same_bits() {
        let y: Vec<f64> = (0..1003).map(|i| signal(0.013 * f64::from(i))).collect();
        for points in [3, 5, 7] {
            let run = |width: usize| {
                let mut out = vec![0.0; y.len() - points + 1];
                let c = Convolution {
                    weights: [0.3, -0.7, 0.11, 0.2, -1.3, 0.5, 0.9],
                    points,
                    y: &y,
                    out: &mut out,
                };
                match width {
                    0 => c.with_simd(pulp::Scalar), // no vector instructions beyond the target's
                    _ => pulp::Arch::new().dispatch(c),
                }
                out
            };
            assert_eq!(run(0), run(1));
        }
    }

    #[test]
    fn analytic_textbook_weights() {
        let mut w = [0.0; 7];
        slope_weights(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3, &mut w);
        // Exact fractions of the sixth-order central formula; rounding of a few products.
        for (w, e) in w.iter().zip([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) {
            assert!((w - e / 60.0).abs() < 1e-15);
        }
    }

    #[test]
    fn analytic_error_falls_with_the_order() {
        for order in [2, 4, 6] {
            let error = |n: usize| {
                let t: Vec<f64> = (0..=n).map(|i| 2.0 * i as f64 / n as f64).collect();
                let y: Vec<f64> = t.iter().map(|&t| signal(t)).collect();
                let d = FiniteDifference::new(order).unwrap().apply(&t, &y).unwrap();
                t.iter()
                    .zip(&d.derivative)
                    .map(|(t, d)| (d - 1.7 * (1.7 * t).cos() + (5.0 * t).sin()).abs())
                    .fold(0.0, f64::max)
            };
            let observed = (error(200) / error(400)).log2();
            // The next order contributes a few percent at these steps.
            assert!(
                (observed - order as f64).abs() < 0.25,
                "{order}: {observed}"
            );
        }
    }

    #[test]
    fn prop_bad_input_is_named() {
        assert!(matches!(
            FiniteDifference::new(3),
            Err(SindyError::Setting { key: "order", .. })
        ));
        let d = FiniteDifference::new(4).unwrap();
        assert!(matches!(
            d.apply(&[0.0, 1.0], &[0.0, 1.0]),
            Err(SindyError::TooShort {
                needed: 5,
                found: 2
            })
        ));
    }

    proptest! {
        #[test]
        fn prop_polynomials_of_the_order_are_exact(
            c in proptest::collection::vec(-2.0..2.0f64, 7),
            steps in proptest::collection::vec(0.05..0.4f64, 12),
            order in prop_oneof![Just(2usize), Just(4), Just(6)],
        ) {
            let time: Vec<f64> = steps.iter().scan(-1.0, |t, s| { *t += s; Some(*t) }).collect();
            let c = &c[..=order];
            let p = |t: f64| c.iter().rev().fold(0.0, |a, &c| a * t + c);
            let dp = |t: f64| (1..c.len()).rev().fold(0.0, |a, k| a * t + k as f64 * c[k]);
            let y: Vec<f64> = time.iter().map(|&t| p(t)).collect();
            let size = y.iter().fold(1.0f64, |m, v| m.max(v.abs()));
            let out = FiniteDifference::new(order).unwrap().apply(&time, &y).unwrap();
            for (t, d) in time.iter().zip(&out.derivative) {
                // Rounding times weights of up to 1e4 at the ends of such uneven steps.
                prop_assert!((d - dp(*t)).abs() < 1e-10 * size, "{} {}", d, dp(*t));
            }
        }
    }
}
