//! Sparse relaxed regularised regression (SR3) with the ℓ0 penalty, solved at its fixed point.
//!
//! ```text
//! min over ξ, w   1/2 |y - Θ ξ|² + λ |w|₀ + 1/(2ν) |ξ - w|²
//! ```
//!
//! The published iteration alternates `ξ = (ΘᵀΘ + I/ν)⁻¹ (Θᵀy + w/ν)` and `w = H(ξ)`, where `H` keeps
//! the entries with `|ξ_j| > η = √(2 λ ν)`. It converges linearly at the rate `1/(1 + ν γ)`, γ the Gram
//! eigenvalues: for small ν thousands of steps. For a *given* support S, though, its limit is known in
//! closed form: least squares in which the excluded terms stay in with a ridge,
//!
//! ```text
//! min over u, v   1/2 |y - Θ_S u - Θ_N v|² + 1/(2ν) |v|²
//! ```
//!
//! so [`Path::Direct`] solves that p x p system, thresholds, and repeats until the support stands; the
//! support changes a handful of times. [`Path::Relaxation`] is the published iteration.
//!
//! ν has the unit of 1/Gram. With [`Scaling::UnitRms`] the columns and the target are divided by their
//! root mean square and the sums by the number of rows, so that λ and ν mean the same for any amount of
//! data and any units; with [`Scaling::None`] the objective is the one above to the letter.
//!
//! Sources: P. Zheng et al., "A unified framework for sparse relaxed regularized regression: SR3",
//! IEEE Access 7 (2019); K. Champion et al., "A unified sparse optimization framework to learn
//! parsimonious physics-informed models from data", IEEE Access 8 (2020).

mod fixed_support;
mod problem;

use nalgebra::{DMatrix, DVector};

use crate::error::{SindyError, above_zero, at_least_zero};
use crate::solve::fit::{Fit, Solver};
pub use crate::solve::outcome::Outcome;
use crate::statistics::gram::{Gram, check};
pub(super) use fixed_support::{FixedPoint, fixed_support};
pub(crate) use problem::Problem;
use problem::fixed_point;

/// Whether columns are scaled before the penalty sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// The objective to the letter: sums over all rows, coefficients in their own units.
    None,
    /// Columns and target divided by their root mean square, sums by the number of rows.
    UnitRms,
}

/// How the fixed point is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The limit of each support in closed form.
    Direct,
    /// The published alternating iteration, until `|w_k - w_{k-1}| / ν` falls below a tolerance of 1e-9.
    Relaxation,
}

/// Settings of SR3, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sr3 {
    pub(super) lambda: f64,
    pub(super) nu: f64,
    pub(super) scaling: Scaling,
    path: Path,
    pub(super) max_iterations: usize,
}

/// A solution of SR3, in the units of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The dense vector ξ.
    pub dense: DVector<f64>,
    /// The sparse vector w: ξ on the support, zero elsewhere.
    pub sparse: DVector<f64>,
    /// Plain least squares on the support.
    pub refit: DVector<f64>,
    /// Which terms are kept.
    pub support: Vec<bool>,
    /// Why the iteration ended.
    pub outcome: Outcome,
    /// Supports that were solved, or steps of the relaxation.
    pub iterations: usize,
    /// The objective above at the solution, in the scaling that was chosen.
    pub objective: f64,
}

impl Sr3 {
    /// SR3 with penalty `lambda` and relaxation `nu`, scaled, by the direct path.
    ///
    /// # Errors
    /// `lambda` negative or not finite, `nu` not positive.
    pub fn new(lambda: f64, nu: f64) -> Result<Self, SindyError> {
        Ok(Self {
            lambda: at_least_zero("lambda", lambda)?,
            nu: above_zero("nu", nu)?,
            scaling: Scaling::UnitRms,
            path: Path::Direct,
            max_iterations: 100,
        })
    }

    /// The same with another scaling.
    #[must_use]
    pub fn scaling(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// The same with another path and its iteration limit.
    #[must_use]
    pub fn path(self, path: Path, max_iterations: usize) -> Self {
        Self {
            path,
            max_iterations,
            ..self
        }
    }

    /// The threshold η = √(2 λ ν) below which a (scaled) coefficient is dropped.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        (2.0 * self.lambda * self.nu).sqrt()
    }

    /// Solves for the coefficients of `gram`.
    #[must_use]
    pub fn solve(&self, gram: &Gram) -> Solution {
        self.solve_again(&mut Problem::new(gram, self.scaling))
    }

    /// As [`Sr3::solve`], with what other λ and ν have already computed for the same statistics, in the
    /// problem's scaling.
    pub(crate) fn solve_again(&self, problem: &mut Problem<'_>) -> Solution {
        let found = match self.path {
            Path::Direct => self.direct(problem),
            Path::Relaxation => self.relax(&problem.g, &problem.b),
        };
        let sparse = found.on_support();
        let kept = found.support.iter().filter(|s| **s).count() as f64;
        let relaxed = (&found.dense - &sparse).norm_squared() / (2.0 * self.nu);
        let objective = problem.misfit(&found.dense) + self.lambda * kept + relaxed;
        let refit = problem.refit(&found.support);
        problem.solution(found, &sparse, refit, objective)
    }

    fn above(&self, xi: &DVector<f64>) -> Vec<bool> {
        let eta = self.threshold();
        xi.iter().map(|v| v.abs() > eta).collect()
    }

    fn direct(&self, problem: &mut Problem<'_>) -> FixedPoint {
        let all = vec![true; problem.b.len()];
        fixed_support(
            all,
            self.max_iterations,
            |support| Ok(problem.fixed_point(support, self.nu)),
            |xi| self.above(xi),
        )
    }

    fn relax(&self, g: &DMatrix<f64>, b: &DVector<f64>) -> FixedPoint {
        let p = b.len();
        let mut w = fixed_point(g, b, &vec![true; p], self.nu);
        let mut a = g.clone();
        (0..p).for_each(|j| a[(j, j)] += 1.0 / self.nu);
        let Some(factor) = a.cholesky() else {
            let support = self.above(&w);
            return FixedPoint::new(w, support, Outcome::IterationLimit, 0);
        };
        let mut xi = w.clone();
        for k in 1..=self.max_iterations {
            xi = factor.solve(&(b + &w / self.nu));
            let keep = self.above(&xi);
            let next = DVector::from_fn(p, |j, _| if keep[j] { xi[j] } else { 0.0 });
            let change = (&next - &w).norm() / self.nu;
            w = next;
            if change < 1e-9 {
                return FixedPoint::new(xi, keep, Outcome::Converged, k);
            }
        }
        let keep = self.above(&xi);
        FixedPoint::new(xi, keep, Outcome::IterationLimit, self.max_iterations)
    }
}

impl Solver for Sr3 {
    /// The refitted solution.
    fn fit(&self, gram: &Gram) -> Result<Fit, SindyError> {
        check(gram)?;
        let s = self.solve(gram);
        Ok(Fit::new(gram, s.refit, s.support, s.outcome, s.iterations))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::regression::least_squares;
    use rand::{RngExt, SeedableRng};

    /// Noisy data with known coefficients, and the rows themselves.
    fn data() -> (DMatrix<f64>, DVector<f64>, Gram) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let truth = [1.5, 0.0, -0.8, 0.0, 0.05];
        let theta = DMatrix::from_fn(200, 5, |_, _| rng.random_range(-1.0..1.0));
        let y = &theta * DVector::from_column_slice(&truth)
            + DVector::from_fn(200, |_, _| rng.random_range(-0.1..0.1));
        let gram = Gram {
            xtx: theta.transpose() * &theta,
            xty: theta.transpose() * &y,
            yty: y.norm_squared(),
            sum_y: y.sum(),
            rows: 200,
            ..Gram::zeros(5)
        };
        (theta, y, gram)
    }

    #[test]
    fn analytic_direct_path_is_the_limit_of_the_relaxation() {
        let (_, _, gram) = data();
        for nu in [1e-3, 1e-2, 1.0, 1e3] {
            let lambda = 0.3_f64.powi(2) / (2.0 * nu);
            let sr3 = Sr3::new(lambda, nu).unwrap().scaling(Scaling::None);
            let direct = sr3.solve(&gram);
            let relaxed = sr3.path(Path::Relaxation, 200_000).solve(&gram);
            assert_eq!(relaxed.outcome, Outcome::Converged, "nu {nu}");
            assert_eq!(direct.support, relaxed.support, "nu {nu}");
            // The relaxation stops at a step of 1e-9 ν; its remaining distance is that over νγ, γ about 60.
            assert!((&direct.dense - &relaxed.dense).amax() < 1e-8, "nu {nu}");
        }
    }

    #[test]
    fn analytic_fixed_point_is_ridge_on_the_excluded_terms() {
        let (theta, y, gram) = data();
        let nu = 0.02;
        let solution = Sr3::new(0.3_f64.powi(2) / (2.0 * nu), nu)
            .unwrap()
            .scaling(Scaling::None)
            .solve(&gram);
        assert_eq!(solution.support, [true, false, true, false, false]);
        // Stacked least squares: the excluded columns carry √(1/ν) rows of their own.
        let excluded: Vec<usize> = (0..5).filter(|&j| !solution.support[j]).collect();
        let mut a = theta.clone().resize_vertically(200 + excluded.len(), 0.0);
        for (r, &j) in excluded.iter().enumerate() {
            a[(200 + r, j)] = (1.0 / nu).sqrt();
        }
        let rhs = y.resize_vertically(200 + excluded.len(), 0.0);
        let expected = a.svd(true, true).solve(&rhs, 1e-14).unwrap();
        // Two routes to the same well-conditioned 5 x 5 problem: rounding only.
        assert!((&solution.dense - expected).amax() < 1e-11);
        // Cholesky's factor against eigenvalues, of a well-conditioned 2 x 2 problem.
        let refit = least_squares(&gram, &solution.support);
        assert!((&solution.refit - refit).amax() < 1e-13);
    }

    #[test]
    fn prop_scaled_result_does_not_depend_on_units_or_amount_of_data() {
        let (_, _, gram) = data();
        let sr3 = Sr3::new(2e-3, 0.5).unwrap();
        let once = sr3.solve(&gram);
        let mut ten = Gram::zeros(5);
        (0..10).for_each(|_| ten.merge(&gram));
        let tenfold = sr3.solve(&ten);
        assert_eq!(once.support, tenfold.support);
        // Ten copies change sums by rounding only.
        assert!((&once.dense - &tenfold.dense).amax() < 1e-11);
        let d = DMatrix::from_diagonal(&DVector::from_vec(vec![1e6, 1e-6, 1.0, 3.0, 100.0]));
        let other = Gram {
            xtx: &d * &gram.xtx * &d,
            xty: &d * &gram.xty,
            ..gram.clone()
        };
        let rescaled = sr3.solve(&other);
        assert_eq!(once.support, rescaled.support);
        // Coefficients rescale with their columns; relative rounding of the Gram entries.
        assert!((&d * &rescaled.dense - &once.dense).amax() < 1e-10);
    }

    #[test]
    fn analytic_threshold_and_objective_of_one_column() {
        // One column of length 1: without the penalty ξ = b. Kept, the objective is λ + 1/2 (c - b²); dropped, the
        // best ξ is b/(1 + 1/ν) and the objective c/2 - b²/2 · ν/(1 + ν). The fixed point keeps the term where
        // |b| > √(2 λ ν), the published threshold.
        let (lambda, nu) = (0.18_f64, 1.0);
        let eta = (2.0 * lambda * nu).sqrt();
        assert!((eta - 0.6).abs() < 1e-15);
        for (b, kept) in [(0.6001, true), (0.5999, false)] {
            let gram = Gram {
                xtx: DMatrix::from_element(1, 1, 1.0),
                xty: DVector::from_element(1, b),
                yty: 1.0,
                rows: 1,
                ..Gram::zeros(1)
            };
            let solution = Sr3::new(lambda, nu)
                .unwrap()
                .scaling(Scaling::None)
                .solve(&gram);
            assert_eq!(solution.support, [kept], "{b}");
            let objective = if kept {
                lambda + 0.5 * (1.0 - b * b)
            } else {
                0.5 - 0.5 * b * b * nu / (1.0 + nu)
            };
            // Rounding of numbers of order one.
            assert!((solution.objective - objective).abs() < 1e-14, "{b}");
        }
    }

    #[test]
    fn prop_settings_out_of_range_are_named() {
        assert!(
            Sr3::new(-1.0, 1.0)
                .unwrap_err()
                .to_string()
                .contains("`lambda`")
        );
        assert!(Sr3::new(1.0, 0.0).unwrap_err().to_string().contains("`nu`"));
        assert!(Sr3::new(f64::NAN, 1.0).is_err());
    }
}
