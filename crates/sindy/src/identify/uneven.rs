//! Whether the size of disturbances depends on the state.
//!
//! Squared innovations of unit variance are regressed on states, inputs and their squares. Where their size does not depend on these,
//! n R² is chi-squared with as many degrees of freedom as there are columns.
//!
//! Sources: T. S. Breusch, A. R. Pagan, Econometrica 47 (1979); R. Koenker, Journal of Econometrics 17 (1981), whose form
//! does not need normal errors.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Rows for each column, at least: with fewer, n R² is not chi-squared.
const ROWS: usize = 20;
/// A column of which others leave less than this share depends on them: the square of an input that is 0 or 1.
const DEPENDENT: f64 = 1e-8;

/// By column of `errors`, the probability that squares which depend on no point would follow the points as these do; 1 where there
/// are too few rows. Rows with NaN in a column say nothing of it.
pub(super) fn probabilities(points: &[Vec<f64>], errors: &[Vec<f64>]) -> Vec<f64> {
    let states = errors.first().map_or(0, Vec::len);
    if errors.iter().flatten().any(|e| e.is_nan()) {
        let of = |i: usize| {
            let rows = points.iter().zip(errors).filter(|(_, e)| !e[i].is_nan());
            let (points, own): (Vec<_>, Vec<_>) =
                rows.map(|(point, e)| (point.clone(), vec![e[i]])).unzip();
            probabilities(&points, &own).first().copied().unwrap_or(1.0)
        };
        return (0..states).map(of).collect();
    }
    let Some((columns, degrees)) = design(points) else {
        return vec![1.0; states];
    };
    let n = points.len() as f64;
    let of = |i: usize| {
        let mut squares = DVector::from_fn(points.len(), |k, _| errors[k][i].powi(2));
        squares.add_scalar_mut(-squares.mean());
        // Columns are orthonormal.
        let explained = columns.tr_mul(&squares).norm_squared();
        let statistic = n * explained / squares.norm_squared();
        ChiSquared::new(degrees).map_or(1.0, |chi| chi.sf(statistic))
    };
    (0..states).map(of).collect()
}

/// An orthonormal basis of coordinates and their squares beside the constant, and its size.
fn design(points: &[Vec<f64>]) -> Option<(DMatrix<f64>, f64)> {
    let n = points.len();
    let width = points.first()?.len();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut add = |mut column: DVector<f64>| {
        column.add_scalar_mut(-column.mean());
        let whole = column.norm();
        // Twice: the second time rounding of the first leaves.
        for _ in 0..2 {
            for b in &basis {
                column -= b * b.dot(&column);
            }
        }
        let left = column.norm();
        if left > DEPENDENT.sqrt() * whole && left.is_finite() {
            basis.push(column / left);
        }
    };
    for j in 0..width {
        let mut column = DVector::from_fn(n, |k, _| points[k][j]);
        column.add_scalar_mut(-column.mean());
        let square = column.map(|v| v * v);
        add(column);
        add(square);
    }
    let enough = !basis.is_empty() && n >= ROWS * basis.len();
    enough.then(|| (DMatrix::from_columns(&basis), basis.len() as f64))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// The probability of normal errors of deviation `√(1 + b x²)` at normal points, with an input that is 0 or 1.
    fn p(b: f64, seed: u64) -> f64 {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let points: Vec<Vec<f64>> = (0..500).map(|k| vec![normal(), f64::from(k % 2)]).collect();
        let errors: Vec<Vec<f64>> = points
            .iter()
            .map(|x| vec![(1.0 + b * x[0] * x[0]).sqrt() * normal()])
            .collect();
        probabilities(&points, &errors)[0]
    }

    #[test]
    fn analytic_even_errors_pass_and_uneven_ones_do_not() {
        // Of 1000 uniform numbers 10 ± 3 are at or below 0.01: 20 and more in 3 of 1000 draws.
        let refused = (0..1000).filter(|seed| p(0.0, *seed) <= 0.01).count();
        assert!(refused < 20, "{refused}");
        // Sizes that differ threefold within two standard deviations.
        let found = (0..50).filter(|seed| p(1.0, *seed) <= 0.01).count();
        assert_eq!(found, 50);
    }

    #[test]
    fn analytic_few_rows_and_constant_points_say_nothing() {
        let errors = vec![vec![1.0], vec![2.0]];
        assert_eq!(probabilities(&[vec![1.0], vec![2.0]], &errors), [1.0]);
        let points = vec![vec![1.0]; 100];
        assert_eq!(probabilities(&points, &vec![vec![1.0]; 100]), [1.0]);
    }
}
