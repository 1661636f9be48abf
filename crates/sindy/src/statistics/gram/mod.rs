//! Sufficient statistics of linear regression: the Gram matrix and its companions.
//!
//! ```text
//! G = Θᵀ Θ   (p x p),   b = Θᵀ y   (p),   c = yᵀ y,   n
//! ```
//!
//! They are accumulated block by block, so `Θ` (n x p) is never stored; those of two data sets add, and
//! those of a part subtract, which makes cross-validation free.
//!
//! Where the library is so ill-conditioned that `G` loses it, [`tsqr`](crate::statistics::tsqr) adds a triangular factor
//! of `[Θ | y]`.
//!
//! The sums are taken in a fixed order, and with the vector instructions that the processor has: the result
//! has the same bits for any number of threads, any size of the blocks, and (as far as the terms themselves do) on any machine.

mod aligned;
mod check;
mod driver;
mod kernel;
mod pass;
pub(crate) mod plan;
mod stored;
mod sums;
pub(crate) mod weighted;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

pub use check::check;
pub use pass::Accumulate;

use crate::data::samples::BlockSource;
use crate::error::SindyError;
use crate::library::Library;
use crate::statistics::tsqr::Triangle;

/// The sums of the weights of the rows that were used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// `Σ w`.
    pub sum: f64,
    /// `Σ w²`.
    pub squares: f64,
}

/// Sufficient statistics for one target over `p` terms. With sample weights `w` all sums are weighted:
/// `Θᵀ W Θ`, `Θᵀ W y`, and so on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "stored::StoredGram", into = "stored::StoredGram")]
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
    /// Sums of the weights; `None` where every row has weight one.
    pub weights: Option<Weights>,
    /// The triangular factor of `[Θ | y]` where it was accumulated (see [`tsqr`](crate::statistics::tsqr)): least
    /// squares then keep twice the digits.
    pub triangle: Option<Triangle>,
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
            weights: None,
            triangle: None,
        }
    }

    /// Statistics of `target` over `library`, one for each group of `source`. Rows in which the target
    /// or a term is not finite are left out and counted. [`Accumulate`] does the same with weights or a
    /// triangular factor, and how the work is divided.
    ///
    /// # Errors
    /// A term or a target that names no column; a pass that failed ([`BlockSource::failure`]).
    pub fn accumulate(
        library: &Library,
        target: &str,
        source: &dyn BlockSource,
    ) -> Result<Vec<Self>, SindyError> {
        Accumulate::new(library, target).over(source)
    }

    /// As [`Gram::accumulate`], of several targets in one pass ([`Accumulate::targets`]): for each target, one
    /// for each group. Products of terms that are equal (`x·x³` and `x²·x²`) are summed once.
    ///
    /// # Errors
    /// As [`Gram::accumulate`].
    pub fn accumulate_targets(
        library: &Library,
        targets: &[&str],
        source: &dyn BlockSource,
    ) -> Result<Vec<Vec<Self>>, SindyError> {
        Accumulate::new(library, "").targets(targets, source)
    }

    /// Adds the statistics of another part of the data. The triangular factor remains if both have one
    /// (statistics without rows have no need of it).
    pub fn merge(&mut self, other: &Self) {
        self.merge_copies(other, 1.0);
    }

    /// Adds the statistics of `copies` copies of another part, a whole number.
    pub(crate) fn merge_copies(&mut self, other: &Self, copies: f64) {
        self.triangle = match (self.triangle.take(), &other.triangle) {
            (Some(mut own), Some(more)) => {
                own.merge_scaled(more, copies.sqrt());
                Some(own)
            }
            (own, _) if other.rows == 0 => own,
            (_, Some(more)) if self.rows == 0 => {
                let mut triangle = Triangle::new(self.xty.len());
                triangle.merge_scaled(more, copies.sqrt());
                Some(triangle)
            }
            _ => None,
        };
        self.weights = match (self.weights, other.weights) {
            (None, None) => None,
            _ => {
                let (own, more) = (self.weight_sums(), other.weight_sums());
                Some(Weights {
                    sum: own.sum + copies * more.sum,
                    squares: own.squares + copies * more.squares,
                })
            }
        };
        self.xtx.zip_apply(&other.xtx, |a, b| *a += copies * b);
        self.xty.axpy(copies, &other.xty, 1.0);
        self.yty += copies * other.yty;
        self.sum_y += copies * other.sum_y;
        self.rows += copies as usize * other.rows;
        self.skipped += copies as usize * other.skipped;
    }

    /// Takes the statistics of a part away again. The triangular factor is dropped: what remains of it after
    /// a subtraction has no more digits than the Gram matrix.
    pub fn downdate(&mut self, part: &Self) {
        if self.weights.is_some() || part.weights.is_some() {
            let (own, less) = (self.weight_sums(), part.weight_sums());
            self.weights = Some(Weights {
                sum: own.sum - less.sum,
                squares: own.squares - less.squares,
            });
        }
        self.triangle = None;
        self.xtx -= &part.xtx;
        self.xty -= &part.xty;
        self.yty -= part.yty;
        self.sum_y -= part.sum_y;
        self.rows -= part.rows;
        self.skipped -= part.skipped;
    }

    fn weight_sums(&self) -> Weights {
        let n = self.rows as f64;
        self.weights.unwrap_or(Weights { sum: n, squares: n })
    }

    /// `Σ w`: what the sums are to be divided by to make means. The number of rows where there are no weights.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.weight_sums().sum
    }

    /// Rows of equal weight that hold as much information: `(Σ w)² / Σ w²` (L. Kish, "Survey Sampling", 1965). The number of
    /// rows where there are no weights.
    #[must_use]
    pub fn effective_rows(&self) -> f64 {
        let Weights { sum, squares } = self.weight_sums();
        if squares > 0.0 {
            sum * (sum / squares)
        } else {
            0.0
        }
    }

    /// Condition of `Θ` with columns of unit length, over the terms that are not zero throughout: the ratio of
    /// its largest to its smallest singular value. From the triangular factor where there is one, up to about
    /// 10¹⁵; else from the Gram matrix, in which a condition above about 10⁷ drowns in rounding: what is
    /// returned then is infinite, or any number above 10⁷.
    #[must_use]
    pub fn condition(&self) -> f64 {
        if let Some(triangle) = &self.triangle {
            return triangle.condition();
        }
        let live: Vec<usize> = (0..self.xty.len())
            .filter(|&j| self.xtx[(j, j)] > 0.0)
            .collect();
        if live.is_empty() {
            return 1.0;
        }
        let length: Vec<f64> = live.iter().map(|&j| self.xtx[(j, j)].sqrt()).collect();
        let k = live.len();
        let eigen = DMatrix::from_fn(k, k, |a, b| {
            self.xtx[(live[a], live[b])] / length[a] / length[b]
        })
        .symmetric_eigenvalues();
        let (largest, smallest) = (eigen.max(), eigen.min());
        if smallest > 0.0 {
            (largest / smallest).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// The sum of several parts.
    #[must_use]
    pub fn total(parts: &[Self]) -> Self {
        let mut all = Self::zeros(parts.first().map_or(0, |g| g.xty.len()));
        parts.iter().for_each(|g| all.merge(g));
        all
    }

    fn divisor(&self) -> f64 {
        let n = self.weight();
        if n > 0.0 { n } else { 1.0 }
    }

    /// Root mean square of each column of `Θ`; 1 for a column that is zero throughout.
    #[must_use]
    pub fn column_rms(&self) -> DVector<f64> {
        let n = self.divisor();
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
        let rms = (self.yty / self.divisor()).sqrt();
        if rms > 0.0 { rms } else { 1.0 }
    }

    /// Residual sum of squares `|y - Θ ξ|²` of given coefficients.
    #[must_use]
    pub fn residual_sum(&self, coefficients: &DVector<f64>) -> f64 {
        if let Some(triangle) = &self.triangle {
            return triangle.residual_sum(coefficients);
        }
        let quadratic = coefficients.dot(&(&self.xtx * coefficients));
        let sum = self.yty - 2.0 * coefficients.dot(&self.xty) + quadratic;
        // NaN stays NaN: coefficients that are not numbers are no perfect fit.
        if sum < 0.0 { 0.0 } else { sum }
    }

    /// Coefficient of determination of given coefficients, against the target's mean.
    #[must_use]
    pub fn r_squared(&self, coefficients: &DVector<f64>) -> f64 {
        let n = self.divisor();
        1.0 - self.residual_sum(coefficients) / (self.yty - self.sum_y * self.sum_y / n)
    }
}

#[cfg(test)]
mod tests;
