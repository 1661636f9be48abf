//! The solution of least norm of a symmetric system, without the eigenvectors.
//!
//! `A = Q T Qᵀ` with a tridiagonal `T` by reflections, `T = Z Λ Zᵀ` by the implicit QL method. The reflections and the rotations
//! of which `Q` and `Z` consist are applied to `b` alone, so that the reflections of the matrix, `4 n³/3` operations, are all that
//! costs more than `n²`.
//!
//! Source: G. H. Golub, C. F. Van Loan, "Matrix Computations" (2013), sections 8.3.1 and 8.3.3.

use nalgebra::{DMatrix, DVector};

use super::{is_counted, pseudo_inverse};

/// Sweeps for one eigenvalue, at most; two are usual.
const SWEEPS: usize = 60;

/// A rotation of the entries `row` and `row + 1`.
struct Rotation {
    row: usize,
    cosine: f64,
    sine: f64,
}

/// `A⁺ b` for a symmetric positive semi-definite `A`: as the pseudo-inverse times `b`, to rounding. Of `A` the lower triangle is
/// read.
pub(crate) fn least_norm(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let scale = a.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if !(scale > 0.0) {
        return DVector::zeros(b.len());
    }
    let (mut reduced, axes) = Tridiagonal::of(a / scale);
    let mut x = b.clone();
    axes.iter()
        .enumerate()
        .for_each(|(k, v)| reflect(v, k, &mut x));
    let Some(rotations) = reduced.diagonalise() else {
        return pseudo_inverse(a) * b;
    };
    for r in &rotations {
        let (own, next) = (x[r.row], x[r.row + 1]);
        x[r.row + 1] = r.sine * own + r.cosine * next;
        x[r.row] = r.cosine * own - r.sine * next;
    }
    let largest = reduced.diagonal.iter().copied().fold(0.0, f64::max);
    for (x, &value) in x.iter_mut().zip(&reduced.diagonal) {
        *x = if is_counted(value, largest) {
            *x / (value * scale)
        } else {
            0.0
        };
    }
    for r in rotations.iter().rev() {
        let (own, next) = (x[r.row], x[r.row + 1]);
        x[r.row] = r.cosine * own + r.sine * next;
        x[r.row + 1] = r.cosine * next - r.sine * own;
    }
    let backwards = axes.iter().enumerate().rev();
    backwards.for_each(|(k, v)| reflect(v, k, &mut x));
    x
}

/// `x - v (vᵀ x)` in the entries after `k`, with `vᵀ v = 2` or no `v`.
fn reflect(v: &DVector<f64>, k: usize, x: &mut DVector<f64>) {
    let mut rest = x.rows_mut(k + 1, v.len());
    let along = v.dot(&rest);
    rest.axpy(-along, v, 1.0);
}

/// A symmetric tridiagonal matrix, whose largest entry is about 1.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Beside the diagonal; zero after the last.
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// Reduces a symmetric matrix, of which the lower triangle is read; with the axes of the reflections, each of length √2.
    fn of(mut a: DMatrix<f64>) -> (Self, Vec<DVector<f64>>) {
        let n = a.nrows();
        let mut axes = Vec::with_capacity(n);
        let mut beside = vec![0.0; n];
        for k in 0..n - 1 {
            let m = n - k - 1;
            let mut v = a.view((k + 1, k), (m, 1)).column(0).into_owned();
            let length = v.norm();
            beside[k] = if v[0] > 0.0 { -length } else { length };
            v[0] -= beside[k];
            let axis = v.norm_squared();
            if axis > 0.0 {
                v *= (2.0 / axis).sqrt();
            }
            let mut w = times(&a, k + 1, &v);
            w.axpy(-0.5 * w.dot(&v), &v, 1.0);
            for j in 0..m {
                let mut column = a.view_mut((k + 1 + j, k + 1 + j), (m - j, 1));
                let mut column = column.column_mut(0);
                column.axpy(-w[j], &v.rows(j, m - j), 1.0);
                column.axpy(-v[j], &w.rows(j, m - j), 1.0);
            }
            axes.push(v);
        }
        let diagonal = a.diagonal().iter().copied().collect();
        (Self { diagonal, beside }, axes)
    }

    /// Leaves the eigenvalues on the diagonal; the rotations in their order, or `None` where they do not settle.
    fn diagonalise(&mut self) -> Option<Vec<Rotation>> {
        let n = self.diagonal.len();
        let mut rotations = Vec::with_capacity(2 * n * n);
        for first in 0..n {
            for sweep in 0.. {
                let last = (first..n - 1).find(|&i| self.is_apart(i)).unwrap_or(n - 1);
                if last == first {
                    break;
                }
                if sweep == SWEEPS {
                    return None;
                }
                self.sweep(first, last, &mut rotations);
            }
        }
        Some(rotations)
    }

    /// Whether the entry beside the diagonal is lost in the rounding of the whole.
    fn is_apart(&self, i: usize) -> bool {
        !(self.beside[i].abs() > f64::EPSILON)
    }

    /// One implicit QL sweep over a part that does not fall apart.
    fn sweep(&mut self, first: usize, last: usize, rotations: &mut Vec<Rotation>) {
        let (d, e) = (&mut self.diagonal, &mut self.beside);
        // Wilkinson's shift, from the upper end of the part.
        let half = (d[first + 1] - d[first]) / (2.0 * e[first]);
        let root = half.hypot(1.0).copysign(half);
        let length = |f: f64, g: f64| (f * f + g * g).sqrt();
        let mut g = d[last] - d[first] + e[first] / (half + root);
        let (mut sine, mut cosine, mut shift) = (1.0, 1.0, 0.0);
        for i in (first..last).rev() {
            let (f, b) = (sine * e[i], cosine * e[i]);
            let r = length(f, g);
            e[i + 1] = r;
            if r == 0.0 {
                d[i + 1] -= shift;
                e[last] = 0.0;
                return;
            }
            (sine, cosine) = (f / r, g / r);
            let g_next = d[i + 1] - shift;
            let r = (d[i] - g_next) * sine + 2.0 * cosine * b;
            shift = sine * r;
            d[i + 1] = g_next + shift;
            g = cosine * r - b;
            rotations.push(Rotation {
                row: i,
                cosine,
                sine,
            });
        }
        d[first] -= shift;
        e[first] = g;
        e[last] = 0.0;
    }
}

/// The product of the part from `first` on of a symmetric matrix, of which the lower triangle is read.
fn times(a: &DMatrix<f64>, first: usize, v: &DVector<f64>) -> DVector<f64> {
    let m = v.len();
    let mut out = DVector::zeros(m);
    for j in 0..m {
        let below = a.view((first + j + 1, first + j), (m - j - 1, 1));
        let below = below.column(0);
        out[j] += a[(first + j, first + j)] * v[j] + below.dot(&v.rows(j + 1, m - j - 1));
        out.rows_mut(j + 1, m - j - 1).axpy(v[j], &below, 1.0);
    }
    out
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A matrix of n rows and the given rank, of which columns differ in length by up to 10^`decades`.
    fn matrix(n: usize, rank: usize, decades: f64, seed: u64) -> DMatrix<f64> {
        let root = DMatrix::from_fn(n, rank, |i, j| {
            let at = ((i * 31 + j * 17) as f64 + seed as f64 * 0.37) * 12.9898;
            (at.sin() * 43758.5453).fract() * 10f64.powf(-decades * j as f64 / rank as f64)
        });
        &root * root.transpose()
    }

    proptest! {
        #[test]
        fn prop_least_norm_is_the_pseudo_inverse(
            n in 1usize..60, share in 0.0..0.6, decades in 0.0..2.0, seed in 0u64..1000,
        ) {
            // Far fewer than n, so that no eigenvalue is near the share that counts as zero.
            let rank = ((share * n as f64) as usize).max(1);
            let a = matrix(n, rank, decades, seed);
            let b = DVector::from_fn(n, |i, _| (1.7 * i as f64).sin());
            let (found, expected) = (least_norm(&a, &b), pseudo_inverse(&a) * &b);
            // Rounding times conditions up to 1e7, as the pseudo-inverse has it too.
            let scale = expected.amax().max(1e-300);
            prop_assert!((found - expected).amax() < 1e-7 * scale, "{n}, {rank}");
        }
    }

    /// All eigenvalues count, and the solution is that of Cholesky's factor.
    #[test]
    fn analytic_least_norm_of_a_large_definite_system() {
        let a = matrix(120, 120, 0.5, 3) + DMatrix::identity(120, 120);
        let b = DVector::from_fn(120, |i, _| (0.3 * i as f64).cos());
        let expected = a.clone().cholesky().unwrap().solve(&b);
        // Rounding times a condition of some 1e3.
        assert!((least_norm(&a, &b) - expected).amax() < 1e-12);
    }

    #[test]
    fn analytic_least_norm_of_small_and_of_extreme_systems() {
        let solve = |n: usize, a: &[f64], b: &[f64]| {
            let a = DMatrix::from_row_slice(n, n, a);
            let x = least_norm(&a, &DVector::from_row_slice(b));
            x.iter().copied().collect::<Vec<_>>()
        };
        assert!(solve(0, &[], &[]).is_empty());
        assert_eq!(solve(1, &[4.0], &[2.0]), [0.5]);
        assert_eq!(solve(1, &[0.0], &[2.0]), [0.0]);
        assert_eq!(solve(2, &[0.0; 4], &[1.0, 2.0]), [0.0, 0.0]);
        // Already diagonal, one direction absent.
        let x = solve(
            3,
            &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0],
            &[2.0, 5.0, 8.0],
        );
        assert_eq!(x, [1.0, 0.0, 2.0]);
        // Two equal columns share a coefficient, at any scale.
        for scale in [1e-290, 1.0, 1e290] {
            let x = solve(2, &[scale; 4], &[3.0 * scale; 2]);
            assert!(x.iter().all(|x| (x - 1.5).abs() < 1e-14), "{x:?}");
        }
        // A NaN does not keep the sweeps from ending: its direction counts as absent.
        let x = solve(2, &[f64::NAN, 0.0, 0.0, 1.0], &[1.0, 1.0]);
        assert_eq!(x, [0.0, 1.0]);
    }
}
