//! What each further column would add to a subset that grows by one column at a time.

use super::{Normal, PIVOT};

/// The rows that all columns outside of a subset would get in its Cholesky factor. They grow with the subset, so `k`
/// additions among `m` columns cost `m k²/2` products.
pub(crate) struct Additions<'a> {
    normal: &'a Normal,
    /// For each column, its row of the factor as far as the subset goes.
    rows: Vec<Vec<f64>>,
    /// What the subset leaves of each column's square, and of its product with the target.
    left: Vec<f64>,
    product: Vec<f64>,
    index: Vec<usize>,
    explained: f64,
}

impl<'a> Additions<'a> {
    /// To no columns.
    pub(crate) fn new(normal: &'a Normal) -> Self {
        let m = normal.terms.len();
        Self {
            normal,
            rows: vec![Vec::new(); m],
            left: (0..m).map(|j| normal.g[(j, j)]).collect(),
            product: normal.b.as_slice().to_vec(),
            index: Vec::new(),
            explained: 0.0,
        }
    }

    /// To the columns `index`; those that depend on others before them add nothing.
    pub(crate) fn to(normal: &'a Normal, index: &[usize]) -> Self {
        let mut out = Self::new(normal);
        index.iter().for_each(|&j| out.add(j));
        out
    }

    /// The part of the target's square that the subset explains.
    pub(crate) fn explained(&self) -> f64 {
        self.explained
    }

    /// By how much each column outside of the subset would lower the residual; not those that depend on it.
    pub(crate) fn gains(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let outside = (0..self.left.len()).filter(|j| !self.index.contains(j));
        outside.filter_map(|j| {
            let free = self.is_free(j);
            free.then(|| (j, self.product[j] * self.product[j] / self.left[j]))
        })
    }

    fn is_free(&self, j: usize) -> bool {
        self.left[j] > PIVOT * self.normal.g[(j, j)]
    }

    /// Adds column `j`, if it does not depend on the subset.
    pub(crate) fn add(&mut self, j: usize) {
        if !self.is_free(j) {
            return;
        }
        let root = self.left[j].sqrt();
        let z = self.product[j] / root;
        let own = self.rows[j].clone();
        self.index.push(j);
        self.explained += z * z;
        for c in (0..self.left.len()).filter(|c| !self.index.contains(c)) {
            let row = &mut self.rows[c];
            let dot: f64 = row.iter().zip(&own).map(|(a, b)| a * b).sum();
            let entry = (self.normal.g[(c, j)] - dot) / root;
            row.push(entry);
            self.left[c] -= entry * entry;
            self.product[c] -= entry * z;
        }
    }
}
