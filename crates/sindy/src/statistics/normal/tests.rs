//! Tests of the normal equations, and statistics for the tests of solvers.

use super::*;
use rand::{RngExt, SeedableRng};

/// Statistics of `n` random rows whose columns are mixed by `mix` (0: independent), with the
/// coefficients `truth` and uniform noise.
pub(crate) fn random_gram(seed: u64, n: usize, truth: &[f64], mix: f64, noise: f64) -> Gram {
    let (theta, y) = random_rows(seed, n, truth, mix, noise);
    of_rows(&theta, &y)
}

pub(crate) fn random_rows(
    seed: u64,
    n: usize,
    truth: &[f64],
    mix: f64,
    noise: f64,
) -> (DMatrix<f64>, DVector<f64>) {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let p = truth.len();
    let mut theta = DMatrix::from_fn(n, p, |_, _| rng.random_range(-1.0..1.0));
    for i in 0..n {
        for j in 1..p {
            theta[(i, j)] += mix * theta[(i, j - 1)];
        }
    }
    let y = &theta * DVector::from_column_slice(truth)
        + DVector::from_fn(n, |_, _| noise * rng.random_range(-1.0..1.0));
    (theta, y)
}

/// 60 rows of six columns and a target without random numbers, for values from other tools.
pub(crate) fn reference() -> Gram {
    let column = |i: usize, j: usize| {
        let t = 0.1 * i as f64;
        match j {
            0 => 1.0,
            1 => t.sin(),
            2 => (2.0 * t).cos(),
            3 => t.sin() * (2.0 * t).cos(),
            4 => 10.0 * (0.7 * t).sin().powi(2),
            _ => 0.1 * (3.0 * t).cos(),
        }
    };
    let theta = DMatrix::from_fn(60, 6, column);
    let y = DVector::from_fn(60, |i, _| {
        let r = i as f64;
        0.5 + 1.2 * theta[(i, 1)] - 0.08 * theta[(i, 4)]
            + 3.0 * theta[(i, 5)]
            + 0.06 * theta[(i, 2)]
            + 0.02 * (17.0 * r).sin()
            + 0.05 * (5.3 * r * r).cos()
    });
    of_rows(&theta, &y)
}

pub(crate) fn of_rows(theta: &DMatrix<f64>, y: &DVector<f64>) -> Gram {
    Gram {
        xtx: theta.transpose() * theta,
        xty: theta.transpose() * y,
        yty: y.norm_squared(),
        sum_y: y.sum(),
        rows: theta.nrows(),
        ..Gram::zeros(theta.ncols())
    }
}

#[test]
fn analytic_gains_and_drop_costs_are_differences_of_residuals() {
    let gram = random_gram(1, 60, &[1.0, 0.0, -2.0, 0.5, 0.1], 0.9, 0.3);
    let normal = Normal::new(&gram).unwrap();
    let explained = |index: &[usize]| {
        let mut f = Factor::new(6);
        for &j in index {
            assert!(f.push(|c| normal.g[(j, *index.get(c).unwrap())], normal.b[j]));
        }
        f
    };
    let all = [0, 1, 2, 3, 4];
    let costs = explained(&all).drop_costs();
    for j in all {
        let rest: Vec<usize> = all.into_iter().filter(|&i| i != j).collect();
        let mut f = explained(&rest);
        let before = f.explained();
        let at = |c: usize| normal.g[(j, *rest.get(c).unwrap_or(&j))];
        let gain = f.gain(at, normal.b[j]).unwrap();
        // Shares of yᵀy, well conditioned: rounding only.
        assert!((gain - costs[j]).abs() < 1e-13);
        assert!((explained(&all).explained() - before - gain).abs() < 1e-13);
        // The same column twice is refused.
        let twice = all;
        let mut f = explained(&twice);
        assert!(!f.push(|c| normal.g[(j, *twice.get(c).unwrap_or(&j))], normal.b[j]));
    }
}
