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
fn analytic_blocks_solve_what_they_were_made_of() {
    // Around whole blocks, and a block with one column.
    for p in [1, 31, 32, 33, 64, 97] {
        let truth: Vec<f64> = (0..p).map(|j| (j as f64).cos()).collect();
        let (theta, _) = random_rows(4, 4 * p, &truth, 0.3, 0.0);
        let mut a = theta.transpose() * &theta;
        let x = DVector::from_vec(truth);
        let b = &a * &x;
        // Above the diagonal nothing is read.
        for (i, j) in (0..p).flat_map(|j| (0..j).map(move |i| (i, j))) {
            a[(i, j)] = f64::NAN;
        }
        let found = solve_definite(&a, &b).unwrap();
        // Rounding, times a condition of about ten squared.
        assert!((found - x).amax() < 1e-11, "{p}");
        // The same column twice.
        if p > 1 {
            for i in 0..p {
                let own = if i == p - 1 { a[(0, 0)] } else { a[(i, 0)] };
                a[(p - 1, i)] = own;
            }
            assert_eq!(solve_definite(&a, &b), None, "{p}");
        }
    }
}

#[test]
fn prop_a_column_that_depends_on_the_subset_adds_nothing() {
    let (theta, y) = random_rows(3, 30, &[1.0, -1.0, 0.5], 0.2, 0.1);
    let twice = DMatrix::from_fn(30, 6, |i, j| theta[(i, j % 3)]);
    let normal = Normal::new(&of_rows(&twice, &y)).unwrap();
    let mut additions = Additions::to(&normal, &[0, 1]);
    let free = |a: &Additions<'_>| a.gains().map(|(j, _)| j).collect::<Vec<_>>();
    assert_eq!(free(&additions), [2, 5]);
    let explained = additions.explained();
    additions.add(3);
    assert_eq!(additions.explained(), explained);
    additions.add(2);
    assert!(free(&additions).is_empty());
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
        let mut additions = Additions::to(&normal, &rest);
        let before = explained(&rest).explained();
        let gains: Vec<(usize, f64)> = additions.gains().collect();
        let [(column, gain)] = gains[..] else {
            panic!("{gains:?}");
        };
        assert_eq!(column, j);
        // Shares of yᵀy, well conditioned: rounding only.
        assert!((additions.explained() - before).abs() < 1e-13);
        assert!((gain - costs[j]).abs() < 1e-13);
        assert!((explained(&all).explained() - before - gain).abs() < 1e-13);
        additions.add(j);
        assert!((additions.explained() - before - gain).abs() < 1e-13);
        assert_eq!(additions.gains().count(), 0);
        // The same column twice is refused.
        let twice = all;
        let mut f = explained(&twice);
        assert!(!f.push(|c| normal.g[(j, *twice.get(c).unwrap_or(&j))], normal.b[j]));
    }
}
