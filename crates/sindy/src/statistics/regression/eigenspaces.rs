//! Dependent systems that differ in a ridge on a few of their unknowns, from one eigendecomposition.
//!
//! `G = V Λ Vᵀ` with `G⁺` its pseudo-inverse and `Π` the projection on its null space. With a ridge of ρ on the unknowns N, the
//! least-norm solution of `(G + ρ P_N) x = b` for a `b` in the range of G is
//!
//! ```text
//! x = G⁺ b - G⁺_{:N} u - Π_{:N} (Π_NN)⁺ h,    h = (G⁺ b)_N - (G⁺_NN + I/ρ) u
//! ```
//!
//! where `u = ρ x_N` lies in the null space of `Π_NN` and leaves no `h` there. A null vector of G that moves an unknown of N takes
//! it to zero at no cost; only where none can does the ridge weigh anything.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{DMatrix, DVector};

use super::{RANK_TOLERANCE, is_counted};

/// With a ridge on more than one unknown of so many, a system of its own is faster.
const FEW: usize = 4;

/// A symmetric positive semi-definite matrix by its eigenvectors. Its pseudo-inverse is never formed: in that, the largest entries
/// would round the others away.
pub(crate) struct Eigenspaces {
    matrix: DMatrix<f64>,
    /// Eigenvectors and eigenvalues that count.
    range: DMatrix<f64>,
    values: DVector<f64>,
    /// Eigenvectors of those that are rounding beside the largest.
    null: DMatrix<f64>,
}

impl Eigenspaces {
    pub(super) fn of(matrix: DMatrix<f64>) -> Self {
        let eigen = matrix.clone().symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let (counted, rest): (Vec<usize>, Vec<usize>) =
            (0..matrix.nrows()).partition(|&k| is_counted(eigen.eigenvalues[k], largest));
        Self {
            matrix,
            range: eigen.eigenvectors.select_columns(&counted),
            values: eigen.eigenvalues.select_rows(&counted),
            null: eigen.eigenvectors.select_columns(&rest),
        }
    }

    /// The least-norm solution of `G x = b`.
    pub(crate) fn least_norm(&self, b: &DVector<f64>) -> DVector<f64> {
        &self.range * self.range.tr_mul(b).component_div(&self.values)
    }

    /// The part of `b` in the range of G. Eigenvalues that are rounding beside the largest leave a part outside of it.
    pub(crate) fn in_range(&self, b: &DVector<f64>) -> DVector<f64> {
        b - &self.null * self.null.tr_mul(b)
    }

    /// The least-norm solution of `(G + ridge P_N) x = b`, P_N picking the unknowns `on`, for the part of `b` in the range of G. `None`
    /// where those are so many that the system is better solved for itself.
    pub(crate) fn with_ridge(
        &self,
        b: &DVector<f64>,
        on: &[usize],
        ridge: f64,
    ) -> Option<DVector<f64>> {
        if on.len() * FEW > b.len() || on.len() > self.null.ncols() {
            return None;
        }
        let mut x = self.least_norm(b);
        if on.is_empty() {
            return Some(x);
        }
        let null = self.null.select_rows(on);
        let mut h = x.select_rows(on);
        let own = (&null * null.transpose()).symmetric_eigen();
        // A null vector of G counts with its share in N, as an eigenvector of the whole system would.
        let largest = self.values.iter().copied().fold(0.0, f64::max);
        let least = (RANK_TOLERANCE * largest / ridge).max(f64::EPSILON * b.len() as f64);
        let (moved, stuck): (Vec<usize>, Vec<usize>) =
            (0..on.len()).partition(|&k| own.eigenvalues[k] > least);
        if !stuck.is_empty() {
            let stuck = own.eigenvectors.select_columns(&stuck);
            let range = self.range.select_rows(on);
            let mut weighted = range.transpose();
            weighted
                .column_iter_mut()
                .for_each(|mut column| column.component_div_assign(&self.values));
            let mut k = range * &weighted;
            (0..on.len()).for_each(|i| k[(i, i)] += 1.0 / ridge);
            let reduced = stuck.tr_mul(&(&k * &stuck)).cholesky()?;
            let u = &stuck * reduced.solve(&stuck.tr_mul(&h));
            h -= &k * &u;
            x -= &self.range * (weighted * u);
        }
        let moved_by = own.eigenvectors.select_columns(&moved);
        let values = own.eigenvalues.select_rows(&moved);
        let along = moved_by.tr_mul(&h).component_div(&values);
        x -= &self.null * null.tr_mul(&(moved_by * along));
        Some(x)
    }
}

/// The eigenspaces that were computed last. The equations of a system have one matrix and differ in their targets.
#[derive(Default)]
pub(crate) struct LastEigenspaces(Mutex<Option<Arc<Eigenspaces>>>);

impl LastEigenspaces {
    pub(super) fn of(&self, matrix: DMatrix<f64>) -> Arc<Eigenspaces> {
        let last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last.clone().filter(|known| known.matrix == matrix);
        // Unlocked: threads with other matrices do not wait for this one.
        drop(last);
        known.unwrap_or_else(|| {
            let own = Arc::new(Eigenspaces::of(matrix));
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(own.clone());
            own
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::least_norm::least_norm;
    use super::*;

    proptest! {
        #[test]
        fn analytic_a_ridge_on_few_of_dependent_unknowns(
            n in 8usize..40, nullity in 1usize..8, free in 0usize..3, on in 0usize..8,
            decade in -3..4, seed in 0u64..1000,
        ) {
            // Unknowns before `free` have rows of their own, so that no null vector moves them.
            let noise = |i: usize, j: usize| {
                (((i * 31 + j * 17) as f64 + seed as f64 * 0.37) * 12.9898).sin() * 43758.5453 % 1.0
            };
            let rank = n - nullity.min(n - free - 1);
            let theta = DMatrix::from_fn(rank, n, |i, j| match (i < free, j < free) {
                (true, true) => f64::from(u8::from(i == j)),
                (false, false) => noise(i, j),
                (_, own) => if own { noise(i, j) } else { 0.0 },
            });
            let g = theta.tr_mul(&theta);
            let b = theta.tr_mul(&DVector::from_fn(rank, |i, _| (1.7 * i as f64).cos()));
            let ridge = 10f64.powi(decade);
            let on: Vec<usize> = (0..on.min(n / FEW)).map(|k| (k * 3) % n).collect();
            let spaces = Eigenspaces::of(g.clone());
            prop_assert_eq!(spaces.null.ncols(), n - rank);
            let found = spaces.with_ridge(&b, &on, ridge);
            prop_assert_eq!(found.is_some(), on.len() <= n - rank);
            if let Some(found) = found {
                let mut a = g;
                on.iter().for_each(|&j| a[(j, j)] += ridge);
                let expected = least_norm(&a, &b);
                // Rounding times the condition of random matrices, squared in G: up to 1e9.
                prop_assert!((found - &expected).amax() < 1e-6 * expected.amax().max(1e-3));
            }
        }
    }
}
