//! The centre of fastest decay: the least of the largest eigenvalue of a symmetric matrix that is affine in m.
//!
//! ```text
//! min s   over m, s   with   s I - A_S(m) positive definite
//! ```
//!
//! by a barrier, `s/τ - log det(s I - A_S(m))` with falling τ, which Newton's method minimises. The minimum is right to n τ.
//!
//! Source: S. Boyd, L. Vandenberghe, "Convex Optimization" (2004), section 11.6.

use nalgebra::{DMatrix, DVector};

use crate::numerics::{Quadratic, newton};

/// Factor by which τ falls from one minimisation to the next: each start is then near its minimum.
const FALL: f64 = 0.2;
/// The last τ, relative to the size of the matrix.
const LAST: f64 = 1e-10;
/// Weight of the distance from the start beside the barrier. It decides along directions that the barrier leaves free, and alters the
/// minimum by this share of τ alone.
const NEAR: f64 = 1e-6;

/// `A + Σ_k m_k B_k`, symmetric.
#[derive(Clone, Debug)]
pub(crate) struct AffineMatrix {
    pub constant: DMatrix<f64>,
    pub slopes: Vec<DMatrix<f64>>,
}

impl AffineMatrix {
    /// The symmetric part of a Jacobian, from its value at the origin and its derivatives by the states.
    pub(crate) fn new(linear: &DMatrix<f64>, quadratic: &[DMatrix<f64>]) -> Self {
        let symmetric = |a: &DMatrix<f64>| 0.5 * (a + a.transpose());
        Self {
            constant: symmetric(linear),
            slopes: quadratic.iter().map(symmetric).collect(),
        }
    }

    pub(crate) fn at(&self, m: &DVector<f64>) -> DMatrix<f64> {
        let parts = self.slopes.iter().zip(m.iter());
        parts.fold(self.constant.clone(), |sum, (by, m)| sum + by * *m)
    }

    /// Frobenius norm of the constant part, 1 if it is zero.
    pub(crate) fn size(&self) -> f64 {
        positive_or_one(self.constant.norm())
    }

    /// Distances that change the matrix by its size.
    pub(crate) fn reach(&self) -> f64 {
        let largest = self.slopes.iter().map(DMatrix::norm).fold(0.0, f64::max);
        positive_or_one(self.size() / largest)
    }
}

fn positive_or_one(value: f64) -> f64 {
    match value > 0.0 && value.is_finite() {
        true => value,
        false => 1.0,
    }
}

pub(crate) fn largest_eigenvalue(symmetric: &DMatrix<f64>) -> f64 {
    symmetric.symmetric_eigenvalues().max()
}

/// Value, gradient and curvature of `-log det S` for `S` with these derivatives by its variables; `None` where S is not positive definite.
pub(crate) fn barrier(s: DMatrix<f64>, slopes: &[DMatrix<f64>]) -> Option<Quadratic> {
    let factor = s.cholesky()?;
    let diagonal = factor.l_dirty().diagonal();
    let value = -2.0 * diagonal.iter().map(|d| d.ln()).sum::<f64>();
    let products: Vec<DMatrix<f64>> = slopes.iter().map(|b| factor.solve(b)).collect();
    let n = slopes.len();
    Some(Quadratic {
        value,
        gradient: DVector::from_iterator(n, products.iter().map(|p| -p.trace())),
        curvature: DMatrix::from_fn(n, n, |a, b| products[a].dot(&products[b].transpose())),
    })
}

/// The m of the least largest eigenvalue; of several the one nearest to `start`.
pub(crate) fn of_fastest_decay(matrix: &AffineMatrix, start: &DVector<f64>) -> DVector<f64> {
    let n = start.len();
    if matrix.slopes.iter().all(|b| b.iter().all(|v| *v == 0.0)) {
        return start.clone();
    }
    // Variables: m in units of the reach, then s in units of the size.
    let (size, reach) = (matrix.size(), matrix.reach());
    let identity = DMatrix::<f64>::identity(n, n);
    let mut slopes: Vec<DMatrix<f64>> = matrix
        .slopes
        .iter()
        .map(|b| b * (-reach / size))
        .collect();
    slopes.push(identity.clone());
    let from = start / reach;
    let of = |v: &DVector<f64>| (v.rows(0, n) * reach).into_owned();
    let mut v = from.clone().push(0.0);
    v[n] = largest_eigenvalue(&matrix.at(start)) / size + 1.0;
    let mut tau = 1.0;
    while tau > LAST {
        v = newton(v, |v| {
            let s = &identity * v[n] - matrix.at(&of(v)) / size;
            let mut here = barrier(s, &slopes)?;
            here.value += v[n] / tau;
            here.gradient[n] += 1.0 / tau;
            for k in 0..n {
                let away = v[k] - from[k];
                here.value += 0.5 * NEAR * away * away;
                here.gradient[k] += NEAR * away;
                here.curvature[(k, k)] += NEAR;
            }
            Some(here)
        });
        tau *= FALL;
    }
    of(&v)
}
