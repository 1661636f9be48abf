//! The choice of terms in a linearisation, and what a fit reports of it.

use nalgebra::{DMatrix, DVector};

use super::exchange::Exchange;
use super::search::irrelevant;
use super::select::Search;
use super::{Alternative, Settings, Start};

/// Rounds of the iteration between the penalty of a term and the variance of the residuals, which depend on each other.
const PENALTY_ROUNDS: usize = 4;

/// Normal equations of all candidates around coefficients, in units of the noise.
pub(super) struct Linearised<'a> {
    pub xtx: &'a DMatrix<f64>,
    pub xty: &'a DVector<f64>,
    pub yty: f64,
    /// Values compared.
    pub values: usize,
    /// Free numbers beside the coefficients.
    pub free: f64,
}

/// Terms and coefficients that the linearisation prefers.
pub(super) struct Chosen {
    pub(super) search: Search,
    /// Mean square of the residuals, in units of the noise.
    pub(super) variance: f64,
    /// The penalty of a term, in units of `variance`.
    unit: f64,
    values: usize,
    /// The change of the coefficients.
    pub change: DVector<f64>,
    /// Whether the support stayed, and the largest change in standard errors.
    pub same: bool,
    pub moved: f64,
}

impl Linearised<'_> {
    /// Chooses among all candidates from coefficients on; exactly where the support changes, or `anew`.
    pub(super) fn choose(
        &self,
        xi: &DVector<f64>,
        groups: &[Vec<usize>],
        (settings, start): (&Settings, &Start),
        anew: bool,
    ) -> Chosen {
        let penalty = settings.penalty;
        let values = self.values;
        let support: Vec<bool> = xi.iter().map(|c| *c != 0.0).collect();
        let unit = (values as f64).ln() + 2.0 * (start.chosen_from as f64).ln();
        let mut search = Search::new(self.xtx, self.xty, self.yty, xi).with_signs(&start.signs);
        let mut variance = 0.0;
        // The penalty and the residual depend on each other.
        for _ in 0..PENALTY_ROUNDS {
            let terms = search.support.iter().filter(|s| **s).count() as f64;
            // Less than one only where the noise is at its floor, which is all that is believed.
            variance = (search.residual() / (values as f64 - self.free - terms).max(1.0)).max(1.0);
            search.descend(penalty * unit * variance);
        }
        if anew || search.support != support {
            search.exact(groups, penalty * unit * variance, values);
        }
        for j in irrelevant(
            &search.coefficients(),
            &start.term_rms,
            groups,
            settings.relevance,
        ) {
            search.toggle(j);
        }
        search.keep_signs();
        let change = search.coefficients() - xi;
        let moved = (0..xi.len())
            .filter(|&j| search.support[j])
            .map(|j| change[j].abs() / (search.variance(j) * variance).sqrt())
            .fold(0.0, f64::max);
        Chosen {
            same: search.support == support,
            search,
            variance,
            unit,
            values,
            change,
            moved,
        }
    }
}

impl Chosen {
    /// Makes coefficients outside the support exactly zero, not a rounding error of it.
    pub(super) fn clear(&self, xi: &mut DVector<f64>) {
        for (c, kept) in xi.iter_mut().zip(&self.search.support) {
            *c = if *kept { *c } else { 0.0 };
        }
    }

    /// The penalty of a term.
    pub(super) fn penalty(&self) -> f64 {
        self.unit
    }

    /// Standard errors at coefficients. A last step that was made in part leaves terms that it would have dropped: nothing is
    /// known of them.
    pub(super) fn std_errors(&self, xi: &DVector<f64>) -> Vec<f64> {
        let of = |(j, c): (usize, &f64)| match (self.search.support[j], *c != 0.0) {
            (true, _) => (self.search.variance(j) * self.variance).sqrt(),
            (false, true) => f64::INFINITY,
            (false, false) => 0.0,
        };
        xi.iter().enumerate().map(of).collect()
    }

    /// Covariance of the coefficients that are not zero.
    pub(super) fn covariance(&self, xi: &DVector<f64>) -> DMatrix<f64> {
        let terms: Vec<usize> = (0..xi.len()).filter(|&j| xi[j] != 0.0).collect();
        self.search.covariance(&terms) * self.variance
    }

    /// The evidence for each candidate.
    pub(super) fn evidence(&self) -> Vec<f64> {
        (0..self.change.len())
            .map(|j| self.search.change(j) / self.variance - self.unit)
            .collect()
    }

    /// The cheapest exchanges of each term.
    pub(super) fn exchanges(&self, groups: &[Vec<usize>]) -> Vec<Exchange> {
        let all = groups.iter().flat_map(|own| self.search.exchanges(own));
        let of = |e: Exchange| Exchange {
            cost: e.cost / self.variance,
            ..e
        };
        all.map(of).collect()
    }

    /// The best terms of every number, for each equation.
    pub(super) fn fronts(&self, groups: &[Vec<usize>]) -> Vec<Vec<Alternative>> {
        let front = |members: &Vec<usize>| self.search.front(members, self.values);
        groups.iter().map(front).collect()
    }
}
