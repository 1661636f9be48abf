//! The problem that SR3 solves on statistics, once for each support.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::{FixedPoint, Scaling, Solution};
use crate::statistics::gram::Gram;
use crate::statistics::normal::{solve_definite, solve_with_ridge};
use crate::statistics::regression::{LastEigenspaces, Refits, least_norm};

/// The residual of a system that counts as solved, as a share of the right side. A dependent system from a Gram matrix has no more
/// than half of the digits.
const RESIDUAL: f64 = 1e-8;

/// Statistics in one scaling, and what has been solved on them so far: a grid of λ and ν meets the same
/// supports again and again.
pub(crate) struct Problem<'g> {
    scaling: Scaling,
    /// In scaled coefficients ξ' = D ξ: G' = D⁻¹ G D⁻¹ / n, with the target's scale inside D.
    pub(crate) g: DMatrix<f64>,
    pub(crate) b: DVector<f64>,
    pub(crate) scale: DVector<f64>,
    /// What sums over rows are multiplied by.
    pub(crate) weight: f64,
    /// The triangular factor of terms and target in the same scaling, where the statistics have one.
    root: Option<(DMatrix<f64>, DVector<f64>)>,
    /// By the bits of ν and the support; all terms together do not depend on ν.
    fixed_points: HashMap<(u64, Vec<bool>), DVector<f64>>,
    refits: Refits<'g>,
}

impl<'g> Problem<'g> {
    pub(crate) fn new(gram: &'g Gram, scaling: Scaling) -> Self {
        Self::sharing(gram, scaling, Arc::default())
    }

    /// The same with what problems of the same terms have computed.
    pub(crate) fn sharing(gram: &'g Gram, scaling: Scaling, shared: Arc<LastEigenspaces>) -> Self {
        let p = gram.xty.len();
        let (scale, weight) = match scaling {
            Scaling::None => (DVector::from_element(p, 1.0), 1.0),
            Scaling::UnitRms => {
                let target = gram.target_rms();
                let rows = if gram.rows > 0 { gram.weight() } else { 1.0 };
                (gram.column_rms() / target, 1.0 / (rows * target.powi(2)))
            }
        };
        let root = gram.triangle.as_ref().map(|triangle| {
            let r = triangle.matrix();
            let column = |i, j| r[(i, j)] * weight.sqrt();
            let theta = DMatrix::from_fn(p + 1, p, |i, j| column(i, j) / scale[j]);
            (theta, DVector::from_fn(p + 1, |i, _| column(i, p)))
        });
        Self {
            root,
            g: DMatrix::from_fn(p, p, |i, j| {
                gram.xtx[(i, j)] * weight / (scale[i] * scale[j])
            }),
            b: DVector::from_fn(p, |i, _| gram.xty[i] * weight / scale[i]),
            scaling,
            scale,
            weight,
            fixed_points: HashMap::new(),
            refits: Refits::new(gram, shared),
        }
    }

    pub(super) fn fixed_point(&mut self, support: &[bool], nu: f64) -> DVector<f64> {
        let whole = support.iter().all(|s| *s);
        let key = (if whole { 0 } else { nu.to_bits() }, support.to_vec());
        if let Some(known) = self.fixed_points.get(&key) {
            return known.clone();
        }
        let own = match &self.root {
            Some((theta, y)) => {
                solve_with_ridge(theta, y, |j| if support[j] { 0.0 } else { 1.0 / nu })
            }
            // Columns of equal length, so that the least norm is that of least squares, which other problems share.
            None if whole && self.scaling == Scaling::UnitRms => {
                self.refits.on(support).component_mul(&self.scale)
            }
            None => self
                .among_dependent(support, nu)
                .unwrap_or_else(|| fixed_point(&self.g, &self.b, support, nu)),
        };
        self.fixed_points.insert(key, own.clone());
        own
    }

    /// The fixed point where all terms are dependent and few of them are excluded, from the eigenspaces that all supports share.
    fn among_dependent(&self, support: &[bool], nu: f64) -> Option<DVector<f64>> {
        if self.scaling == Scaling::None {
            return None;
        }
        let excluded: Vec<usize> = (0..support.len()).filter(|&j| !support[j]).collect();
        let spaces = self.refits.dependent()?;
        // The matrix in this scaling is that of columns of unit length to rounding.
        let own = spaces.with_ridge(&self.b, &excluded, 1.0 / nu)?;
        let mut left = &self.g * &own - spaces.in_range(&self.b);
        excluded.iter().for_each(|&j| left[j] += own[j] / nu);
        (left.amax() <= RESIDUAL * self.b.amax()).then_some(own)
    }

    /// `1/2 |y - Θ ξ|²` in the problem's scaling.
    pub(super) fn misfit(&self, xi: &DVector<f64>) -> f64 {
        let square = self.refits.gram.yty * self.weight;
        0.5 * (square - 2.0 * xi.dot(&self.b) + xi.dot(&(&self.g * xi)))
    }

    /// The solution in the units of the data; `refit` is in these already.
    pub(crate) fn solution(
        &self,
        found: FixedPoint,
        sparse: &DVector<f64>,
        refit: DVector<f64>,
        objective: f64,
    ) -> Solution {
        Solution {
            dense: found.dense.component_div(&self.scale),
            sparse: sparse.component_div(&self.scale),
            refit,
            support: found.support,
            outcome: found.outcome,
            iterations: found.iterations,
            objective,
        }
    }

    /// Least squares on the support, in the units of the data.
    pub(super) fn refit(&mut self, support: &[bool]) -> DVector<f64> {
        self.refits.on(support)
    }
}

/// The limit of the relaxation for a given support: `(G + P_N/ν) ξ = b`, where `P_N` picks the excluded
/// terms.
pub(super) fn fixed_point(
    g: &DMatrix<f64>,
    b: &DVector<f64>,
    support: &[bool],
    nu: f64,
) -> DVector<f64> {
    let mut a = g.clone();
    for (j, keep) in support.iter().enumerate() {
        if !keep {
            a[(j, j)] += 1.0 / nu;
        }
    }
    solve_definite(&a, b).unwrap_or_else(|| least_norm(&a, b))
}
