//! The products of pairs of columns, in whatever vector instructions the processor has.
//!
//! Each product is eight partial sums, [`Lanes`] (partial sum `k` takes the rows `r ≡ k` mod 8), each of which takes
//! its rows one after the other, without fused multiply-add. The width of the registers decides only how many partial
//! sums are carried at a time, and the size of a tile only how often a column is loaded: the result has the
//! same bits on every machine, and for rows that come in pieces, as long as all but the last have
//! a multiple of eight of them.

use pulp::{Arch, Simd, WithSimd};

pub(super) use crate::statistics::lanes::{LANES, Lanes, total};

/// Adds the products of all pairs of `m` columns of `rows` rows, one after the other in `columns`: that of the
/// columns `i <= j` to `out[place(i, j)]` with [`place`].
pub(super) fn all_products(columns: &[f64], rows: usize, out: &mut [Lanes]) {
    Arch::new().dispatch(All { columns, rows, out });
}

/// Adds the products that `runs` asks for, one after the other in `out`.
pub(super) fn some_products(
    columns: &[f64],
    rows: usize,
    runs: &[ColumnProducts],
    out: &mut [Lanes],
) {
    Arch::new().dispatch(Chosen {
        columns,
        rows,
        runs,
        out,
    });
}

/// One column, and the columns whose products with it are wanted.
#[derive(Clone, Debug)]
pub(super) struct ColumnProducts {
    pub(super) column: usize,
    pub(super) with: Vec<usize>,
}

/// Where [`all_products`] puts the product of the columns `i <= j`.
pub(super) fn place(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// The sum of all values in a fixed order, by 32 partial sums; not finite if one of them is not.
pub(super) fn sum(values: &[f64]) -> f64 {
    Arch::new().dispatch(Sum(values))
}

struct Sum<'a>(&'a [f64]);

impl WithSimd for Sum<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut partial = [0.0; 32];
        let chunks = self.0.chunks_exact(32);
        let mut tail = 0.0;
        for v in chunks.remainder() {
            tail += v;
        }
        for chunk in chunks {
            for k in 0..32 {
                partial[k] += chunk[k];
            }
        }
        let mut sum = 0.0;
        for s in partial {
            sum += s;
        }
        sum + tail
    }
}

struct All<'a> {
    columns: &'a [f64],
    rows: usize,
    out: &'a mut [Lanes],
}

impl WithSimd for All<'_> {
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

impl All<'_> {
    /// All tiles of A x B products that touch the upper triangle; the columns that are left over at the
    /// end are taken one by one.
    #[inline(always)]
    fn panels<S: Simd, const A: usize, const B: usize>(mut self, simd: S) {
        let m = self.columns.len().checked_div(self.rows).unwrap_or(0);
        let whole = m - m % B;
        for j in (0..whole).step_by(B) {
            for i in (0..j + B).step_by(A) {
                self.corner::<S, A, B>(simd, i, j);
            }
        }
        for j in whole..m {
            for i in (0..=j).step_by(8) {
                self.corner::<S, 8, 1>(simd, i, j);
            }
        }
    }

    /// The products of the columns `i..i+A` with the columns `j..j+B`, where they are in the upper triangle.
    #[inline(always)]
    fn corner<S: Simd, const A: usize, const B: usize>(&mut self, simd: S, i: usize, j: usize) {
        let last = self.columns.len() / self.rows - 1;
        let column = |c: usize| {
            let c = c.min(last);
            &self.columns[c * self.rows..(c + 1) * self.rows]
        };
        let mut left: [&[f64]; A] = [&[]; A];
        for (a, left) in left.iter_mut().enumerate() {
            *left = column(i + a);
        }
        let mut right: [&[f64]; B] = [&[]; B];
        for (b, right) in right.iter_mut().enumerate() {
            *right = column(j + b);
        }
        let mut sums = [[[0.0; LANES]; A]; B];
        let inside = |a: usize, b: usize| i + a <= j + b && j + b <= last;
        for b in 0..B {
            for a in 0..A {
                if inside(a, b) {
                    sums[b][a] = self.out[place(i + a, j + b)];
                }
            }
        }
        tile::<S, A, B>(simd, left, right, &mut sums);
        for b in 0..B {
            for a in 0..A {
                if inside(a, b) {
                    self.out[place(i + a, j + b)] = sums[b][a];
                }
            }
        }
    }
}

struct Chosen<'a> {
    columns: &'a [f64],
    rows: usize,
    runs: &'a [ColumnProducts],
    out: &'a mut [Lanes],
}

impl WithSimd for Chosen<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        const A: usize = 8;
        let column = |c: usize| &self.columns[c * self.rows..(c + 1) * self.rows];
        let mut out = self.out;
        for run in self.runs {
            let right = [column(run.column)];
            for with in run.with.chunks(A) {
                let mut left: [&[f64]; A] = [right[0]; A];
                for (left, &c) in left.iter_mut().zip(with) {
                    *left = column(c);
                }
                let (to, rest) = out.split_at_mut(with.len());
                if let Ok(to) = <&mut [Lanes; A]>::try_from(&mut *to) {
                    tile::<S, A, 1>(simd, left, right, std::array::from_mut(to));
                } else {
                    let mut sums = [[[0.0; LANES]; A]];
                    sums[0][..to.len()].copy_from_slice(to);
                    tile::<S, A, 1>(simd, left, right, &mut sums);
                    to.copy_from_slice(&sums[0][..to.len()]);
                }
                out = rest;
            }
        }
    }
}

/// Adds the products of A columns with B columns, all of one length.
#[inline(always)]
fn tile<S: Simd, const A: usize, const B: usize>(
    simd: S,
    left: [&[f64]; A],
    right: [&[f64]; B],
    lanes: &mut [[Lanes; A]; B],
) {
    let rows = right[0].len();
    // Registers that hold the eight partial sums of one product.
    let step = LANES / S::F64_LANES;
    let n = rows / LANES * step;
    let mut x: [&[S::f64s]; A] = [&[]; A];
    for (x, left) in x.iter_mut().zip(left) {
        *x = &S::as_simd_f64s(left).0[..n];
    }
    let mut y: [&[S::f64s]; B] = [&[]; B];
    for (y, right) in y.iter_mut().zip(right) {
        *y = &S::as_simd_f64s(right).0[..n];
    }
    for part in 0..step {
        let mut sums = [[simd.splat_f64s(0.0); A]; B];
        for b in 0..B {
            for a in 0..A {
                sums[b][a] = S::as_simd_f64s(&lanes[b][a]).0[part];
            }
        }
        let mut k = part;
        while k < n {
            for b in 0..B {
                let y = y[b][k];
                for a in 0..A {
                    sums[b][a] = simd.add_f64s(sums[b][a], simd.mul_f64s(x[a][k], y));
                }
            }
            k += step;
        }
        for b in 0..B {
            for a in 0..A {
                S::as_mut_simd_f64s(&mut lanes[b][a]).0[part] = sums[b][a];
            }
        }
    }
    // Rows that do not fill all lanes.
    for r in rows / LANES * LANES..rows {
        for b in 0..B {
            for a in 0..A {
                lanes[b][a][r % LANES] += left[a][r] * right[b][r];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition.
    fn dot(x: &[f64], y: &[f64]) -> f64 {
        let mut s = [0.0; LANES];
        for r in 0..x.len() {
            s[r % LANES] += x[r] * y[r];
        }
        total(&s)
    }

    fn with<S: Simd>(simd: S, columns: &[f64], rows: usize, m: usize) -> Vec<Lanes> {
        let mut out = vec![[0.0; LANES]; m * (m + 1) / 2];
        let all = All {
            columns,
            rows,
            out: &mut out,
        };
        simd.vectorize(all);
        out
    }

    fn some_with<S: Simd>(
        simd: S,
        columns: &[f64],
        rows: usize,
        runs: &[ColumnProducts],
    ) -> Vec<Lanes> {
        let mut out = vec![[0.0; LANES]; runs.iter().map(|r| r.with.len()).sum()];
        let chosen = Chosen {
            columns,
            rows,
            runs,
            out: &mut out,
        };
        simd.vectorize(chosen);
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
            let mut best = vec![[0.0; LANES]; m * (m + 1) / 2];
            all_products(&columns, rows, &mut best);
            // One lane on 16 registers; arrays of two, four and eight lanes.
            prop_assert_eq!(&best, &with(pulp::Scalar, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar128b, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar256b, &columns, rows, m));
            prop_assert_eq!(&best, &with(pulp::Scalar512b, &columns, rows, m));
            let column = |c: usize| &columns[c * rows..(c + 1) * rows];
            for j in 0..m {
                for i in 0..=j {
                    prop_assert_eq!(total(&best[place(i, j)]), dot(column(i), column(j)));
                }
            }
            // The same products asked for one by one.
            let run = |j: usize| ColumnProducts { column: j, with: (0..=j).collect() };
            let runs: Vec<ColumnProducts> = (0..m).map(run).collect();
            let mut some = vec![[0.0; LANES]; best.len()];
            some_products(&columns, rows, &runs, &mut some);
            prop_assert_eq!(&best, &some);
            prop_assert_eq!(&best, &some_with(pulp::Scalar, &columns, rows, &runs));
            prop_assert_eq!(&best, &some_with(pulp::Scalar256b, &columns, rows, &runs));
        }

        #[test]
        fn prop_pieces_give_the_same_bits(first in 0_usize..9, rest in 0_usize..40, m in 1_usize..9) {
            let n = 8 * first + rest;
            let value = |j: usize, r: usize| (1.7 * (j * 100 + r) as f64).sin();
            let piece = |rows: std::ops::Range<usize>| -> Vec<f64> {
                (0..m).flat_map(|j| rows.clone().map(move |r| value(j, r))).collect()
            };
            let mut whole = vec![[0.0; LANES]; m * (m + 1) / 2];
            let mut parts = whole.clone();
            all_products(&piece(0..n), n, &mut whole);
            all_products(&piece(0..8 * first), 8 * first, &mut parts);
            all_products(&piece(8 * first..n), rest, &mut parts);
            prop_assert_eq!(whole, parts);
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
