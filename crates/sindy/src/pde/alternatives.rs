//! What the data do not tell apart: terms that could be there as well, and other terms that explain as much.

use super::fit::{Estimate, NormalEquations, Search, residual_of};
use crate::statistics::criteria::TWENTY_TO_ONE;
use crate::statistics::gram::Gram;
use crate::statistics::regression::student_95;

/// A candidate that is not in the equation, and what it could be all the same.
pub(super) struct HiddenTerm {
    /// Its place among the candidates.
    pub(super) term: usize,
    /// The most that it could contribute at 95 %, as a share of the left side (root mean squares).
    pub(super) share: f64,
}

impl Search<'_> {
    /// What each candidate outside of `terms` could contribute beside them: the far end of the interval of its coefficient,
    /// times its size.
    pub(super) fn hidden(
        &self,
        terms: &[usize],
        estimate: &Estimate,
        target: usize,
        total: &Gram,
    ) -> Vec<HiddenTerm> {
        let all: Vec<usize> = (0..self.candidates).collect();
        let residual = residual_of(target, terms, &estimate.coefficients);
        let scores = self.score_covariance(&all, &residual);
        let share = |j: usize| {
            let with: Vec<usize> = terms.iter().copied().chain([j]).collect();
            let normal = NormalEquations::new(&with, target, total, &self.noise);
            let own = normal.spread(&scores, &with)[(with.len() - 1, with.len() - 1)];
            let half = student_95(self.degrees(with.len())) * own.max(0.0).sqrt();
            let grown = estimate.misfit.max(1.0);
            if estimate.corrected && !normal.corrected {
                return f64::INFINITY;
            }
            let most = normal.solution[with.len() - 1].abs() + half * grown;
            most / total.yty.sqrt().max(f64::MIN_POSITIVE)
        };
        let others = all.iter().copied().filter(|j| !terms.contains(j));
        let mut out: Vec<HiddenTerm> = others
            .map(|term| HiddenTerm {
                term,
                share: share(term),
            })
            .collect();
        out.sort_by(|a, b| b.share.total_cmp(&a.share));
        out
    }

    /// Terms that are about as likely as `terms`: among `others`, and with one term exchanged.
    pub(super) fn rivals(
        &self,
        terms: &[usize],
        others: Vec<Vec<usize>>,
        target: usize,
        total: &Gram,
    ) -> Vec<Vec<usize>> {
        let score = |terms: &[usize]| {
            let normal = NormalEquations::new(terms, target, total, &self.noise);
            let cost = self
                .residual(terms, &normal.coefficients(), target, total)
                .cost;
            (normal.corrected, cost + self.penalty() * terms.len() as f64)
        };
        let own = score(terms);
        let exchanged = terms.iter().flat_map(|&old| {
            let new = (0..self.candidates).filter(|j| !terms.contains(j));
            new.map(move |new| {
                let mut with: Vec<usize> = terms.to_vec();
                with.retain(|j| *j != old);
                with.push(new);
                with.sort_unstable();
                with
            })
        });
        let mut out: Vec<(f64, Vec<usize>)> = Vec::new();
        for rival in others.into_iter().chain(exchanged) {
            let (corrected, score) = score(&rival);
            let likely = corrected == own.0 && score - own.1 < TWENTY_TO_ONE;
            if likely && !out.iter().any(|(_, known)| *known == rival) {
                out.push((score, rival));
            }
        }
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.into_iter().map(|(_, terms)| terms).collect()
    }
}
