//! The normal equations with columns and target of unit length, and their Cholesky factor.

use nalgebra::{DMatrix, DVector};

use crate::error::SindyError;
use crate::statistics::gram::Gram;
use crate::statistics::gram::check;
use crate::statistics::regression::least_norm;
use crate::statistics::tsqr;

/// A pivot below this share of its (unit) column counts as dependent: the Gram matrix squares the
/// condition, so beyond a condition of `Θ` of 3e6 nothing is left of f64's digits.
pub(crate) const PIVOT: f64 = 1e-13;

/// `G`, `b` and `c` after division by the lengths of the columns and of the target: `G` has a unit
/// diagonal, `b` holds cosines, and residual sums are shares of `yᵀ y`.
pub(crate) struct Normal {
    /// `Θᵀ Θ` over the columns that are not zero throughout, scaled.
    pub(crate) g: DMatrix<f64>,
    /// `Θᵀ y` over the same columns, scaled.
    pub(crate) b: DVector<f64>,
    /// The library's index of each of them.
    pub(crate) terms: Vec<usize>,
    /// Length of each of them over the length of the target: scaled = unscaled x this.
    pub(crate) scale: DVector<f64>,
    /// `yᵀ y`, the unit of residual sums.
    pub(crate) unit: f64,
    /// One over the number of rows, or over the sum of their weights.
    pub(crate) weight: f64,
    /// Residual shares below this are rounding of the statistics.
    pub(crate) floor: f64,
    /// Terms of the library.
    pub(crate) p: usize,
    /// The triangular factor of the same columns and the target, scaled, if there is one.
    root: Option<(DMatrix<f64>, DVector<f64>)>,
}

impl Normal {
    pub(crate) fn new(gram: &Gram) -> Result<Self, SindyError> {
        check(gram)?;
        let p = gram.xty.len();
        let terms: Vec<usize> = (0..p).filter(|&j| gram.xtx[(j, j)] > 0.0).collect();
        let length: Vec<f64> = terms.iter().map(|&j| gram.xtx[(j, j)].sqrt()).collect();
        let k = terms.len();
        let target = if gram.yty > 0.0 { gram.yty.sqrt() } else { 1.0 };
        Ok(Self {
            g: DMatrix::from_fn(k, k, |i, j| {
                gram.xtx[(terms[i], terms[j])] / length[i] / length[j]
            }),
            b: DVector::from_fn(k, |i, _| gram.xty[terms[i]] / length[i] / target),
            scale: DVector::from_fn(k, |i, _| length[i] / target),
            root: gram.triangle.as_ref().map(|triangle| {
                let r = triangle.matrix();
                (
                    DMatrix::from_fn(p + 1, k, |i, j| r[(i, terms[j])] / length[j]),
                    r.column(p) / target,
                )
            }),
            terms,
            unit: if gram.yty > 0.0 { gram.yty } else { 1.0 },
            weight: 1.0 / gram.weight(),
            floor: 16.0 * f64::EPSILON * (p + 1) as f64,
            p,
        })
    }

    /// Adds the smallest ridge that makes every principal part safely positive definite, and returns
    /// it: zero while the condition of the scaled `Θ` is below about 3e6. By interlacing, no part is
    /// worse than the whole.
    pub(crate) fn regularise(&mut self) -> f64 {
        if self.terms.is_empty() {
            return 0.0;
        }
        let eigen = self.g.symmetric_eigenvalues();
        let smallest = eigen.min();
        if smallest > 2.0 * PIVOT {
            return 0.0;
        }
        let ridge = 2.0 * PIVOT - smallest.min(0.0);
        (0..self.terms.len()).for_each(|j| self.g[(j, j)] += ridge);
        ridge
    }

    /// Solves `(G_S + diag(ridge)) ξ = b_S` on the subset `index`, in scaled units; least norm where it
    /// is dependent.
    pub(crate) fn solve(&self, index: &[usize], ridge: impl Fn(usize) -> f64) -> DVector<f64> {
        if let Some((root, target)) = &self.root {
            let columns = root.select_columns(index);
            return solve_with_ridge(&columns, target, |a| ridge(index[a]));
        }
        let entry = |a: usize, c: usize| {
            self.g[(index[a], index[c])] + if a == c { ridge(index[a]) } else { 0.0 }
        };
        let mut factor = Factor::new(index.len());
        for (a, &j) in index.iter().enumerate() {
            if !factor.push(|c| entry(a, c), self.b[j]) {
                let k = index.len();
                let b = DVector::from_fn(k, |i, _| self.b[index[i]]);
                return least_norm(&DMatrix::from_fn(k, k, entry), &b);
            }
        }
        DVector::from_vec(factor.solve())
    }

    /// The support over the whole library of a subset of the columns.
    pub(crate) fn support(&self, index: impl IntoIterator<Item = usize>) -> Vec<bool> {
        let mut support = vec![false; self.p];
        for j in index {
            support[self.terms[j]] = true;
        }
        support
    }
}

/// `min |b - R x|² + Σ ridge_j x_j²` through the rows of R.
pub(crate) fn solve_with_ridge(
    r: &DMatrix<f64>,
    b: &DVector<f64>,
    ridge: impl Fn(usize) -> f64,
) -> DVector<f64> {
    let (n, k) = r.shape();
    let rows = DMatrix::from_fn(n + k, k, |i, j| match i.checked_sub(n) {
        None => r[(i, j)],
        Some(i) if i == j => ridge(j).sqrt(),
        Some(_) => 0.0,
    });
    tsqr::solve(&rows, &b.clone().resize_vertically(n + k, 0.0))
}

/// `G_S = L Lᵀ` grown row by row, with `z = L⁻¹ b_S`.
pub(crate) struct Factor {
    l: Vec<f64>,
    stride: usize,
    z: Vec<f64>,
}

impl Factor {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            l: vec![0.0; capacity * capacity],
            stride: capacity,
            z: Vec::with_capacity(capacity),
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.l[i * self.stride..i * self.stride + i + 1]
    }

    /// Appends a column with products `g(0..=k)` (the last with itself) and `b`; false, and nothing
    /// appended, if it depends on those before.
    pub(crate) fn push(&mut self, g: impl Fn(usize) -> f64, b: f64) -> bool {
        let k = self.z.len();
        for c in 0..k {
            let dot: f64 = (0..c)
                .map(|i| self.l[k * self.stride + i] * self.l[c * self.stride + i])
                .sum();
            self.l[k * self.stride + c] = (g(c) - dot) / self.l[c * self.stride + c];
        }
        let row = &self.l[k * self.stride..k * self.stride + k];
        let diagonal = g(k);
        let pivot = diagonal - row.iter().map(|v| v * v).sum::<f64>();
        if !(pivot > PIVOT * diagonal) {
            return false;
        }
        let root = pivot.sqrt();
        let z = (b - row.iter().zip(&self.z).map(|(a, c)| a * c).sum::<f64>()) / root;
        self.l[k * self.stride + k] = root;
        self.z.push(z);
        true
    }

    /// The part of the target's square that the columns explain.
    pub(crate) fn explained(&self) -> f64 {
        self.z.iter().map(|z| z * z).sum()
    }

    /// The coefficients, `L⁻ᵀ z`.
    pub(crate) fn solve(&self) -> Vec<f64> {
        let mut x = self.z.clone();
        for i in (0..x.len()).rev() {
            let row = self.row(i);
            x[i] /= row[i];
            for c in 0..i {
                x[c] -= row[c] * x[i];
            }
        }
        x
    }

    /// By how much the residual grows when each column is dropped alone: `ξ_j² / (G⁻¹)_jj`.
    pub(crate) fn drop_costs(&self) -> Vec<f64> {
        let k = self.z.len();
        let mut column = vec![0.0; k];
        (0..k)
            .map(|j| {
                // Column j of L⁻¹ by forward substitution.
                let (mut norm, mut x) = (0.0, 0.0);
                for i in j..k {
                    let row = self.row(i);
                    let dot: f64 = (j..i).map(|c| row[c] * column[c]).sum();
                    column[i] = (f64::from(u8::from(i == j)) - dot) / row[i];
                    norm += column[i] * column[i];
                    x += column[i] * self.z[i];
                }
                x * x / norm
            })
            .collect()
    }
}

mod additions;
mod blocked;
pub(crate) use additions::Additions;
pub(crate) use blocked::solve_definite;

#[cfg(test)]
pub(crate) mod tests;
