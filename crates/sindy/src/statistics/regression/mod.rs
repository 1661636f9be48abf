//! Least squares from sufficient statistics, and its standard errors.

mod clusters;
mod eigenspaces;
mod least_norm;
mod refits;

use nalgebra::{DMatrix, DVector};

pub use clusters::{ClusterErrors, Clusters, cluster_errors, student_95};
pub(crate) use eigenspaces::{Eigenspaces, LastEigenspaces};
pub(crate) use least_norm::least_norm;
pub(crate) use refits::Refits;

use crate::statistics::gram::Gram;

/// Columns whose scaled Gram eigenvalue falls below this share of the largest are treated as
/// dependent: the Gram matrix squares the condition, so f64 carries no more than half its digits.
const RANK_TOLERANCE: f64 = 1e-13;

/// Least squares on the terms of `support` (minimum norm where they are dependent); zero elsewhere.
///
/// Columns are scaled to unit length first, then the scaled normal equations are solved through their
/// eigenvalues; or, where the statistics carry one, through the triangular factor
/// ([`tsqr`](crate::statistics::tsqr)).
#[must_use]
pub fn least_squares(gram: &Gram, support: &[bool]) -> DVector<f64> {
    if let Some(triangle) = &gram.triangle {
        return triangle.least_squares(support);
    }
    let normal = UnitLength::new(gram, support);
    if normal.b.is_empty() {
        return DVector::zeros(support.len());
    }
    let spaces = Eigenspaces::of(normal.g.clone());
    normal.spread(&spaces.least_norm(&normal.b))
}

/// The normal equations on a support, with columns of unit length.
struct UnitLength {
    g: DMatrix<f64>,
    b: DVector<f64>,
    /// Each column's term and length.
    columns: Vec<(usize, f64)>,
    /// Terms of the library.
    p: usize,
}

impl UnitLength {
    fn new(gram: &Gram, support: &[bool]) -> Self {
        let terms = (0..support.len()).filter(|&j| support[j]);
        let columns: Vec<(usize, f64)> = terms.map(|j| (j, length(gram, j))).collect();
        let k = columns.len();
        let g = DMatrix::from_fn(k, k, |a, b| {
            let ((i, own), (j, other)) = (columns[a], columns[b]);
            gram.xtx[(i, j)] / (own * other)
        });
        let b = DVector::from_iterator(k, columns.iter().map(|&(j, l)| gram.xty[j] / l));
        Self {
            g,
            b,
            columns,
            p: support.len(),
        }
    }

    /// A solution in the units of the data, over all terms.
    fn spread(&self, solution: &DVector<f64>) -> DVector<f64> {
        let mut out = DVector::zeros(self.p);
        for (&(j, length), xi) in self.columns.iter().zip(solution) {
            out[j] = xi / length;
        }
        out
    }
}

/// Length of column `j` (1 for a zero column).
fn length(gram: &Gram, j: usize) -> f64 {
    let g = gram.xtx[(j, j)];
    if g > 0.0 { g.sqrt() } else { 1.0 }
}

/// Whether an eigenvalue is more than rounding beside the largest.
fn is_counted(value: f64, largest: f64) -> bool {
    value > RANK_TOLERANCE * largest && value > 0.0
}

/// Pseudo-inverse of a symmetric positive semi-definite matrix.
pub(crate) fn pseudo_inverse(g: &DMatrix<f64>) -> DMatrix<f64> {
    // Every parameter at its bound leaves nothing to solve for; the eigenvalue routine wants at least one.
    if g.is_empty() {
        return g.clone();
    }
    let eigen = g.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let inverse = eigen
        .eigenvalues
        .map(|l| if is_counted(l, largest) { 1.0 / l } else { 0.0 });
    &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Library, Samples};

    #[test]
    fn analytic_collinear_columns_share_the_coefficient() {
        let mut samples = Samples::new(&["x", "y"]);
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) / 50.0 - 0.5).collect();
        let y = x.iter().map(|x| 3.0 * x).collect();
        samples.push_group(vec![x, y]).unwrap();
        let library = Library::parse(&["x", "2*x"]).unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        let xi = least_squares(&gram, &[true, true]);
        // Columns of unit length are equal, so the minimum norm solution splits 3 x evenly: 1.5 and 0.75.
        assert!(
            (xi[0] - 1.5).abs() < 1e-9 && (xi[1] - 0.75).abs() < 1e-9,
            "{xi}"
        );
        assert_eq!(least_squares(&gram, &[false, false]), DVector::zeros(2));
    }

    #[test]
    fn prop_badly_scaled_columns_are_fitted() {
        let mut samples = Samples::new(&["x", "y"]);
        let x: Vec<f64> = (0..200).map(|i| 1e9 * (0.1 * f64::from(i)).sin()).collect();
        let y = x.iter().map(|x| 1e-12 * x + 4e-21 * x * x).collect();
        samples.push_group(vec![x, y]).unwrap();
        let library = Library::parse(&["1", "x", "x^2"]).unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        let xi = least_squares(&gram, &[true; 3]);
        // Columns are scaled to unit length: relative rounding of a condition of about 3, squared.
        assert!(
            (xi[1] / 1e-12 - 1.0).abs() < 1e-9 && (xi[2] / 4e-21 - 1.0).abs() < 1e-9,
            "{xi}"
        );
    }
}
