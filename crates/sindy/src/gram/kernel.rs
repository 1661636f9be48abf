//! The products of all pairs of columns, in whatever vector instructions the processor has.
//!
//! Each product is eight partial sums (partial sum `k` takes the rows `r ≡ k` mod 8), added in a fixed
//! order, without fused multiply-add. The width of the registers decides only how many partial sums are
//! carried at a time, and the size of a tile only how often a column is loaded: the result has the same
//! bits on every machine.

use pulp::{Arch, Simd, WithSimd};

/// Partial sums of each product.
const LANES: usize = 8;

/// `out[j*m + i] = c_i · c_j` for `i <= j`, of `m` columns of `rows` rows, one after the other in
/// `columns`. The rest of `out` (m x m) is left alone.
pub(super) fn upper_products(columns: &[f64], rows: usize, out: &mut [f64]) {
    Arch::new().dispatch(Products { columns, rows, out });
}

/// The sum of all values in a fixed order, by 32 partial sums; not finite if one of them is not.
pub(super) fn sum(values: &[f64]) -> f64 {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut partial = [0.0; 32];
            let chunks = values.chunks_exact(32);
            let tail: f64 = chunks.remainder().iter().sum();
            for chunk in chunks {
                for (s, v) in partial.iter_mut().zip(chunk) {
                    *s += v;
                }
            }
            partial.iter().sum::<f64>() + tail
        },
    )
}

struct Products<'a> {
    columns: &'a [f64],
    rows: usize,
    out: &'a mut [f64],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::REGISTER_COUNT >= 32 {
            self.panels::<S, 4, 4>(simd);
        } else {
            self.panels::<S, 3, 4>(simd);
        }
    }
}

impl Products<'_> {
    /// All tiles of A x B products that touch the upper triangle; the columns that are left over at the
    /// end are taken one by one.
    #[inline(always)]
    fn panels<S: Simd, const A: usize, const B: usize>(mut self, simd: S) {
        let m = self.columns.len().checked_div(self.rows).unwrap_or(0);
        let whole = m - m % B;
        for j in (0..whole).step_by(B) {
            for i in (0..j + B).step_by(A) {
                self.tile::<S, A, B>(simd, i, j);
            }
        }
        for j in whole..m {
            for i in (0..=j).step_by(8) {
                self.tile::<S, 8, 1>(simd, i, j);
            }
        }
    }

    /// Column `c`; the last one where there is no such column.
    #[inline(always)]
    fn column(&self, c: usize) -> &[f64] {
        let c = c.min(self.columns.len() / self.rows - 1);
        &self.columns[c * self.rows..(c + 1) * self.rows]
    }

    /// The products of the columns `i..i+A` with the columns `j..j+B`.
    #[inline(always)]
    fn tile<S: Simd, const A: usize, const B: usize>(&mut self, simd: S, i: usize, j: usize) {
        // Registers that hold the eight partial sums of one product.
        let step = LANES / S::F64_LANES;
        let n = self.rows / LANES * step;
        let mut left: [&[S::f64s]; A] = [&[]; A];
        for (a, left) in left.iter_mut().enumerate() {
            *left = &S::as_simd_f64s(self.column(i + a)).0[..n];
        }
        let mut right: [&[S::f64s]; B] = [&[]; B];
        for (b, right) in right.iter_mut().enumerate() {
            *right = &S::as_simd_f64s(self.column(j + b)).0[..n];
        }
        let mut lanes = [[[0.0; LANES]; A]; B];
        for part in 0..step {
            let mut sums = [[simd.splat_f64s(0.0); A]; B];
            let mut k = part;
            while k < n {
                for b in 0..B {
                    let y = right[b][k];
                    for a in 0..A {
                        sums[b][a] = simd.add_f64s(sums[b][a], simd.mul_f64s(left[a][k], y));
                    }
                }
                k += step;
            }
            for b in 0..B {
                for a in 0..A {
                    let (to, _) = S::as_mut_simd_f64s(&mut lanes[b][a]);
                    to[part] = sums[b][a];
                }
            }
        }
        let m = self.columns.len() / self.rows;
        let done = self.rows / LANES * LANES;
        for b in 0..B.min(m - j) {
            for a in 0..A.min(m.saturating_sub(i)) {
                if i + a <= j + b {
                    let mut tail = 0.0;
                    if done < self.rows {
                        let (x, y) = (self.column(i + a), self.column(j + b));
                        for (x, y) in x[done..].iter().zip(&y[done..]) {
                            tail += x * y;
                        }
                    }
                    let s = &lanes[b][a];
                    self.out[(j + b) * m + i + a] =
                        ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])) + tail;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition: eight partial sums, then the rows that are left over.
    fn dot(x: &[f64], y: &[f64]) -> f64 {
        let mut s = [0.0; LANES];
        let done = x.len() / LANES * LANES;
        for r in 0..done {
            s[r % LANES] += x[r] * y[r];
        }
        let tail = (done..x.len()).fold(0.0, |t, r| t + x[r] * y[r]);
        ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])) + tail
    }

    fn with<S: Simd>(simd: S, columns: &[f64], rows: usize, m: usize) -> Vec<f64> {
        let mut out = vec![0.0; m * m];
        let products = Products {
            columns,
            rows,
            out: &mut out,
        };
        simd.vectorize(products);
        out
    }

    proptest! {
        #[test]
        fn prop_every_register_width_gives_the_same_bits(
            rows in 0_usize..70,
            m in 1_usize..15,
            seed in 0_u32..1000,
        ) {
            let columns: Vec<f64> = (0..rows * m)
                .map(|i| (f64::from(seed) + 1.7 * i as f64).sin() * 1.01_f64.powi(i as i32))
                .collect();
            let mut best = vec![0.0; m * m];
            upper_products(&columns, rows, &mut best);
            // One lane on 16 registers; arrays of two, four and eight lanes.
            prop_assert_eq!(&best, &with(pulp::Scalar, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar128b, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar256b, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar512b, &columns, rows, m));
            for j in 0..m {
                for i in 0..=j {
                    let column = |c: usize| &columns[c * rows..(c + 1) * rows];
                    prop_assert_eq!(best[j * m + i], dot(column(i), column(j)));
                }
            }
        }
    }

    /// Wide vectors where the processor has them, beside the narrow ones that every processor has.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn prop_the_processors_own_vectors_give_the_same_bits() {
        let columns: Vec<f64> = (0..57 * 131).map(|i| (0.7 * f64::from(i)).sin()).collect();
        let narrow = with(pulp::Scalar, &columns, 131, 57);
        if let Some(simd) = pulp::x86::V3::try_new() {
            assert_eq!(with(simd, &columns, 131, 57), narrow);
        }
        if let Some(simd) = pulp::x86::V4::try_new() {
            assert_eq!(with(simd, &columns, 131, 57), narrow);
        }
    }

    #[test]
    fn analytic_sums() {
        let mut values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(sum(&values), 5050.0); // integers: exact
        assert_eq!(sum(&[]), 0.0);
        for bad in [0, 64, 99] {
            for v in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let kept = std::mem::replace(&mut values[bad], v);
                assert!(!sum(&values).is_finite());
                values[bad] = kept;
            }
        }
    }
}
