//! Other terms in place of one: how much worse a model is with one term exchanged.
//!
//! With the matrix of `[X | r]` swept on the support (see [`Search`]), `1/d` the square of what the other terms leave of term `k`, and
//! `a` its coefficient, dropping `k` raises the sum of squares by `a²/d`, and adding `j` then lowers it again:
//!
//! ```text
//! cost = a²/d - (t_jr + t_jk a/d)² / (t_jj + t_jk²/d),        d = -t_kk
//! ```

use nalgebra::{DMatrix, DVector};

use super::select::{DEPENDENT, Search};
use crate::solve::sign::Sign;
use crate::statistics::gram::Gram;

/// Exchanges of a term that are kept, the cheapest: of many a model is hardly one.
const KEPT: usize = 5;

/// One term of the model exchanged for another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// The term, as a candidate.
    pub dropped: usize,
    /// The candidate in its place.
    pub added: usize,
    /// Twice the fall of the log-likelihood, were the residuals independent.
    pub cost: f64,
}

impl Search {
    /// The cheapest exchanges of each term of the support for others of `members`. Their cost is the rise of the sum of squares.
    pub(super) fn exchanges(&self, members: &[usize]) -> Vec<Exchange> {
        let held = members.iter().filter(|&&k| self.support[k]);
        let of = |&k: &usize| {
            let others = members.iter().filter(|&&j| !self.support[j]);
            let mut all: Vec<Exchange> = others.filter_map(|&j| self.exchanged(k, j)).collect();
            all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            all.truncate(KEPT);
            all
        };
        held.flat_map(of).collect()
    }

    /// Term `k` exchanged for `j`; `None` where `j` depends on the other terms, or would break its sign.
    fn exchanged(&self, k: usize, j: usize) -> Option<Exchange> {
        let p = self.length.len();
        let d = -self.t[(k, k)];
        let (a, joint) = (self.scaled(k), self.t[(j, k)]);
        let pivot = self.t[(j, j)] + joint * joint / d;
        let slope = self.t[(j, p)] + joint * a / d;
        let keeps_sign = self.signs.is_empty() || self.signs[j].allows(slope / pivot);
        (pivot > DEPENDENT && keeps_sign).then(|| Exchange {
            dropped: k,
            added: j,
            cost: a * a / d - slope * slope / pivot,
        })
    }
}

/// The exchanges of a least-squares fit. Their cost is the rise of the sum of squares.
pub(crate) fn of_regression(
    gram: &Gram,
    coefficients: &DVector<f64>,
    residual: f64,
    signs: &[Sign],
) -> Vec<Exchange> {
    let xtx: &DMatrix<f64> = &gram.xtx;
    let left = &gram.xty - xtx * coefficients;
    let search = Search::new(xtx, &left, residual, coefficients).with_signs(signs);
    let all: Vec<usize> = (0..coefficients.len()).collect();
    search.exchanges(&all)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn analytic_exchanges_cost_what_the_other_terms_leave() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        let (rows, p) = (60, 6);
        let mut x = DMatrix::from_fn(rows, p, |_, _| rng.random_range(-1.0..1.0));
        // Nearly the first one.
        for i in 0..rows {
            x[(i, 3)] = x[(i, 0)] + 0.1 * x[(i, 3)];
        }
        let y = DVector::from_fn(rows, |i, _| {
            2.0 * x[(i, 0)] - 3.0 * x[(i, 1)] + rng.random_range(-0.5..0.5)
        });
        let left = |terms: &[usize]| {
            let own = x.select_columns(terms);
            let fit = own.clone().svd(true, true).solve(&y, 1e-14).unwrap();
            (&y - own * fit).norm_squared()
        };
        let mut xi = DVector::zeros(p);
        let own = x.select_columns(&[0, 1]);
        let fit = own.svd(true, true).solve(&y, 1e-14).unwrap();
        (xi[0], xi[1]) = (fit[0], fit[1]);
        let gram = Gram {
            xtx: x.transpose() * &x,
            xty: x.transpose() * &y,
            yty: y.norm_squared(),
            rows,
            ..Gram::zeros(p)
        };
        let found = of_regression(&gram, &xi, left(&[0, 1]), &[]);
        assert_eq!(found.len(), 8);
        for e in &found {
            let other = [e.added, if e.dropped == 0 { 1 } else { 0 }];
            let truth = left(&other) - left(&[0, 1]);
            // Rounding of sums of 60 squares.
            assert!((e.cost - truth).abs() < 1e-9, "{e:?}: {truth}");
        }
        assert_eq!((found[0].dropped, found[0].added), (0, 3));
        // Only a positive coefficient would do.
        let mut signs = vec![Sign::Any; p];
        signs[3] = Sign::Negative;
        let signed = of_regression(&gram, &xi, left(&[0, 1]), &signs);
        assert!(signed.iter().all(|e| (e.dropped, e.added) != (0, 3)));
    }
}
