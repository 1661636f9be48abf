//! Cubic smoothing spline on any increasing grid, in O(n).
//!
//! The natural cubic spline `f` with knots at the samples that minimises
//!
//! ```text
//! Σ w_i (y_i - f(t_i))² + λ ∫ f''(t)² dt
//! ```
//!
//! `λ` (unit: time³, with unit weights) is given, or minimises the generalised cross-validation score
//! `GCV(λ) = n Σ w_i r_i² / (n - tr H)²`, which asks for independent noise of variance `∝ 1/w`.
//! Reinsch's form: the second derivatives `γ` at the inner knots solve the banded system
//! `(R + λ QᵀW⁻¹Q) γ = Qᵀ y`, and `f = y - λ W⁻¹ Q γ`; `tr H` comes from the central bands of the inverse.
//! Times are scaled by the mean period inside.
//!
//! Sources: C. H. Reinsch, "Smoothing by spline functions", Numerische Mathematik 10 (1967); P. Craven,
//! G. Wahba, Numerische Mathematik 31 (1979); M. F. Hutchinson, F. R. de Hoog, "Smoothing noisy data with
//! spline functions", Numerische Mathematik 47 (1985).

use crate::data::grid;
use crate::derivative::savgol::Smoothed;
use crate::error::{SindyError, same_size};
use crate::numerics::minimum_on_grid;

/// How strongly a spline smooths.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Strength {
    Given(f64),
    CrossValidated,
}

/// Settings of a smoothing spline, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingSpline {
    strength: Strength,
}

/// A fitted smoothing spline at its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineFit {
    /// Value and slope at the samples.
    pub smoothed: Smoothed,
    /// The `λ` that was used, in time³.
    pub lambda: f64,
    /// The generalised cross-validation score there, in the signal's unit squared.
    pub gcv: f64,
    /// Equivalent number of parameters, `tr H`: 2 (a line) to n (interpolation).
    pub degrees_of_freedom: f64,
    /// Noise estimate `√(Σ w r² / (n - tr H))`, in the signal's unit (of a sample with weight 1).
    pub noise: f64,
}

impl SmoothingSpline {
    /// A spline with smoothing strength `lambda` in time³: positive and finite.
    ///
    /// # Errors
    /// Any other `lambda`.
    pub fn new(lambda: f64) -> Result<Self, SindyError> {
        if lambda > 0.0 && lambda.is_finite() {
            Ok(Self {
                strength: Strength::Given(lambda),
            })
        } else {
            Err(SindyError::setting("lambda", "positive and finite", lambda))
        }
    }

    /// A spline whose smoothing strength is chosen by generalised cross-validation.
    #[must_use]
    pub fn cross_validated() -> Self {
        Self {
            strength: Strength::CrossValidated,
        }
    }

    /// The smoothing strength in time³, `None` where it is chosen from the data.
    #[must_use]
    pub fn lambda(&self) -> Option<f64> {
        match self.strength {
            Strength::Given(lambda) => Some(lambda),
            Strength::CrossValidated => None,
        }
    }

    /// Smooths `y` sampled at `time` and differentiates it.
    ///
    /// # Errors
    /// As [`SmoothingSpline::fit`].
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        Ok(self.fit(time, y, None)?.smoothed)
    }

    /// Fits the spline, with one positive weight per sample or all equal to one.
    ///
    /// # Errors
    /// Fewer than 4 samples, lengths that differ, non-finite values, times that do not increase, weights
    /// that are not positive, a grid so uneven that the equations are singular.
    pub fn fit(
        &self,
        time: &[f64],
        y: &[f64],
        weights: Option<&[f64]>,
    ) -> Result<SplineFit, SindyError> {
        grid::check(time, y, 4)?;
        let n = y.len();
        if let Some(w) = weights {
            same_size("weights and signal", n, w.len())?;
            if let Some(w) = w.iter().find(|w| !(**w > 0.0) || !w.is_finite()) {
                return Err(SindyError::setting("weights", "positive and finite", w));
            }
        }
        let dt = grid::mean_period(time);
        let system = System::new(time, y, weights, dt);
        let lambda = match self.strength {
            Strength::Given(lambda) => lambda / dt.powi(3),
            Strength::CrossValidated => {
                // From interpolation to a straight line (the smoothest mode has the penalty (π/n)⁴); beyond
                // 1e12 the banded equations lose their digits.
                let top = (4.0 * (n as f64).log10() + 1.0).min(12.0);
                let points = (2.0 * (top + 6.0)) as usize + 1;
                let (best, _) = minimum_on_grid(-6.0, top, points, |e| {
                    system.solve(10f64.powf(e)).map_or(f64::INFINITY, |s| s.gcv)
                });
                10f64.powf(best)
            }
        };
        let solution = system.solve(lambda).ok_or(SindyError::Singular {
            what: "smoothing spline",
        })?;
        Ok(SplineFit {
            smoothed: system.at_samples(&solution, dt),
            lambda: lambda * dt.powi(3),
            gcv: solution.gcv,
            degrees_of_freedom: n as f64 - solution.residual_trace,
            noise: (solution.squares / solution.residual_trace).sqrt(),
        })
    }
}

/// What does not depend on `λ`: steps, weights and bands, in units of the mean period.
struct System<'a> {
    y: &'a [f64],
    step: Vec<f64>,
    inverse_weight: Vec<f64>,
    /// `Qᵀ y`.
    rhs: Vec<f64>,
    /// Diagonal and first band of `R`.
    r: Vec<[f64; 2]>,
    /// Diagonal, first and second band of `QᵀW⁻¹Q`.
    g: Vec<[f64; 3]>,
}

struct Solution {
    value: Vec<f64>,
    /// Second derivatives at all knots, zero at the ends, per mean period squared.
    gamma: Vec<f64>,
    gcv: f64,
    squares: f64,
    residual_trace: f64,
}

impl<'a> System<'a> {
    fn new(time: &[f64], y: &'a [f64], weights: Option<&[f64]>, dt: f64) -> Self {
        let n = y.len();
        let m = n - 2;
        let step: Vec<f64> = (1..n).map(|i| (time[i] - time[i - 1]) / dt).collect();
        let inverse_weight: Vec<f64> = match weights {
            Some(w) => w.iter().map(|w| 1.0 / w).collect(),
            None => vec![1.0; n],
        };
        let q = |i: usize| q(&step, i);
        let v = &inverse_weight;
        let rhs = (0..m)
            .map(|i| (y[i + 2] - y[i + 1]) / step[i + 1] - (y[i + 1] - y[i]) / step[i])
            .collect();
        let r = (0..m)
            .map(|i| [(step[i] + step[i + 1]) / 3.0, step[i + 1] / 6.0])
            .collect();
        let g = (0..m)
            .map(|i| {
                let a = q(i);
                let mut bands = [(0..3).map(|k| a[k] * a[k] * v[i + k]).sum(), 0.0, 0.0];
                if i + 1 < m {
                    let b = q(i + 1);
                    bands[1] = a[1] * b[0] * v[i + 1] + a[2] * b[1] * v[i + 2];
                }
                if i + 2 < m {
                    bands[2] = a[2] * q(i + 2)[0] * v[i + 2];
                }
                bands
            })
            .collect();
        Self {
            y,
            step,
            inverse_weight,
            rhs,
            r,
            g,
        }
    }

    /// The fit for one `λ`; `None` where the factorisation breaks down.
    fn solve(&self, lambda: f64) -> Option<Solution> {
        let (n, m) = (self.y.len(), self.rhs.len());
        // B = R + λ G = L D Lᵀ with two bands below the diagonal.
        let mut d = vec![0.0; m];
        let mut l = vec![[0.0; 2]; m];
        let mut x = self.rhs.clone();
        for i in 0..m {
            let [g0, g1, g2] = self.g[i].map(|g| lambda * g);
            let (mut diagonal, mut first) = (self.r[i][0] + g0, self.r[i][1] + g1);
            if i >= 1 {
                diagonal -= l[i - 1][0] * l[i - 1][0] * d[i - 1];
                first -= l[i - 1][0] * l[i - 1][1] * d[i - 1];
                x[i] -= l[i - 1][0] * x[i - 1];
            }
            if i >= 2 {
                diagonal -= l[i - 2][1] * l[i - 2][1] * d[i - 2];
                x[i] -= l[i - 2][1] * x[i - 2];
            }
            if !(diagonal > 0.0) || !diagonal.is_finite() {
                return None;
            }
            d[i] = diagonal;
            if i + 1 < m {
                l[i][0] = first / diagonal;
            }
            if i + 2 < m {
                l[i][1] = g2 / diagonal;
            }
        }
        let mut gamma = vec![0.0; n];
        let mut trace = 0.0;
        // Bands (i, i..i+2) of the inverse, of rows i+1 and i+2 while walking up.
        let (mut next, mut after) = ([0.0; 3], [0.0; 3]);
        for i in (0..m).rev() {
            let [l1, l2] = l[i];
            gamma[i + 1] =
                x[i] / d[i] - l1 * gamma[i + 2] - if i + 2 < m { l2 * gamma[i + 3] } else { 0.0 };
            let s2 = -l1 * next[1] - l2 * after[0];
            let s1 = -l1 * next[0] - l2 * next[1];
            let s0 = 1.0 / d[i] - l1 * s1 - l2 * s2;
            let [g0, g1, g2] = self.g[i];
            trace += s0 * g0 + 2.0 * (s1 * g1 + s2 * g2);
            (after, next) = (next, [s0, s1, s2]);
        }
        let residual_trace = lambda * trace;
        let mut residual = vec![0.0; n];
        for i in 0..m {
            for (k, q) in q(&self.step, i).into_iter().enumerate() {
                residual[i + k] += q * gamma[i + 1];
            }
        }
        let mut squares = 0.0;
        for (r, v) in residual.iter_mut().zip(&self.inverse_weight) {
            let scaled = lambda * *r;
            squares += scaled * scaled * v;
            *r = scaled * v;
        }
        Some(Solution {
            value: self.y.iter().zip(&residual).map(|(y, r)| y - r).collect(),
            gamma,
            gcv: n as f64 * squares / (residual_trace * residual_trace),
            squares,
            residual_trace,
        })
    }

    fn at_samples(&self, solution: &Solution, dt: f64) -> Smoothed {
        let (f, g, h) = (&solution.value, &solution.gamma, &self.step);
        let n = f.len();
        let mut derivative: Vec<f64> = (0..n - 1)
            .map(|i| ((f[i + 1] - f[i]) / h[i] - h[i] * (2.0 * g[i] + g[i + 1]) / 6.0) / dt)
            .collect();
        let last = n - 2;
        derivative.push(
            ((f[n - 1] - f[last]) / h[last] + h[last] * (g[last] + 2.0 * g[n - 1]) / 6.0) / dt,
        );
        Smoothed {
            value: solution.value.clone(),
            derivative,
        }
    }
}

/// Column `i` of `Q`: rows `i` to `i + 2`.
fn q(step: &[f64], i: usize) -> [f64; 3] {
    let (a, b) = (1.0 / step[i], 1.0 / step[i + 1]);
    [a, -a - b, b]
}

#[cfg(test)]
mod tests;
