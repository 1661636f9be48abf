//! The radius of the least ball about a centre that all trajectories enter.
//!
//! The distance y falls outside the ellipsoid `y·b + yᵀ A y ≥ 0`. Its farthest point is at the distance
//!
//! ```text
//! R² = max |y|²  =  min over μ of  Σ_i μ² b_i² / (4 (μ a_i - 1)),      μ > 1 / a_i for all i,
//! ```
//!
//! with the eigenvalues `-a_i` of A and b in their directions: the dual of a problem with one quadratic constraint, which has its value
//! (S. Boyd, L. Vandenberghe, "Convex Optimization" (2004), appendix B.1).

use nalgebra::{DMatrix, DVector};

/// Halvings of the interval that holds the minimum: to the rounding of its ends.
const HALVINGS: usize = 200;

/// The largest radius over slopes `b` of a centre, whose symmetric matrix is negative definite.
pub(super) fn least(matrix: &DMatrix<f64>, slopes: &[DVector<f64>]) -> f64 {
    let eigen = matrix.clone().symmetric_eigen();
    let decays = -eigen.eigenvalues;
    let of = |b: &DVector<f64>| squared(&decays, &eigen.eigenvectors.tr_mul(b));
    slopes.iter().map(of).fold(0.0, f64::max).sqrt()
}

fn squared(decays: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let slowest = decays.min();
    // With ν = μ a for the slowest decay a: each part is convex in ν > 1 and least at 2 a / a_i, so the minimum is in (1, 2].
    let parts = |nu: f64, of: fn(f64, f64) -> f64| -> f64 {
        let part = |(a, b): (&f64, &f64)| match *b == 0.0 {
            true => 0.0,
            false => b * b / (slowest * slowest) * of(nu, a / slowest),
        };
        decays.iter().zip(b.iter()).map(part).sum()
    };
    let slope = |nu: f64| parts(nu, |nu, a| nu * (nu * a - 2.0) / (nu * a - 1.0).powi(2));
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match slope(middle) > 0.0 {
            true => high = middle,
            false => low = middle,
        }
    }
    // The upper end: there no part has a pole.
    parts(high, |nu, a| nu * nu / (4.0 * (nu * a - 1.0)))
}
