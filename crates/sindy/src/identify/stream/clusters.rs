//! Statistics by equation and cluster.

use serde::{Deserialize, Serialize};

use crate::statistics::gram::Gram;

/// Statistics by equation and cluster, and the cluster that the next rows go to. Clusters behind the last that has rows
/// need not be there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClusterSums {
    /// Clusters that rows are dealt to in turn.
    pub clusters: usize,
    /// Rows of a turn, at least.
    pub block: usize,
    /// The cluster that is being filled, and rows that it has got in this turn.
    pub at: usize,
    pub filled: usize,
    /// By equation, then cluster.
    pub grams: Vec<Vec<Gram>>,
}

impl ClusterSums {
    /// Of no rows, for libraries of so many terms by equation.
    pub(super) fn new(terms: &[usize], clusters: usize, block: usize) -> Self {
        Self {
            clusters,
            block,
            at: 0,
            filled: 0,
            grams: terms
                .iter()
                .map(|&p| vec![Gram::zeros(p); clusters])
                .collect(),
        }
    }

    /// The cluster of the next `rows` rows.
    pub(super) fn deal(&mut self, rows: usize) -> usize {
        let place = self.at;
        self.filled += rows;
        if self.filled >= self.block {
            self.filled = 0;
            self.at = (self.at + 1) % self.clusters;
        }
        place
    }

    /// Adds the rows of what comes after these. Its clusters follow on from the one that is being filled.
    pub(super) fn append(&mut self, next: &Self) {
        for (own, more) in self.grams.iter_mut().zip(&next.grams) {
            for (j, gram) in more.iter().enumerate() {
                let place = (self.at + j) % self.clusters;
                while own.len() <= place {
                    own.push(Gram::zeros(gram.xty.len()));
                }
                own[place].merge(gram);
            }
        }
        self.at = (self.at + next.at) % self.clusters;
        self.deal(next.filled);
    }

    /// The same without the empty clusters at the end.
    pub(super) fn trimmed(mut self) -> Self {
        for own in &mut self.grams {
            while own.last().is_some_and(|g| g.rows + g.skipped == 0) {
                own.pop();
            }
        }
        self
    }

    /// The statistics with an entry for every cluster.
    pub(super) fn full(mut self, terms: &[usize]) -> Vec<Vec<Gram>> {
        for (own, &p) in self.grams.iter_mut().zip(terms) {
            own.resize(self.clusters, Gram::zeros(p));
        }
        self.grams
    }

    /// Rows (in the weak form: windows) that were used.
    pub(super) fn used(&self) -> usize {
        self.grams
            .first()
            .into_iter()
            .flatten()
            .map(|g| g.rows)
            .sum()
    }

    /// Whether the numbers are those of libraries of so many terms.
    pub(super) fn fits(&self, terms: &[usize], clusters: usize, block: usize) -> bool {
        (self.clusters, self.block) == (clusters, block)
            && self.at < clusters
            && self.filled < block
            && self.grams.len() == terms.len()
            && self
                .grams
                .iter()
                .zip(terms)
                .all(|(own, &p)| own.len() <= clusters && own.iter().all(|g| g.xty.len() == p))
    }
}
