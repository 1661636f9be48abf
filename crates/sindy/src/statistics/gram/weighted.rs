//! Statistics under many sets of integer row weights at once, in one pass.
//!
//! ```text
//! G_b = Σ_r w_br θ_r θ_rᵀ     for replicates b
//! ```
//!
//! For a chunk of rows the different products `q_k = θ_i θ_j` are formed once and multiplied by the matrix of
//! weights. Each sum takes its rows one after the other, without fused multiply-add: it has the same bits for any
//! register width.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::Gram;
use super::plan::{CHUNK, Plan};
use super::sums::{Sums, Workspace};

/// Replicates whose weights are held together: four registers of the widest kind.
pub(crate) const PANEL: usize = 32;

/// Products that are multiplied by the weights at a time.
const TILE: usize = 4;

/// The sums of up to [`PANEL`] replicates.
pub(crate) struct Panel {
    /// `sums[k * PANEL + b]`: the products, then the targets.
    sums: Vec<f64>,
    rows: [f64; PANEL],
    skipped: [f64; PANEL],
    work: Workspace,
    /// `weights[r * PANEL + b]` of one chunk.
    weights: Vec<f64>,
}

impl Panel {
    pub(crate) fn new(plan: &Plan) -> Self {
        Self {
            sums: vec![0.0; plan.factors().len() * PANEL],
            rows: [0.0; PANEL],
            skipped: [0.0; PANEL],
            work: Workspace::default(),
            weights: vec![0.0; CHUNK * PANEL],
        }
    }

    /// Adds the rows `range`, chunk by chunk; `fill` sets the weights of the rows of a chunk, which are zero
    /// before. Rows that are not finite are dropped and counted.
    pub(crate) fn add_rows(
        &mut self,
        plan: &Plan,
        columns: &[&[f64]],
        range: Range<usize>,
        mut fill: impl FnMut(usize, &mut [f64]),
    ) {
        for start in range.clone().step_by(plan.chunk()) {
            let rows = plan.chunk().min(range.end - start);
            let weights = &mut self.weights[..rows * PANEL];
            weights.fill(0.0);
            fill(rows, weights);
            self.work.load(plan, columns, start..start + rows);
            self.work.clear_bad_rows(rows, |r| {
                for (b, w) in weights[r * PANEL..][..PANEL].iter_mut().enumerate() {
                    self.skipped[b] += *w;
                    *w = 0.0;
                }
            });
            for row in weights.chunks_exact(PANEL) {
                for (total, w) in self.rows.iter_mut().zip(row) {
                    *total += w;
                }
            }
            Arch::new().dispatch(Multiply {
                columns: self.work.columns(),
                rows,
                factors: plan.factors(),
                weights,
                sums: &mut self.sums,
            });
        }
    }

    /// The statistics of each target in replicate `b`.
    pub(crate) fn grams(&self, plan: &Plan, b: usize) -> Vec<Gram> {
        let sums: Vec<f64> = self.sums.chunks_exact(PANEL).map(|k| k[b]).collect();
        Sums::from_parts(plan, &sums, self.rows[b] as usize, self.skipped[b] as usize).grams(plan)
    }
}

/// `sums[k, b] += Σ_r q_k[r] weights[r, b]` over one chunk.
struct Multiply<'a> {
    columns: &'a [f64],
    rows: usize,
    factors: &'a [(usize, Option<usize>)],
    weights: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::REGISTER_COUNT >= 32 {
            self.tiles::<S, 4>(simd);
        } else {
            self.tiles::<S, 2>(simd);
        }
    }
}

impl Multiply<'_> {
    #[inline(always)]
    fn tiles<S: Simd, const B: usize>(self, simd: S) {
        let column = |c: usize| &self.columns[c * self.rows..(c + 1) * self.rows];
        let mut q = [[0.0; CHUNK]; TILE];
        let sums = self.sums.chunks_mut(TILE * PANEL);
        for (factors, sums) in self.factors.chunks(TILE).zip(sums) {
            for (q, &(i, j)) in q.iter_mut().zip(factors) {
                match j {
                    None => q[..self.rows].copy_from_slice(column(i)),
                    Some(j) => {
                        for ((q, x), y) in q.iter_mut().zip(column(i)).zip(column(j)) {
                            *q = x * y;
                        }
                    }
                }
            }
            let q: [&[f64]; TILE] = std::array::from_fn(|a| &q[a][..self.rows]);
            let width = B * S::F64_LANES;
            for from in (0..PANEL).step_by(width) {
                let mut acc = [[simd.splat_f64s(0.0); B]; TILE];
                for r in 0..self.rows {
                    let at = r * PANEL + from;
                    let w = S::as_simd_f64s(&self.weights[at..at + width]).0;
                    let w: [S::f64s; B] = std::array::from_fn(|b| w[b]);
                    for a in 0..TILE {
                        let x = simd.splat_f64s(q[a][r]);
                        for b in 0..B {
                            acc[a][b] = simd.add_f64s(acc[a][b], simd.mul_f64s(x, w[b]));
                        }
                    }
                }
                for (acc, sums) in acc.iter().zip(sums.chunks_exact_mut(PANEL)) {
                    let to = S::as_mut_simd_f64s(&mut sums[from..from + width]).0;
                    for (to, acc) in to.iter_mut().zip(acc) {
                        *to = simd.add_f64s(*to, *acc);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Library, Samples};

    fn with<S: Simd>(
        simd: S,
        columns: &[f64],
        rows: usize,
        factors: &[(usize, Option<usize>)],
        weights: &[f64],
    ) -> Vec<f64> {
        let mut sums = vec![1.0; factors.len() * PANEL];
        simd.vectorize(Multiply {
            columns,
            rows,
            factors,
            weights,
            sums: &mut sums,
        });
        sums
    }

    #[test]
    fn prop_every_register_width_gives_the_same_bits() {
        for rows in [1, 7, 200, CHUNK] {
            let columns: Vec<f64> = (0..5 * rows).map(|i| (0.7 * i as f64).sin()).collect();
            let weights: Vec<f64> = (0..rows * PANEL).map(|i| (i * i % 7 % 3) as f64).collect();
            let factors: Vec<(usize, Option<usize>)> = (0..5)
                .flat_map(|j| (0..=j).map(move |i| (i, Some(j))))
                .chain([(3, None), (4, None)])
                .collect();
            let one = with(pulp::Scalar, &columns, rows, &factors, &weights);
            assert_eq!(
                one,
                with(pulp::Scalar128b, &columns, rows, &factors, &weights)
            );
            assert_eq!(
                one,
                with(pulp::Scalar256b, &columns, rows, &factors, &weights)
            );
            assert_eq!(
                one,
                with(pulp::Scalar512b, &columns, rows, &factors, &weights)
            );
            #[cfg(target_arch = "x86_64")]
            {
                if let Some(simd) = pulp::x86::V3::try_new() {
                    assert_eq!(one, with(simd, &columns, rows, &factors, &weights));
                }
                if let Some(simd) = pulp::x86::V4::try_new() {
                    assert_eq!(one, with(simd, &columns, rows, &factors, &weights));
                }
            }
            for (k, &(i, j)) in factors.iter().enumerate() {
                for b in [0, 13, 31] {
                    let mut sum = 0.0;
                    for r in 0..rows {
                        let q = columns[i * rows + r] * j.map_or(1.0, |j| columns[j * rows + r]);
                        sum += q * weights[r * PANEL + b];
                    }
                    assert_eq!(one[k * PANEL + b], 1.0 + sum);
                }
            }
        }
    }

    #[test]
    fn prop_weights_count_rows_as_often_as_they_say() {
        let n = 1000;
        let column = |w: f64| -> Vec<f64> { (0..n).map(|i| (w * f64::from(i)).sin()).collect() };
        let mut columns = [0.37, 0.91, 1.3].map(column);
        columns[0][500] = f64::NAN;
        let weight = |r: usize, b: usize| (r * (b + 3)) % 5 % 3;
        let library = Library::parse(&["1", "x", "y", "x^2", "x*y", "y^2"]).unwrap();
        let names = ["x", "y", "z"].map(String::from);
        let plan = Plan::new(&library, &["z", "y"], &names).unwrap();
        let mut panel = Panel::new(&plan);
        let parts: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let mut done = 0;
        panel.add_rows(&plan, &parts, 0..1000, |rows, weights| {
            for r in 0..rows {
                for b in 0..PANEL {
                    weights[r * PANEL + b] = weight(done + r, b) as f64;
                }
            }
            done += rows;
        });
        for b in [0, 30] {
            let repeated = |c: &Vec<f64>| -> Vec<f64> {
                (0..1000)
                    .flat_map(|r| std::iter::repeat_n(c[r], weight(r, b)))
                    .collect()
            };
            let mut samples = Samples::new(&["x", "y", "z"]);
            samples
                .push_group(columns.iter().map(repeated).collect())
                .unwrap();
            let expected = Gram::accumulate_targets(&library, &["z", "y"], &samples).unwrap();
            for (gram, expected) in panel.grams(&plan, b).iter().zip(&expected) {
                let expected = &expected[0];
                // Sums of some 1000 numbers below one in another order.
                assert!((&gram.xtx - &expected.xtx).amax() < 1e-11);
                assert!((&gram.xty - &expected.xty).amax() < 1e-11);
                assert!((gram.yty - expected.yty).abs() < 1e-11);
                assert!((gram.sum_y - expected.sum_y).abs() < 1e-11);
                assert_eq!((gram.rows, gram.skipped), (expected.rows, expected.skipped));
            }
        }
    }
}
