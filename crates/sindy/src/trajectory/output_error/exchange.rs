//! Other terms in place of some: how much worse a model is with one term or two exchanged.
//!
//! With the matrix T of `[X | r]` swept on the support (see [`Search`]), dropping the terms K with the coefficients `a` raises the sum
//! of squares, and adding as many terms J then lowers it again:
//!
//! ```text
//! cost = aᵀ D⁻¹ a - sᵀ S⁻¹ s,        D = -T_KK,    s = T_Jr + T_JK D⁻¹ a,    S = T_JJ + T_JK D⁻¹ T_KJ
//! ```

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::select::{DEPENDENT, Search};
use crate::solve::sign::Sign;
use crate::statistics::gram::Gram;

/// Exchanges of a term that are kept, the cheapest: of many a model is hardly one.
const KEPT: usize = 5;
/// Terms of an equation of which pairs are exchanged too, at most. The time grows with the square of both numbers of terms.
const PAIRED: usize = 30;

/// Terms of the model exchanged for as many others, or a term that is added.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    /// The terms, as candidates.
    pub dropped: Vec<usize>,
    /// The candidates in their place.
    pub added: Vec<usize>,
    /// Twice the fall of the log-likelihood, were the residuals independent; with the penalty for a term that is added.
    pub cost: f64,
}

impl Search {
    /// The cheapest exchanges of each term of the support for others of `members`, and of two for two. Their cost is the rise of the
    /// sum of squares.
    pub(super) fn exchanges(&self, members: &[usize]) -> Vec<Exchange> {
        let (held, others): (Vec<usize>, Vec<usize>) =
            members.iter().partition(|&&k| self.support[k]);
        let of = |&k: &usize| cheapest(others.iter().filter_map(|&j| self.exchanged(k, j)));
        let mut out: Vec<Exchange> = held.iter().flat_map(of).collect();
        if held.len() <= PAIRED {
            let pairs = |(n, &k): (usize, &usize)| {
                let after = held[n + 1..].iter();
                let of = |&l: &usize| cheapest(self.exchanged_pairs([k, l], &others).into_iter());
                after.flat_map(of).collect::<Vec<Exchange>>()
            };
            let pairs = held.iter().enumerate().flat_map(pairs);
            out.extend(cheapest(pairs));
        }
        out
    }

    /// Term `k` exchanged for `j`; `None` where one depends on the other terms, or `j` would break its sign.
    fn exchanged(&self, k: usize, j: usize) -> Option<Exchange> {
        let p = self.length.len();
        let d = -self.t[(k, k)];
        let (a, joint) = (self.scaled(k), self.t[(j, k)]);
        let pivot = self.t[(j, j)] + joint * joint / d;
        let slope = self.t[(j, p)] + joint * a / d;
        (self.is_known(k) && pivot > DEPENDENT && self.allows(j, slope / pivot)).then(|| Exchange {
            dropped: vec![k],
            added: vec![j],
            cost: a * a / d - slope * slope / pivot,
        })
    }

    /// Two terms exchanged for two of `others`, where that costs less than each exchange of one of them for one of these.
    fn exchanged_pairs(&self, dropped: [usize; 2], others: &[usize]) -> Vec<Exchange> {
        let p = self.length.len();
        let [k, l] = dropped;
        let d = -Matrix2::from_fn(|i, j| self.t[(dropped[i], dropped[j])]);
        let Some(inverse) = d
            .try_inverse()
            .filter(|_| self.is_known(k) && self.is_known(l))
        else {
            return Vec::new();
        };
        let a = Vector2::new(self.scaled(k), self.scaled(l));
        let cost = a.dot(&(inverse * a));
        struct Candidate {
            term: usize,
            /// What it has in common with the two terms that are dropped.
            joint: Vector2<f64>,
            pivot: f64,
            slope: f64,
            /// The lesser cost of it in place of one of them.
            alone: f64,
        }
        let alone = |j: usize| {
            let costs = dropped.map(|k| self.exchanged(k, j).map_or(f64::INFINITY, |e| e.cost));
            costs[0].min(costs[1])
        };
        let candidates: Vec<Candidate> = others
            .iter()
            .map(|&j| {
                let joint = Vector2::new(self.t[(j, k)], self.t[(j, l)]);
                let weighted = inverse * joint;
                Candidate {
                    term: j,
                    joint: weighted,
                    pivot: self.t[(j, j)] + joint.dot(&weighted),
                    slope: self.t[(j, p)] + weighted.dot(&a),
                    alone: alone(j),
                }
            })
            .filter(|c| c.pivot > DEPENDENT)
            .collect();
        let mut out = Vec::new();
        for (n, i) in candidates.iter().enumerate() {
            for j in &candidates[n + 1..] {
                let joint = self.t[(i.term, j.term)]
                    + self.t[(i.term, k)] * j.joint[0]
                    + self.t[(i.term, l)] * j.joint[1];
                let determinant = i.pivot * j.pivot - joint * joint;
                if determinant <= DEPENDENT * i.pivot * j.pivot {
                    continue;
                }
                let own = (i.slope * j.pivot - j.slope * joint) / determinant;
                let other = (j.slope * i.pivot - i.slope * joint) / determinant;
                let cost = cost - i.slope * own - j.slope * other;
                let signs = self.allows(i.term, own) && self.allows(j.term, other);
                if signs && cost < i.alone.min(j.alone) {
                    out.push(Exchange {
                        dropped: dropped.to_vec(),
                        added: vec![i.term, j.term],
                        cost,
                    });
                }
            }
        }
        out
    }

    /// Whether term `k` of the support is independent of the others there: where it is not, its coefficient is rounding, and what
    /// dropping it costs too.
    fn is_known(&self, k: usize) -> bool {
        let share = -1.0 / self.t[(k, k)];
        share > DEPENDENT
    }

    fn allows(&self, j: usize, coefficient: f64) -> bool {
        self.signs.is_empty() || self.signs[j].allows(coefficient)
    }
}

fn cheapest(all: impl Iterator<Item = Exchange>) -> Vec<Exchange> {
    let mut all: Vec<Exchange> = all.collect();
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    all.truncate(KEPT);
    all
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
        assert_eq!(found.iter().filter(|e| e.dropped.len() == 1).count(), 8);
        for e in &found {
            let held = [0, 1].into_iter().filter(|k| !e.dropped.contains(k));
            let other: Vec<usize> = held.chain(e.added.iter().copied()).collect();
            assert_eq!(other.len(), 2, "{e:?}");
            let truth = left(&other) - left(&[0, 1]);
            // Rounding of sums of 60 squares.
            assert!((e.cost - truth).abs() < 1e-9, "{e:?}: {truth}");
        }
        assert_eq!(
            (&found[0].dropped[..], &found[0].added[..]),
            (&[0][..], &[3][..])
        );
        // Only a positive coefficient would do.
        let mut signs = vec![Sign::Any; p];
        signs[3] = Sign::Negative;
        let signed = of_regression(&gram, &xi, left(&[0, 1]), &signs);
        assert!(signed.iter().all(|e| !e.added.contains(&3)));
    }

    #[test]
    fn analytic_two_terms_that_only_together_stand_for_two() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
        let (rows, p) = (200, 6);
        let mut x = DMatrix::from_fn(rows, p, |_, _| rng.random_range(-1.0..1.0));
        // Term 3 less term 4 is nearly what is looked for. With one of them alone, term 4 has no place.
        for i in 0..rows {
            let whole = 2.0 * x[(i, 0)] - 3.0 * x[(i, 1)];
            x[(i, 3)] = whole + 5.0 * x[(i, 4)] + 0.02 * x[(i, 3)];
        }
        let y = DVector::from_fn(rows, |i, _| {
            2.0 * x[(i, 0)] - 3.0 * x[(i, 1)] + rng.random_range(-0.5..0.5)
        });
        let mut xi = DVector::zeros(p);
        let own = x.select_columns(&[0, 1]);
        let fit = own.clone().svd(true, true).solve(&y, 1e-14).unwrap();
        (xi[0], xi[1]) = (fit[0], fit[1]);
        let residual = (&y - own * fit).norm_squared();
        let gram = Gram {
            xtx: x.transpose() * &x,
            xty: x.transpose() * &y,
            yty: y.norm_squared(),
            rows,
            ..Gram::zeros(p)
        };
        let found = of_regression(&gram, &xi, residual, &[]);
        let likeliest = found
            .iter()
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .unwrap();
        assert_eq!(likeliest.added, [3, 4]);
        // Twice the log-likelihood falls by a few at most, in units of the noise's variance, 1/12; one term alone costs hundreds.
        assert!(likeliest.cost.abs() < 6.0 / 12.0, "{likeliest:?}");
        let single = found.iter().filter(|e| e.dropped.len() == 1);
        assert!(single.into_iter().all(|e| e.cost > 100.0 / 12.0));
    }

    #[test]
    fn prop_terms_that_depend_on_others_take_no_part() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
        let (rows, p) = (100, 5);
        let mut x = DMatrix::from_fn(rows, p, |_, _| rng.random_range(-1.0..1.0));
        // Each of the first three columns has a part of its own when it comes. With the third, the first two have 1e-10 left.
        for i in 0..rows {
            let (a, u, w) = (x[(i, 0)], x[(i, 1)], x[(i, 2)]);
            x[(i, 1)] = a + 1e-4 * u;
            x[(i, 2)] = u + 0.1 * w;
        }
        let y = DVector::from_fn(rows, |i, _| x[(i, 2)] + rng.random_range(-0.5..0.5));
        let xi = DVector::from_vec(vec![1.0, -1.0, 1.0, 0.0, 0.0]);
        let gram = Gram {
            xtx: x.transpose() * &x,
            xty: x.transpose() * &y,
            yty: y.norm_squared(),
            rows,
            ..Gram::zeros(p)
        };
        let residual = (&y - &x * &xi).norm_squared();
        let found = of_regression(&gram, &xi, residual, &[]);
        assert!(!found.is_empty());
        assert!(found.iter().all(|e| e.dropped == [2]), "{found:?}");
    }
}
