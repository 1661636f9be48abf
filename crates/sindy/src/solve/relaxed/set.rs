//! Linear constraints, and the minimum of a convex quadratic function under them.

use nalgebra::{DMatrix, DVector};

use crate::solve::outcome::Outcome;
use crate::statistics::regression::pseudo_inverse;
use crate::statistics::tsqr;

/// Eigenvalues of the (scaled) quadratic function below this share of the largest count as it: along such
/// directions only the constraints move anything.
const FLOOR: f64 = 1e-12;

/// A constraint is met if it is missed by no more than this share of the numbers in it.
const TOLERANCE: f64 = 1e-12;

/// The set `C ξ = d, A ξ <= b`; the equations as a point and a basis of directions.
pub(super) struct Set {
    point: DVector<f64>,
    basis: DMatrix<f64>,
    a: DMatrix<f64>,
    b: DVector<f64>,
    /// Whether the equations can all hold, to rounding.
    consistent: bool,
}

impl Set {
    pub(super) fn new(
        (c, d): (&DMatrix<f64>, &DVector<f64>),
        (a, b): (&DMatrix<f64>, &DVector<f64>),
    ) -> Self {
        let (point, basis, consistent) = affine(c, d);
        Self {
            point,
            basis,
            a: a.clone(),
            b: b.clone(),
            consistent,
        }
    }

    /// Whether the equations can all hold.
    pub(super) fn consistent(&self) -> bool {
        self.consistent
    }

    /// Whether there is any such point.
    pub(super) fn feasible(&self) -> bool {
        let p = self.point.len();
        self.consistent
            && self.minimum(&DMatrix::identity(p, p), &DVector::zeros(p))
                != Err(Outcome::Infeasible)
    }

    /// The quadratic function on the directions that are left, in columns of unit length (which keeps a badly scaled
    /// library from looking dependent), and these lengths.
    fn reduced(
        &self,
        h: &DMatrix<f64>,
        r: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let hz = self.basis.transpose() * h * &self.basis;
        let s = hz.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
        let rhs = (self.basis.transpose() * (r - h * &self.point)).component_div(&s);
        let hz = DMatrix::from_fn(s.len(), s.len(), |i, j| hz[(i, j)] / s[i] / s[j]);
        (hz, rhs, s)
    }

    /// The minimum without the inequalities.
    pub(super) fn equations_only(&self, h: &DMatrix<f64>, r: &DVector<f64>) -> DVector<f64> {
        if self.basis.ncols() == 0 {
            return self.point.clone();
        }
        let (hz, rhs, s) = self.reduced(h, r);
        &self.point + &self.basis * (pseudo_inverse(&hz) * rhs).component_div(&s)
    }

    /// The minimum of `1/2 ξᵀ H ξ - ξᵀ r` on the set; least norm (over scaled directions) where it is not
    /// unique. Where equations contradict each other, they are met as nearly as may be.
    pub(super) fn minimum(
        &self,
        h: &DMatrix<f64>,
        r: &DVector<f64>,
    ) -> Result<DVector<f64>, Outcome> {
        let free = self.basis.ncols();
        let rest = &self.b - &self.a * &self.point;
        if free == 0 {
            let missed = (0..rest.len()).any(|i| {
                let size: f64 = (0..self.point.len())
                    .map(|j| (self.a[(i, j)] * self.point[j]).abs())
                    .sum();
                rest[i] < -TOLERANCE * (size + self.b[i].abs())
            });
            return if missed {
                Err(Outcome::Infeasible)
            } else {
                Ok(self.point.clone())
            };
        }
        if self.b.is_empty() {
            return Ok(self.equations_only(h, r));
        }
        let (hz, rhs, s) = self.reduced(h, r);
        // In w = Λ^½ Vᵀ S v the function is |w - w₀|²/2: the minimum is a projection.
        let eigen = hz.symmetric_eigen();
        let largest = match eigen.eigenvalues.max() {
            l if l > 0.0 => l,
            _ => 1.0,
        };
        let root = eigen.eigenvalues.map(|l| l.max(FLOOR * largest).sqrt());
        let mut start = eigen.eigenvectors.tr_mul(&rhs).component_div(&root);
        for k in 0..free {
            if eigen.eigenvalues[k] <= FLOOR * largest {
                start[k] = 0.0;
            }
        }
        let turn = DMatrix::from_fn(free, free, |i, k| {
            eigen.eigenvectors[(i, k)] / root[k] / s[i]
        });
        let back = &self.basis * turn;
        let w = project(start, &(&self.a * &back), &rest)?;
        Ok(&self.point + back * w)
    }
}

/// The point of `N w <= e` nearest to `start`, by the dual active-set method for a quadratic function whose matrix is
/// the identity.
///
/// Source: D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic
/// programs", Mathematical Programming 27 (1983).
fn project(
    start: DVector<f64>,
    normals: &DMatrix<f64>,
    e: &DVector<f64>,
) -> Result<DVector<f64>, Outcome> {
    let mut rows: Vec<(DVector<f64>, f64)> = Vec::with_capacity(e.len());
    for (i, &e) in e.iter().enumerate() {
        let normal = normals.row(i).transpose();
        let length = normal.norm();
        if length > 0.0 {
            rows.push((normal / length, e / length));
        } else if e < 0.0 {
            return Err(Outcome::Infeasible);
        }
    }
    let mut w = start;
    let mut active: Vec<usize> = Vec::new();
    let mut multipliers: Vec<f64> = Vec::new();
    for _ in 0..100 * (rows.len() + w.len()) {
        let worst = (0..rows.len())
            .filter(|i| !active.contains(i))
            .map(|i| (i, rows[i].0.dot(&w) - rows[i].1))
            .filter(|&(i, miss)| miss > TOLERANCE * (w.norm() + rows[i].1.abs()))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((new, mut miss)) = worst else {
            return Ok(w);
        };
        let normal = rows[new].0.clone();
        let mut multiplier = 0.0;
        loop {
            let held: Vec<DVector<f64>> = active.iter().map(|&i| rows[i].0.clone()).collect();
            let (share, step) = if held.is_empty() {
                (DVector::zeros(0), normal.clone())
            } else {
                let held = DMatrix::from_columns(&held);
                let share = tsqr::solve(&held, &normal);
                let step = &normal - held * &share;
                (share, step)
            };
            let square = step.norm_squared();
            // A normal within 1e-9 of the span of those held cannot be followed any further.
            let whole = if square > 1e-18 {
                miss / square
            } else {
                f64::INFINITY
            };
            let first = (0..share.len())
                .filter(|&k| share[k] > 1e-14)
                .map(|k| (k, multipliers[k] / share[k]))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let length = first.map_or(whole, |(_, length)| length.min(whole));
            if length == f64::INFINITY {
                return Err(Outcome::Infeasible);
            }
            if whole < f64::INFINITY {
                w.axpy(-length, &step, 1.0);
                miss -= length * square;
            }
            for (m, share) in multipliers.iter_mut().zip(share.iter()) {
                *m -= length * share;
            }
            multiplier += length;
            match first {
                Some((k, length)) if length < whole => {
                    active.remove(k);
                    multipliers.remove(k);
                }
                _ => break,
            }
        }
        active.push(new);
        multipliers.push(multiplier);
    }
    Err(Outcome::IterationLimit)
}

/// `C ξ = d` as its point of least norm and an orthonormal basis of the null space of `C`, whose rows are made
/// unit length first; and whether there is such a point, to rounding.
fn affine(c: &DMatrix<f64>, d: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>, bool) {
    let p = c.ncols();
    let length: Vec<f64> = (0..c.nrows())
        .map(|i| c.row(i).norm())
        .map(|l| if l > 0.0 { l } else { 1.0 })
        .collect();
    let c = DMatrix::from_fn(c.nrows(), p, |i, j| c[(i, j)] / length[i]);
    let d = DVector::from_fn(d.len(), |i, _| d[i] / length[i]);
    if c.is_empty() {
        let consistent = d.iter().all(|v| *v == 0.0);
        return (DVector::zeros(p), DMatrix::identity(p, p), consistent);
    }
    // Eigenvectors of CᵀC with rows of unit length: those of eigenvalue zero span the null space.
    let eigen = (c.transpose() * &c).symmetric_eigen();
    let point = pseudo_inverse(&(c.transpose() * &c)) * c.transpose() * &d;
    let largest = eigen.eigenvalues.max();
    let null: Vec<usize> = (0..p)
        .filter(|&j| eigen.eigenvalues[j] <= 1e-13 * largest)
        .collect();
    let missed = (&c * &point - &d).amax();
    let consistent = missed <= 1e-9 * (d.amax() + point.amax());
    (point, eigen.eigenvectors.select_columns(&null), consistent)
}
