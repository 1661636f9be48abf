//! A local search for the best support on normal equations: terms are added, dropped and exchanged while
//! the penalised sum of squares falls.
//!
//! The state of the search is the matrix of `[X | y]` *swept* on the support: one sweep adds or drops a
//! term, and every single addition and removal is then read off its diagonal.
//!
//! Source: J. H. Goodnight, "A tutorial on the SWEEP operator", The American Statistician 33 (1979).

use nalgebra::{DMatrix, DVector};

use super::Alternative;
use crate::solve::exact::{BestSubset, BestSubsets, Subset};
use crate::solve::outcome::Outcome;
use crate::solve::sign::{Sign, broken, is_constrained};
use crate::statistics::gram::Gram;

/// A term of whose column the support leaves less than this share counts as dependent on it: sweeping squares the
/// condition, and seven of sixteen digits are left.
pub(super) const DEPENDENT: f64 = 1e-9;
/// Nodes of a branch and bound, at most: a few milliseconds. A search that ends there is reported as not proven.
const NODES: u64 = 4_000;
/// Number of terms of an equation that the search branches on: those that lower the squares most, with the kept terms and
/// without them. At worst the time doubles with each.
const BRANCHED: usize = 16;
/// Exchanges that are tried, most promising first; more cost time in proportion.
const SWAPS: usize = 20;
/// Share of a term's penalty by which a change has to lower the score: less is rounding, and could go in circles.
const LITTLE: f64 = 0.01;
/// Changes of the support for each candidate, at most: each lowers the score, and far fewer are made.
const CHANGES: usize = 8;
/// Relative rounding of residual sums that are compared.
const ROUNDING: f64 = 1e-9;

/// The swept matrix of `[X | r]`, columns of unit length, where `r` is the residual of the coefficients `reference`.
///
/// Working on the residual, rather than on `y = r + X ξ`, keeps the digits: `r` is noise, `y` may be a million
/// times larger.
#[derive(Clone)]
pub(super) struct Search {
    pub(super) t: DMatrix<f64>,
    pub(super) length: Vec<f64>,
    /// Coefficients that `r` was taken at, times `length`; zero outside the support.
    reference: Vec<f64>,
    pub support: Vec<bool>,
    /// Signs of the coefficients; empty where none is given.
    pub(super) signs: Vec<Sign>,
}

impl Search {
    /// From `XᵀX`, `Xᵀr`, `rᵀr` at the coefficients `xi`, whose terms that are not zero are the support.
    pub(super) fn new(xtx: &DMatrix<f64>, xtr: &DVector<f64>, rtr: f64, xi: &DVector<f64>) -> Self {
        let p = xtr.len();
        let length: Vec<f64> = (0..p)
            .map(|j| {
                let square = xtx[(j, j)];
                if square > 0.0 { square.sqrt() } else { 1.0 }
            })
            .collect();
        let t = DMatrix::from_fn(p + 1, p + 1, |i, j| match (i < p, j < p) {
            (true, true) => xtx[(i, j)] / length[i] / length[j],
            (true, false) => xtr[i] / length[i],
            (false, true) => xtr[j] / length[j],
            (false, false) => rtr,
        });
        let mut search = Self {
            t,
            reference: (0..p).map(|j| xi[j] * length[j]).collect(),
            length,
            support: vec![false; p],
            signs: Vec::new(),
        };
        for j in (0..p).filter(|&j| xi[j] != 0.0) {
            if search.t[(j, j)] > DEPENDENT {
                search.toggle(j);
            } else {
                search.release(j);
            }
        }
        search
    }

    /// The same with signs that coefficients keep from here on; terms that break theirs are dropped.
    pub(super) fn with_signs(mut self, signs: &[Sign]) -> Self {
        if is_constrained(signs) {
            self.signs = signs.to_vec();
            self.keep_signs();
        }
        self
    }

    /// Drops terms that break their sign, one by one, the largest first.
    pub(super) fn keep_signs(&mut self) {
        while let Some(worst) = self.broken() {
            self.toggle(worst);
        }
    }

    /// The largest term that breaks its sign.
    fn broken(&self) -> Option<usize> {
        if self.signs.is_empty() {
            return None;
        }
        let now = self.coefficients();
        let size = |j: &usize| self.scaled(*j).abs();
        broken(&self.signs, now.as_slice()).max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Whether all signs are kept after term `j` is added or dropped, if they are now.
    pub(super) fn keeps_signs(&self, j: usize) -> bool {
        if self.signs.is_empty() {
            return true;
        }
        let factor = self.scaled(j) / self.t[(j, j)];
        let after = |i: usize| self.scaled(i) - self.t[(i, j)] * factor;
        let others = (0..self.support.len()).filter(|&i| i != j && self.support[i]);
        (self.support[j] || self.signs[j].allows(factor))
            && others.into_iter().all(|i| self.signs[i].allows(after(i)))
    }

    /// Takes the reference of a term that is not in the support away from `r`.
    fn release(&mut self, j: usize) {
        let p = self.length.len();
        let by = self.reference[j];
        if by == 0.0 {
            return;
        }
        let (at, own) = (self.t[(j, p)], self.t[(j, j)]);
        for i in 0..p {
            let shift = by * self.t[(i, j)];
            self.t[(i, p)] += shift;
            self.t[(p, i)] += shift;
        }
        self.t[(p, p)] += by * (2.0 * at + by * own);
        self.reference[j] = 0.0;
    }

    /// The scaled coefficient of a term of the support.
    pub(super) fn scaled(&self, j: usize) -> f64 {
        self.reference[j] + self.t[(j, self.length.len())]
    }

    /// Sum of squares that the support leaves.
    pub(super) fn residual(&self) -> f64 {
        let p = self.length.len();
        self.t[(p, p)].max(0.0)
    }

    /// Adds or drops term `k`.
    pub(super) fn toggle(&mut self, k: usize) {
        let size = self.t.nrows();
        let adding = !self.support[k];
        let pivot = self.t[(k, k)];
        let column: Vec<f64> = self.t.column(k).iter().copied().collect();
        for j in (0..size).filter(|&j| j != k) {
            let factor = column[j] / pivot;
            if factor != 0.0 {
                for i in 0..size {
                    if i != k {
                        self.t[(i, j)] -= column[i] * factor;
                    }
                }
            }
        }
        let sign = if adding { 1.0 } else { -1.0 };
        for i in 0..size {
            self.t[(i, k)] = sign * column[i] / pivot;
            self.t[(k, i)] = sign * column[i] / pivot;
        }
        self.t[(k, k)] = -1.0 / pivot;
        self.support[k] = adding;
        if !adding {
            self.release(k);
        }
    }

    /// The fall of the sum of squares when term `j` is added, or its rise when it is dropped.
    pub(super) fn change(&self, j: usize) -> f64 {
        let p = self.length.len();
        let pivot = self.t[(j, j)];
        let y = self.t[(j, p)];
        match self.support[j] {
            true => self.scaled(j).powi(2) / -pivot,
            false if pivot > DEPENDENT => y * y / pivot,
            false => 0.0,
        }
    }

    /// The term that is cheapest to drop, among those that `may` be.
    pub(super) fn cheapest(&self, may: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        (0..self.support.len())
            .filter(|&j| self.support[j] && may(j))
            .map(|j| (j, self.change(j)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The term that gains most when added.
    pub(super) fn dearest(&self, may: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        (0..self.support.len())
            .filter(|&j| !self.support[j] && may(j))
            .map(|j| (j, self.change(j)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Adds, drops and exchanges until nothing lowers `residual + penalty x terms`. Ends: every move
    /// lowers it.
    pub(super) fn descend(&mut self, penalty: f64) {
        for _ in 0..CHANGES * self.support.len() {
            let may = |j| self.keeps_signs(j);
            let (add, drop) = (self.dearest(may), self.cheapest(may));
            if let Some((j, cost)) = drop
                && cost < penalty
            {
                self.toggle(j);
                continue;
            }
            if let Some((j, gain)) = add
                && gain > penalty
            {
                self.toggle(j);
                continue;
            }
            if !self.exchange(penalty) {
                return;
            }
        }
    }

    /// One exchange that lowers the sum of squares by more than a little, for one of the terms that gain
    /// most; false if there is none.
    fn exchange(&mut self, penalty: f64) -> bool {
        let little = LITTLE * penalty;
        let outside = |j: &usize| !self.support[*j] && self.change(*j) > little;
        for j in self.most(SWAPS, (0..self.support.len()).filter(outside)) {
            let gain = self.change(j);
            self.toggle(j);
            if let Some((k, cost)) = self.cheapest(|k| k != j && self.keeps_signs(k))
                && gain - cost > little
            {
                self.toggle(k);
                return true;
            }
            self.toggle(j);
        }
        false
    }

    /// Of `terms`, the given number that change the sum of squares most, most first.
    fn most(&self, number: usize, terms: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut terms: Vec<usize> = terms.collect();
        terms.sort_by(|&a, &b| self.change(b).total_cmp(&self.change(a)));
        terms.truncate(number);
        terms
    }

    /// For each of `equations` (the candidates of one equation) in turn: the best subset of it beside
    /// what the others hold, by branch and bound.
    pub(super) fn exact(&mut self, equations: &[Vec<usize>], penalty: f64, values: usize) {
        for members in equations {
            let score =
                |s: &Self| s.residual() + penalty * s.support.iter().filter(|s| **s).count() as f64;
            let Some(chosen) = self.best_of(members, penalty, values) else {
                continue;
            };
            let trial = self.at(members, &chosen);
            // A search that was cut short may have found less than there was.
            let better = score(&trial) < score(self) - LITTLE * penalty;
            if better && trial.broken().is_none() {
                *self = trial;
            }
        }
    }

    fn best_of(&self, members: &[usize], penalty: f64, values: usize) -> Option<Vec<usize>> {
        let (found, free, _) = self.subsets(members, 1, values)?;
        let best = found.sizes.into_iter().min_by(|a, b| {
            let of = |s: &Subset| s.fit.residual_sum + penalty * s.fit.terms() as f64;
            of(a).total_cmp(&of(b))
        })?;
        Some(kept(&best, &free))
    }

    /// The best terms of every number among `members`, up to three more than are kept, beside what other
    /// equations hold.
    pub(super) fn front(&self, members: &[usize], values: usize) -> Vec<Alternative> {
        let Some((found, free, screened)) = self.subsets(members, 3, values) else {
            return Vec::new();
        };
        let mut least = f64::INFINITY;
        found
            .sizes
            .iter()
            .map(|s| {
                let support = kept(s, &free);
                let left = self.at(members, &support).residual();
                // More terms never leave more: where they seem to, the search ran out of digits.
                let sound = left <= least * (1.0 + ROUNDING);
                least = least.min(left);
                Alternative {
                    error: (left / values as f64).sqrt(),
                    proven: sound && s.fit.outcome == Outcome::Optimal && !screened,
                    support,
                }
            })
            .collect()
    }

    /// The search with these terms of an equation, reached by single steps from where it stands, so that no
    /// digits are lost on the way over the empty set.
    pub(super) fn at(&self, members: &[usize], support: &[usize]) -> Self {
        let mut trial = self.clone();
        for &j in members {
            if support.contains(&j) && !trial.support[j] {
                trial.toggle(j);
            }
        }
        for &j in members {
            if !support.contains(&j) && trial.support[j] {
                trial.toggle(j);
            }
        }
        trial
    }

    /// Branch and bound over the terms of `members`, up to `more` than are kept of them now.
    fn subsets(
        &self,
        members: &[usize],
        more: usize,
        values: usize,
    ) -> Option<(BestSubsets, Vec<usize>, bool)> {
        if members.is_empty() {
            return None;
        }
        let held = members.iter().filter(|&&j| self.support[j]).count();
        let (gram, free, screened) = self.beside(members, values);
        let signs: Vec<Sign> = free
            .iter()
            .filter_map(|&j| self.signs.get(j).copied())
            .collect();
        let found = BestSubset::new()
            .max_size(held + more)
            .node_limit(NODES)
            .solve_signed(&gram, &signs)
            .ok()?;
        Some((found, free, screened))
    }

    /// Normal equations of the most promising of `members`, in columns of unit length, beside what the support holds of others; which
    /// members these are, and whether others were left out.
    pub(super) fn beside(&self, members: &[usize], values: usize) -> (Gram, Vec<usize>, bool) {
        let p = self.length.len();
        let mut bare = self.clone();
        let held: Vec<usize> = members
            .iter()
            .copied()
            .filter(|&j| self.support[j])
            .collect();
        held.iter().for_each(|&j| bare.toggle(j));
        // Those that are kept, those that gain most beside them, and those that gain most without them.
        let eligible = |j: &usize| bare.t[(*j, *j)] > DEPENDENT;
        let mut free: Vec<usize> = held.iter().copied().filter(eligible).collect();
        let total = members.iter().copied().filter(eligible).count();
        for by in [self, &bare] {
            for j in by.most(BRANCHED, members.iter().copied().filter(eligible)) {
                if !free.contains(&j) {
                    free.push(j);
                }
            }
        }
        let screened = free.len() < total;
        free.sort_unstable();
        let gram = Gram {
            xtx: DMatrix::from_fn(free.len(), free.len(), |a, b| bare.t[(free[a], free[b])]),
            xty: DVector::from_fn(free.len(), |a, _| bare.t[(free[a], p)]),
            yty: bare.residual(),
            rows: values,
            ..Gram::zeros(0)
        };
        (gram, free, screened)
    }

    /// The coefficients on the support, zero elsewhere.
    pub(super) fn coefficients(&self) -> DVector<f64> {
        let p = self.length.len();
        DVector::from_fn(p, |j, _| match self.support[j] {
            true => self.scaled(j) / self.length[j],
            false => 0.0,
        })
    }

    /// `(X_Sᵀ X_S)⁻¹` entry of term `j` of the support.
    pub(super) fn variance(&self, j: usize) -> f64 {
        -self.t[(j, j)] / self.length[j].powi(2)
    }

    /// `(X_Sᵀ X_S)⁻¹` over some terms, infinite where one is not in the support.
    pub(super) fn covariance(&self, terms: &[usize]) -> DMatrix<f64> {
        let k = terms.len();
        DMatrix::from_fn(k, k, |a, b| {
            let (i, j) = (terms[a], terms[b]);
            match self.support[i] && self.support[j] {
                true => -self.t[(i, j)] / self.length[i] / self.length[j],
                false => f64::INFINITY,
            }
        })
    }
}

fn kept(subset: &Subset, free: &[usize]) -> Vec<usize> {
    let pairs = free.iter().zip(&subset.fit.support);
    pairs.filter(|(_, s)| **s).map(|(j, _)| *j).collect()
}
