//! The solution of least norm of a symmetric system, without the eigenvectors.
//!
//! `A = Q T Qᵀ` with a tridiagonal `T` by reflections, `T = Z Λ Zᵀ` by the implicit QL method. The reflections and the rotations
//! of which `Q` and `Z` consist are applied to `b` alone, so that the reflections of the matrix, `4 n³/3` operations, are all that
//! costs more than `n²`.
//!
//! Source: G. H. Golub, C. F. Van Loan, "Matrix Computations" (2013), sections 8.3.1 and 8.3.3.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::{is_counted, pseudo_inverse};
use crate::statistics::lanes::{LANES, dot, total};

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
    fn of(a: DMatrix<f64>) -> (Self, Vec<DVector<f64>>) {
        Arch::new().dispatch(Reduction(a))
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

/// The reduction by reflections, with vector instructions. Each step reads and writes the remaining block once: it applies the
/// previous reflection and computes the product for the next one together.
struct Reduction(DMatrix<f64>);

impl WithSimd for Reduction {
    type Output = (Tridiagonal, Vec<DVector<f64>>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut a = self.0;
        let n = a.nrows();
        let mut axes = Vec::with_capacity(n);
        let mut beside = vec![0.0; n];
        // The remaining block is that of `a` minus v wᵀ + w vᵀ.
        let (mut v, mut w) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..n {
            for i in k..n {
                a[(i, k)] -= w[k] * v[i] + v[k] * w[i];
            }
            let after = k + 1;
            if after == n {
                break;
            }
            let mut axis = a.view((after, k), (n - after, 1)).column(0).into_owned();
            let length = axis.norm();
            beside[k] = if axis[0] > 0.0 { -length } else { length };
            axis[0] -= beside[k];
            let square = axis.norm_squared();
            if square > 0.0 {
                axis *= (2.0 / square).sqrt();
            }
            let mut product = vec![0.0; n];
            let mut left = Left {
                rows: n,
                v: &v,
                w: &w,
                axis: axis.as_slice(),
                after,
                product: &mut product,
            };
            let mut columns = a.as_mut_slice()[after * n..].chunks_exact_mut(2 * n);
            let mut j = after;
            for pair in &mut columns {
                let (one, two) = pair.split_at_mut(n);
                left.pair(simd, j, one, two);
                j += 2;
            }
            let last = columns.into_remainder();
            if !last.is_empty() {
                left.entry(j, j, last);
            }
            v.fill(0.0);
            v[after..].copy_from_slice(axis.as_slice());
            let half = 0.5 * dot(&product[after..], axis.as_slice());
            w = product;
            w.iter_mut().zip(&v).for_each(|(w, v)| *w -= half * v);
            axes.push(axis);
        }
        let diagonal = a.diagonal().iter().copied().collect();
        (Tridiagonal { diagonal, beside }, axes)
    }
}

/// The remaining block in one step of the reduction, and its product with the axis of the next reflection.
struct Left<'a> {
    rows: usize,
    v: &'a [f64],
    w: &'a [f64],
    /// Of the rows from `after` on.
    axis: &'a [f64],
    after: usize,
    product: &'a mut [f64],
}

impl Left<'_> {
    /// Brings the entry of row i in column j up to date, and adds what it and its mirror image give to the product.
    #[inline(always)]
    fn entry(&mut self, i: usize, j: usize, column: &mut [f64]) {
        column[i] -= self.w[j] * self.v[i] + self.v[j] * self.w[i];
        self.product[i] += column[i] * self.axis[j - self.after];
        if i != j {
            self.product[j] += column[i] * self.axis[i - self.after];
        }
    }

    /// The columns j and j + 1 from their diagonal on.
    #[inline(always)]
    fn pair<S: Simd>(&mut self, simd: S, j: usize, one: &mut [f64], two: &mut [f64]) {
        self.entry(j, j, one);
        self.entry(j + 1, j, one);
        self.entry(j + 1, j + 1, two);
        let first = j + 2;
        let whole = first + (self.rows - first) / LANES * LANES;
        let axis = &self.axis[j - self.after..];
        let [v0, v1] = [self.v[j], self.v[j + 1]].map(|v| simd.splat_f64s(v));
        let [w0, w1] = [self.w[j], self.w[j + 1]].map(|w| simd.splat_f64s(w));
        let [axis0, axis1] = [axis[0], axis[1]].map(|v| simd.splat_f64s(v));
        let a_rows = S::as_mut_simd_f64s(&mut one[first..whole]).0;
        let b_rows = S::as_mut_simd_f64s(&mut two[first..whole]).0;
        let v_rows = S::as_simd_f64s(&self.v[first..whole]).0;
        let w_rows = S::as_simd_f64s(&self.w[first..whole]).0;
        let axis_rows = S::as_simd_f64s(&axis[2..][..whole - first]).0;
        let products = S::as_mut_simd_f64s(&mut self.product[first..whole]).0;
        // Registers of a sum; with the narrowest, one for each lane.
        let parts = LANES / S::F64_LANES;
        let mut sums = [[simd.splat_f64s(0.0); LANES]; 2];
        let rows = a_rows
            .chunks_exact_mut(parts)
            .zip(b_rows.chunks_exact_mut(parts))
            .zip(v_rows.chunks_exact(parts).zip(w_rows.chunks_exact(parts)))
            .zip(axis_rows.chunks_exact(parts))
            .zip(products.chunks_exact_mut(parts));
        for ((((a, b), (v, w)), axis), product) in rows {
            for q in 0..parts {
                let (v, w, axis) = (v[q], w[q], axis[q]);
                let change = |w0, v0| simd.add_f64s(simd.mul_f64s(w0, v), simd.mul_f64s(v0, w));
                let x = simd.sub_f64s(a[q], change(w0, v0));
                let y = simd.sub_f64s(b[q], change(w1, v1));
                sums[0][q] = simd.add_f64s(sums[0][q], simd.mul_f64s(x, axis));
                sums[1][q] = simd.add_f64s(sums[1][q], simd.mul_f64s(y, axis));
                let more = simd.add_f64s(simd.mul_f64s(x, axis0), simd.mul_f64s(y, axis1));
                product[q] = simd.add_f64s(product[q], more);
                (a[q], b[q]) = (x, y);
            }
        }
        for (sum, column) in sums.iter().zip(j..) {
            let mut lanes = [0.0; LANES];
            let registers = S::as_mut_simd_f64s(&mut lanes).0;
            registers.copy_from_slice(&sum[..parts]);
            self.product[column] += total(&lanes);
        }
        for i in whole..self.rows {
            self.entry(i, j, one);
            self.entry(i, j + 1, two);
        }
    }
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

    /// With the axes one after the other.
    fn flat((reduced, axes): (Tridiagonal, Vec<DVector<f64>>)) -> Vec<u64> {
        let axes = axes.iter().flat_map(|axis| axis.iter());
        let numbers = reduced.diagonal.iter().chain(&reduced.beside).chain(axes);
        numbers.map(|v| v.to_bits()).collect()
    }

    #[test]
    fn prop_the_width_of_registers_changes_no_bit() {
        for n in [1, 2, 3, 10, 11, 37, 64] {
            let a = matrix(n, n, 1.0, 5);
            let best = flat(Arch::new().dispatch(Reduction(a.clone())));
            let narrow = pulp::Scalar.vectorize(Reduction(a.clone()));
            assert_eq!(best, flat(narrow), "{n}");
            let narrow = pulp::Scalar128b.vectorize(Reduction(a));
            assert_eq!(best, flat(narrow), "{n}");
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
