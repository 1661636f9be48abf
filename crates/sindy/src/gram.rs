//! Sufficient statistics of linear regression: the Gram matrix and its companions.
//!
//! ```text
//! G = Θᵀ Θ   (p x p),   b = Θᵀ y   (p),   c = yᵀ y,   n
//! ```
//!
//! They are accumulated block by block, so `Θ` (n x p) is never stored; those of two data sets add, and
//! those of a part subtract, which makes cross-validation free.

use nalgebra::{DMatrix, DVector};
use sindy_expr::Scratch;

use crate::error::SindyError;
use crate::library::Library;
use crate::samples::{BlockSource, position};

/// Rows that are evaluated at a time: 256 rows of 60 terms fit the second-level cache.
const CHUNK: usize = 256;

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
        let mut scratch = Scratch::default();
        let mut theta = vec![0.0; CHUNK * p];
        let mut y = [0.0; CHUNK];
        source.for_each_block(&mut |block| {
            let n = block.columns.first().map_or(0, |c| c.len());
            for start in (0..n).step_by(CHUNK) {
                let rows = CHUNK.min(n - start);
                let part: Vec<&[f64]> = block
                    .columns
                    .iter()
                    .map(|c| &c[start..start + rows])
                    .collect();
                let theta = &mut theta[..rows * p];
                program.eval_block(&part, theta, &mut scratch);
                y[..rows].copy_from_slice(part[target]);
                grams[block.group].add_chunk(theta, &mut y[..rows]);
            }
        });
        for gram in &mut grams {
            gram.xtx.fill_lower_triangle_with_upper_triangle();
        }
        Ok(grams)
    }

    /// Adds a chunk given as columns; rows with a non-finite entry are zeroed and counted.
    fn add_chunk(&mut self, theta: &mut [f64], y: &mut [f64]) {
        let rows = y.len();
        let p = self.xty.len();
        let mut used = rows;
        if !(theta.iter().sum::<f64>() + y.iter().sum::<f64>()).is_finite() {
            for r in 0..rows {
                if !y[r].is_finite() || (0..p).any(|j| !theta[j * rows + r].is_finite()) {
                    y[r] = 0.0;
                    (0..p).for_each(|j| theta[j * rows + r] = 0.0);
                    used -= 1;
                }
            }
        }
        for j in 0..p {
            let cj = &theta[j * rows..(j + 1) * rows];
            for i in 0..=j {
                self.xtx[(i, j)] += dot(&theta[i * rows..(i + 1) * rows], cj);
            }
            self.xty[j] += dot(cj, y);
        }
        self.yty += dot(y, y);
        self.sum_y += y.iter().sum::<f64>();
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

/// Dot product with eight partial sums, so that it runs in vector registers in a fixed order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut s = [0.0; 8];
    let (ac, bc) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ac
        .remainder()
        .iter()
        .zip(bc.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in ac.zip(bc) {
        for k in 0..8 {
            s[k] += x[k] * y[k];
        }
    }
    ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])) + tail
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
