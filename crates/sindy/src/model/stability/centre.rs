//! The centre of a trapping region: the m at which the largest eigenvalue of `A_S(m)` is least.
//!
//! The function is convex, with kinks where eigenvalues meet. It is smoothed to `μ ln tr exp(A_S(m)/μ)`, which lies between it and `μ ln n`
//! above, and μ falls.
//!
//! Source of the smoothing: Y. Nesterov, "Smoothing technique and its applications in semidefinite optimization", Math. Program. 110 (2007).

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::form::{QuadraticForm, largest_eigenvalue};
use crate::numerics::bfgs;

/// The first and last μ, as shares of the size of `A_S`, and the factor between two. The last bounds the error of the eigenvalue.
const FIRST: f64 = 0.3;
const LAST: f64 = 1e-5;
const FACTOR: f64 = 0.2;
/// Steps for each μ, at most.
const STEPS: usize = 200;

/// The centre from a start, and the eigenvalue there, which is never above that of the start.
pub(crate) fn centre(form: &QuadraticForm, start: &DVector<f64>) -> (DVector<f64>, f64) {
    let at = |m: &DVector<f64>| largest_eigenvalue(&form.symmetric(m));
    let mut best = (start.clone(), at(start));
    let size = form.symmetric(start).norm().max(form.linear.norm());
    if size == 0.0 {
        return best;
    }
    let mut m = start.clone();
    let mut mu = FIRST * size;
    while mu >= LAST * size {
        m = bfgs(|m| Some(smoothed(form, m, mu)), &m, STEPS);
        let value = at(&m);
        if value < best.1 {
            best = (m.clone(), value);
        }
        mu *= FACTOR;
    }
    best
}

/// The smoothed largest eigenvalue and its gradient.
fn smoothed(form: &QuadraticForm, m: &DVector<f64>, mu: f64) -> (f64, DVector<f64>) {
    let eigen = SymmetricEigen::new(form.symmetric(m));
    let top = eigen.eigenvalues.max();
    let weights = eigen.eigenvalues.map(|v| ((v - top) / mu).exp());
    let sum = weights.sum();
    let vectors = &eigen.eigenvectors;
    let density = vectors * DMatrix::from_diagonal(&(weights / sum)) * vectors.transpose();
    (top + mu * sum.ln(), form.slope(&density))
}
