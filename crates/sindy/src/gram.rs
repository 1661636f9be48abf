//! Sufficient statistics of linear regression: the Gram matrix and its companions.
//!
//! ```text
//! G = Θᵀ Θ   (p x p),   b = Θᵀ y   (p),   c = yᵀ y,   n
//! ```
//!
//! They are accumulated block by block, so `Θ` (n x p) is never stored; those of two data sets add, and
//! those of a part subtract, which makes cross-validation free.
//!
//! The sums are taken in a fixed order, and with the vector instructions that the processor has: the result
//! has the same bits for any number of threads and (as far as the terms themselves do) on any machine.

mod kernel;

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sindy_expr::{Program, Scratch};

use crate::error::SindyError;
use crate::library::Library;
use crate::samples::{BlockSource, position};

/// Rows that are evaluated at a time: 256 rows of 60 terms fit the second-level cache.
const CHUNK: usize = 256;

/// Rows of a block that one thread takes at a time, and the next after it; a multiple of [`CHUNK`].
const SEGMENT: usize = 8192;

/// Segments whose statistics are held at a time.
const WAVE: usize = 64;

/// Sufficient statistics for one target over `p` terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Gram {
    /// `Θᵀ Θ`, p x p.
    pub xtx: DMatrix<f64>,
    /// `Θᵀ y`, p.
    pub xty: DVector<f64>,
    /// `yᵀ y`.
    pub yty: f64,
    /// `Σ y`, for the variance of the target.
    pub sum_y: f64,
    /// Rows that were used.
    pub rows: usize,
    /// Rows that were left out because a term or the target was not finite.
    pub skipped: usize,
}

impl Gram {
    /// Empty statistics over `p` terms.
    #[must_use]
    pub fn zeros(p: usize) -> Self {
        Self {
            xtx: DMatrix::zeros(p, p),
            xty: DVector::zeros(p),
            yty: 0.0,
            sum_y: 0.0,
            rows: 0,
            skipped: 0,
        }
    }

    /// Statistics of `target` over `library`, one for each group of `source`. Rows in which the target
    /// or a term is not finite are left out and counted.
    ///
    /// Blocks of more than 8192 rows are shared out among the threads of the current `rayon` pool; smaller
    /// ones are not worth it and run on the calling thread. The result does not depend on the number of
    /// threads.
    ///
    /// # Errors
    /// A term or a target that names no column.
    pub fn accumulate(
        library: &Library,
        target: &str,
        source: &dyn BlockSource,
    ) -> Result<Vec<Self>, SindyError> {
        let program = library.compile(source.names())?;
        let target = position(source.names(), target)?;
        let p = library.len();
        let mut grams = vec![Self::zeros(p); source.groups()];
        let mut work = Workspace::new(p);
        source.for_each_block(&mut |block| {
            let n = block.columns.first().map_or(0, |c| c.len());
            let gram = &mut grams[block.group];
            if n <= SEGMENT {
                gram.add_rows(&program, target, block.columns, 0..n, &mut work);
                return;
            }
            let segments: Vec<usize> = (0..n).step_by(SEGMENT).collect();
            for wave in segments.chunks(WAVE) {
                let parts: Vec<Self> = wave
                    .par_iter()
                    .map_init(
                        || Workspace::new(p),
                        |work, &start| {
                            let rows = start..n.min(start + SEGMENT);
                            let mut part = Self::zeros(p);
                            part.add_rows(&program, target, block.columns, rows, work);
                            part
                        },
                    )
                    .collect();
                parts.iter().for_each(|part| gram.merge(part));
            }
        });
        for gram in &mut grams {
            gram.xtx.fill_lower_triangle_with_upper_triangle();
        }
        Ok(grams)
    }

    /// Evaluates the given rows and adds them, chunk by chunk, to the upper triangle.
    fn add_rows(
        &mut self,
        program: &Program,
        target: usize,
        columns: &[&[f64]],
        range: Range<usize>,
        work: &mut Workspace,
    ) {
        let p = self.xty.len();
        for start in range.clone().step_by(CHUNK) {
            let rows = CHUNK.min(range.end - start);
            let part: Vec<&[f64]> = columns.iter().map(|c| &c[start..start + rows]).collect();
            let (theta, y) = work.columns[..rows * (p + 1)].split_at_mut(rows * p);
            program.eval_block(&part, theta, &mut work.scratch);
            y.copy_from_slice(part[target]);
            self.add_chunk(
                &mut work.columns[..rows * (p + 1)],
                rows,
                &mut work.products,
            );
        }
    }

    /// Adds a chunk given as columns, the target the last of them; rows with a non-finite entry are zeroed
    /// and counted.
    fn add_chunk(&mut self, columns: &mut [f64], rows: usize, products: &mut [f64]) {
        let p = self.xty.len();
        let mut used = rows;
        if !kernel::sum(columns).is_finite() {
            for r in 0..rows {
                if (0..=p).any(|j| !columns[j * rows + r].is_finite()) {
                    (0..=p).for_each(|j| columns[j * rows + r] = 0.0);
                    used -= 1;
                }
            }
        }
        kernel::upper_products(columns, rows, products);
        for (j, column) in products.chunks_exact(p + 1).enumerate().take(p) {
            let mut to = self.xtx.column_mut(j);
            for (to, product) in to.iter_mut().zip(&column[..=j]) {
                *to += product;
            }
        }
        let last = &products[p * (p + 1)..];
        for (to, product) in self.xty.iter_mut().zip(last) {
            *to += product;
        }
        self.yty += last[p];
        self.sum_y += kernel::sum(&columns[rows * p..]);
        self.rows += used;
        self.skipped += rows - used;
    }

    /// Adds the statistics of another part of the data.
    pub fn merge(&mut self, other: &Self) {
        self.xtx += &other.xtx;
        self.xty += &other.xty;
        self.yty += other.yty;
        self.sum_y += other.sum_y;
        self.rows += other.rows;
        self.skipped += other.skipped;
    }

    /// Takes the statistics of a part away again.
    pub fn downdate(&mut self, part: &Self) {
        self.xtx -= &part.xtx;
        self.xty -= &part.xty;
        self.yty -= part.yty;
        self.sum_y -= part.sum_y;
        self.rows -= part.rows;
        self.skipped -= part.skipped;
    }

    /// The sum of several parts.
    #[must_use]
    pub fn total(parts: &[Self]) -> Self {
        let mut all = Self::zeros(parts.first().map_or(0, |g| g.xty.len()));
        parts.iter().for_each(|g| all.merge(g));
        all
    }

    /// Root mean square of each column of `Θ`; 1 for a column that is zero throughout.
    #[must_use]
    pub fn column_rms(&self) -> DVector<f64> {
        let n = self.rows.max(1) as f64;
        DVector::from_iterator(
            self.xty.len(),
            self.xtx
                .diagonal()
                .iter()
                .map(|g| if *g > 0.0 { (g / n).sqrt() } else { 1.0 }),
        )
    }

    /// Root mean square of the target (1 where it is zero throughout).
    #[must_use]
    pub fn target_rms(&self) -> f64 {
        let rms = (self.yty / self.rows.max(1) as f64).sqrt();
        if rms > 0.0 { rms } else { 1.0 }
    }

    /// Residual sum of squares `|y - Θ ξ|²` of given coefficients.
    #[must_use]
    pub fn residual_sum(&self, coefficients: &DVector<f64>) -> f64 {
        let quadratic = coefficients.dot(&(&self.xtx * coefficients));
        (self.yty - 2.0 * coefficients.dot(&self.xty) + quadratic).max(0.0)
    }

    /// Coefficient of determination of given coefficients, against the target's mean.
    #[must_use]
    pub fn r_squared(&self, coefficients: &DVector<f64>) -> f64 {
        let n = self.rows.max(1) as f64;
        1.0 - self.residual_sum(coefficients) / (self.yty - self.sum_y * self.sum_y / n)
    }
}

/// What one thread needs to add rows.
struct Workspace {
    scratch: Scratch,
    /// The terms and the target of one chunk, column after column.
    columns: Vec<f64>,
    /// Their products, (p+1) x (p+1); the upper triangle is used.
    products: Vec<f64>,
}

impl Workspace {
    fn new(p: usize) -> Self {
        Self {
            scratch: Scratch::default(),
            columns: vec![0.0; CHUNK * (p + 1)],
            products: vec![0.0; (p + 1) * (p + 1)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;
    use proptest::prelude::*;

    fn three_groups() -> (Library, Vec<Gram>, Samples) {
        let mut samples = Samples::new(&["x", "y"]);
        for g in 0..3 {
            let x: Vec<f64> = (0..700)
                .map(|i| (0.37 * f64::from(i) + f64::from(g)).sin())
                .collect();
            let y = x.iter().map(|x| 1.0 - 2.0 * x + 0.5 * x * x).collect();
            samples.push_group(vec![x, y]).unwrap();
        }
        let library = Library::parse(&["1", "x", "x^2"]).unwrap();
        let grams = Gram::accumulate(&library, "y", &samples).unwrap();
        (library, grams, samples)
    }

    #[test]
    fn analytic_entries_are_the_sums() {
        let (_, grams, samples) = three_groups();
        let x = &samples.group(1)[0];
        let power = |k: i32| x.iter().map(|v| v.powi(k)).sum::<f64>();
        for i in 0..3 {
            for j in 0..3 {
                // Sums of 700 numbers below one in another order: rounding only.
                assert!((grams[1].xtx[(i, j)] - power((i + j) as i32)).abs() < 1e-11);
            }
        }
        let residual = grams[1].residual_sum(&DVector::from_vec(vec![1.0, -2.0, 0.5]));
        // The target is in the library's span; the sums cancel to rounding of numbers of order 1000.
        assert!(residual < 1e-9, "{residual}");
        assert!(grams[1].r_squared(&DVector::from_vec(vec![1.0, -2.0, 0.5])) > 1.0 - 1e-9);
    }

    #[test]
    fn analytic_downdating_undoes_merging() {
        let (_, grams, _) = three_groups();
        let mut all = Gram::total(&grams);
        assert_eq!(all.rows, 2100);
        all.downdate(&grams[2]);
        let two = Gram::total(&grams[..2]);
        // One addition and one subtraction of entries of order 1000.
        assert!((&all.xtx - &two.xtx).amax() < 1e-10 && (&all.xty - &two.xty).amax() < 1e-10);
        assert_eq!(all.rows, two.rows);
    }

    #[test]
    fn prop_rows_that_are_not_finite_are_left_out_and_counted() {
        let library = Library::parse(&["1", "log(x)"]).unwrap();
        let mut samples = Samples::new(&["x", "y"]);
        samples
            .push_group(vec![
                vec![1.0, -1.0, 2.0, f64::NAN, 3.0],
                vec![1.0, 1.0, f64::INFINITY, 1.0, 2.0],
            ])
            .unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        assert_eq!((gram.rows, gram.skipped), (2, 3));
        assert_eq!(gram.xtx[(0, 0)], 2.0);
        assert_eq!(gram.xty[0], 3.0);
    }

    #[test]
    fn prop_the_number_of_threads_changes_nothing() {
        let n = 70 * SEGMENT + 1234; // more than one wave, and a ragged end
        let mut x: Vec<f64> = (0..n).map(|i| (1e-3 * i as f64).sin()).collect();
        let y: Vec<f64> = x.iter().map(|x| 1.0 / (2.0 + x)).collect();
        x[3 * SEGMENT + 7] = f64::NAN;
        let mut samples = Samples::new(&["x", "y"]);
        samples.push_group(vec![x, y]).unwrap();
        let library = Library::parse(&["1", "x", "x^2"]).unwrap();
        let [one, two, five] = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| Gram::accumulate(&library, "y", &samples).unwrap())
        });
        assert_eq!(one, two);
        assert_eq!(one, five);
        assert_eq!((one[0].rows, one[0].skipped), (n - 1, 1));
        assert_eq!(one[0].xtx[(0, 0)], (n - 1) as f64);
        let [x, _] = samples.group(0) else {
            unreachable!("two columns")
        };
        let sum: f64 = x.iter().filter(|x| x.is_finite()).sum();
        // 600 000 numbers below one, summed in another order: far below 1e-12 of their number.
        assert!((one[0].xtx[(0, 1)] - sum).abs() < 1e-12 * n as f64);
    }

    proptest! {
        #[test]
        fn prop_any_numbers_give_finite_statistics(
            x in prop::collection::vec(prop::num::f64::ANY, 0..600),
        ) {
            let library = Library::parse(&["1", "x"]).unwrap();
            let mut samples = Samples::new(&["x"]);
            // Squares of more than 1e150 overflow: those rows are not asked about here.
            let x: Vec<f64> = x.into_iter().filter(|v| !(v.is_finite() && v.abs() > 1e150)).collect();
            let finite = x.iter().filter(|v| v.is_finite()).count();
            samples.push_group(vec![x]).unwrap();
            let gram = Gram::total(&Gram::accumulate(&library, "x", &samples).unwrap());
            prop_assert_eq!(gram.rows, finite);
            prop_assert!(gram.xtx.iter().all(|v| v.is_finite()));
        }
    }
}
