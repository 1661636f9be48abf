//! Choosing λ and ν of SR3 by cross-validation over groups.
//!
//! Every fold's statistics are the total minus one group's, so the whole grid costs p x p solves and no
//! further pass over the data.

use nalgebra::DVector;

use crate::choose::select::{OneError, mean_and_error, within_one_error};
use crate::error::SindyError;
use crate::solve::sr3::{Problem, Scaling, Solution, Sr3};
use crate::statistics::gram::Gram;

/// The grid that is searched: thresholds η = √(2 λ ν) on scaled coefficients, and ν relative to the
/// scaled Gram diagonal (which is 1).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Thresholds, each at least 0.
    pub thresholds: Vec<f64>,
    /// Relaxations, each above 0.
    pub nus: Vec<f64>,
}

impl Default for Grid {
    /// Thresholds from 0.001 to 1 (a scaled coefficient of 1 explains the whole target alone) in steps
    /// of a quarter decade, and three ν from refitted least squares to cut-off least squares.
    fn default() -> Self {
        Self {
            thresholds: (0..=12)
                .map(|k| 10f64.powf(-3.0 + 0.25 * f64::from(k)))
                .collect(),
            nus: vec![0.1, 1.0, 10.0],
        }
    }
}

impl Grid {
    /// All pairs of λ and ν, for each ν all thresholds: `λ = η²/(2 ν)`.
    ///
    /// # Errors
    /// An empty grid.
    pub fn points(&self) -> Result<Vec<(f64, f64)>, SindyError> {
        if self.thresholds.is_empty() || self.nus.is_empty() {
            return Err(SindyError::setting(
                "grid",
                "at least one threshold and one nu",
                "none",
            ));
        }
        let of_nu = |&nu: &f64| {
            let lambda = move |&eta: &f64| (eta * eta / (2.0 * nu), nu);
            self.thresholds.iter().map(lambda).collect::<Vec<_>>()
        };
        Ok(self.nus.iter().flat_map(of_nu).collect())
    }
}

/// One point of the grid.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Point {
    /// Penalty λ.
    pub lambda: f64,
    /// Relaxation ν.
    pub nu: f64,
    /// Terms that the fit to all data keeps.
    pub terms: usize,
    /// Root mean square error on the groups left out, in the target's unit.
    pub held_out_rmse: f64,
    /// Standard error of the mean over groups of the *squared* error.
    pub mean_square_error_se: f64,
}

/// The chosen fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The chosen point.
    pub point: Point,
    /// The fit at that point to all data.
    pub solution: Solution,
    /// All points, in grid order.
    pub table: Vec<Point>,
    /// Why this point.
    pub reason: String,
}

/// Searches the grid: the fewest terms whose error on left-out groups is within one standard error of
/// the smallest.
///
/// # Errors
/// Fewer than two groups with rows, an empty grid, or values out of range.
pub fn cross_validate(groups: &[Gram], grid: &Grid) -> Result<Choice, SindyError> {
    cross_validate_scaled(groups, grid, Scaling::UnitRms)
}

/// As [`cross_validate`], with another scaling: with [`Scaling::None`] thresholds are in the units of the
/// coefficients, and ν in those of 1/Gram.
///
/// # Errors
/// As [`cross_validate`].
pub fn cross_validate_scaled(
    groups: &[Gram],
    grid: &Grid,
    scaling: Scaling,
) -> Result<Choice, SindyError> {
    let folds: Vec<&Gram> = groups.iter().filter(|g| g.rows > 0).collect();
    if folds.len() < 2 {
        return Err(SindyError::shape(
            "groups to cross-validate over",
            2,
            folds.len(),
        ));
    }
    if grid.thresholds.is_empty() || grid.nus.is_empty() {
        return Err(SindyError::setting(
            "grid",
            "at least one threshold and one nu",
            "none",
        ));
    }
    let total = Gram::total(groups);
    let rests: Vec<Gram> = folds
        .iter()
        .map(|fold| {
            let mut rest = total.clone();
            rest.downdate(fold);
            rest
        })
        .collect();
    let mut whole = Problem::new(&total, scaling);
    let mut parts: Vec<Problem<'_>> = rests.iter().map(|g| Problem::new(g, scaling)).collect();
    let mut fits: Vec<(Point, Solution, Vec<f64>)> = Vec::new();
    for &nu in &grid.nus {
        for &threshold in &grid.thresholds {
            let lambda = threshold * threshold / (2.0 * nu);
            let sr3 = Sr3::new(lambda, nu)?.scaling(scaling);
            let errors: Vec<f64> = folds
                .iter()
                .zip(&mut parts)
                .map(|(fold, rest)| fold.residual_sum(&sr3.solve_again(rest).refit) / fold.weight())
                .collect();
            let solution = sr3.solve_again(&mut whole);
            let (mean, se) = mean_and_error(&errors);
            let point = Point {
                lambda,
                nu,
                terms: solution.support.iter().filter(|s| **s).count(),
                held_out_rmse: mean.sqrt(),
                mean_square_error_se: se,
            };
            fits.push((point, solution, errors));
        }
    }
    let table: Vec<Point> = fits.iter().map(|f| f.0).collect();
    let errors: Vec<Vec<f64>> = fits.iter().map(|f| f.2.clone()).collect();
    let terms: Vec<usize> = table.iter().map(|p| p.terms).collect();
    let OneError { chosen, reason, .. } = within_one_error(&errors, &terms);
    let (point, solution, _) = fits.swap_remove(chosen);
    Ok(Choice {
        point,
        solution,
        table,
        reason,
    })
}

/// The coefficients of a choice: least squares on its support.
impl Choice {
    /// Least squares on the chosen support.
    #[must_use]
    pub fn coefficients(&self) -> &DVector<f64> {
        &self.solution.refit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Library, Samples};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn analytic_true_support_is_chosen_among_distractors() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(11);
        let mut samples = Samples::new(&["x", "u", "y"]);
        for _ in 0..8 {
            let x: Vec<f64> = (0..200).map(|_| rng.random_range(-1.0..1.0)).collect();
            let u: Vec<f64> = (0..200).map(|_| rng.random_range(-1.0..1.0)).collect();
            let y = x
                .iter()
                .zip(&u)
                .map(|(x, u)| 0.7 * x - 0.4 * x * u + rng.random_range(-0.05..0.05))
                .collect();
            samples.push_group(vec![x, u, y]).unwrap();
        }
        let library = Library::parse(&["1", "x", "u", "x^2", "x*u", "u^2", "x^3"]).unwrap();
        let grams = Gram::accumulate(&library, "y", &samples).unwrap();
        let choice = cross_validate(&grams, &Grid::default()).unwrap();
        assert_eq!(
            choice.solution.support,
            [false, true, false, false, true, false, false],
            "{}",
            choice.reason
        );
        // 1600 samples with uniform noise of 0.03 rms on columns of 0.58 and 0.33 rms: standard errors
        // of 1.2e-3 and 2.2e-3; four of them.
        assert!((choice.coefficients()[1] - 0.7).abs() < 5e-3);
        assert!((choice.coefficients()[4] + 0.4).abs() < 9e-3);
    }

    #[test]
    fn prop_a_needless_term_is_dropped_though_it_lowers_the_error_a_little() {
        // The groups' own noise makes some distractor look useful; the rule of one standard error drops it.
        let mut dropped = 0;
        for seed in 0..20 {
            let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
            let mut samples = Samples::new(&["x", "y"]);
            for _ in 0..6 {
                let x: Vec<f64> = (0..40).map(|_| rng.random_range(-1.0..1.0)).collect();
                let y = x.iter().map(|x| x + rng.random_range(-0.3..0.3)).collect();
                samples.push_group(vec![x, y]).unwrap();
            }
            let library = Library::parse(&["x", "x^2", "x^3", "1"]).unwrap();
            let grams = Gram::accumulate(&library, "y", &samples).unwrap();
            let choice = cross_validate(&grams, &Grid::default()).unwrap();
            let best = choice
                .table
                .iter()
                .min_by(|a, b| a.held_out_rmse.total_cmp(&b.held_out_rmse))
                .unwrap();
            assert!(
                choice.point.terms <= best.terms,
                "never more terms than the best point"
            );
            dropped += usize::from(choice.point.terms < best.terms);
        }
        // Where the smallest error has a needless term (about half of the draws) the rule must act.
        assert!(dropped >= 3, "{dropped} of 20");
    }

    #[test]
    fn prop_one_group_is_refused() {
        let err = cross_validate(&[Gram::zeros(2)], &Grid::default()).unwrap_err();
        assert!(err.to_string().contains("groups"));
    }
}
