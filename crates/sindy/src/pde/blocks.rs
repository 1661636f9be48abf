//! How much the scores of terms scatter between distant parts of the grid: errors for a residual that is not white noise.
//!
//! ```text
//! Cov Σ_k θ_k r_k  ≈  G/(G - 1) Σ_b (s_b - n_b s̄)(s_b - n_b s̄)ᵀ,     s_b = Σ_{k in block b} θ_k r_k
//! ```
//!
//! over G blocks of `n_b` windows, with `s̄` the mean of the scores of a window. Noise with memory, heavy tails and terms that
//! are not in the library all show in it, as far as they are forgotten within a block.
//!
//! Source: K.-Y. Liang, S. L. Zeger, "Longitudinal data analysis using generalized linear models", Biometrika 73 (1986).

use nalgebra::{DMatrix, DVector};

use super::system::WeakField;

/// Sums over the windows of a block.
struct Block {
    windows: f64,
    scores: DVector<f64>,
}

/// The covariance of scores from their scatter between blocks.
pub(super) struct BlockCovariance {
    pub(super) covariance: DMatrix<f64>,
    /// Blocks less one.
    pub(super) degrees: f64,
}

impl BlockCovariance {
    /// Of the scores of `terms` with `residual`, quantities and their coefficients; `None` where there is one block only.
    pub(super) fn new(
        data: &[WeakField<'_>],
        terms: &[usize],
        residual: &[(usize, f64)],
    ) -> Option<Self> {
        let blocks: Vec<Block> = data
            .iter()
            .flat_map(|d| of_field(d, terms, residual))
            .filter(|b| b.windows > 0.0)
            .collect();
        let count = blocks.len() as f64;
        if count < 2.0 {
            return None;
        }
        let windows: f64 = blocks.iter().map(|b| b.windows).sum();
        let sum = blocks
            .iter()
            .fold(DVector::zeros(terms.len()), |sum, b| sum + &b.scores);
        // Of coefficients without the bias of noise the sum of scores is that bias, not 0.
        let mean = sum / windows;
        let mut covariance = DMatrix::zeros(terms.len(), terms.len());
        for block in &blocks {
            let own = &block.scores - &mean * block.windows;
            covariance += &own * own.transpose();
        }
        Some(Self {
            covariance: covariance * (count / (count - 1.0)),
            degrees: count - 1.0,
        })
    }
}

fn of_field(data: &WeakField<'_>, terms: &[usize], residual: &[(usize, f64)]) -> Vec<Block> {
    let axes: Vec<(usize, usize)> = data
        .windows
        .iter()
        .map(|w| (w.count, number(w.count as f64 * w.independent())))
        .collect();
    let all = axes.iter().map(|a| a.1).product();
    let empty = || Block {
        windows: 0.0,
        scores: DVector::zeros(terms.len()),
    };
    let mut blocks: Vec<Block> = (0..all).map(|_| empty()).collect();
    for k in 0..data.columns[residual[0].0].len() {
        let left: f64 = residual.iter().map(|(l, c)| c * data.columns[*l][k]).sum();
        if !left.is_finite() {
            continue;
        }
        let (mut rest, mut place, mut stride) = (k, 0, 1);
        for (windows, blocks) in axes.iter().rev() {
            place += stride * (rest % windows * blocks / windows);
            rest /= windows;
            stride *= blocks;
        }
        let block = &mut blocks[place];
        block.windows += 1.0;
        for (score, &j) in block.scores.iter_mut().zip(terms) {
            *score += data.columns[j][k] * left;
        }
    }
    blocks
}

/// Blocks along an axis: as many as each has independent windows, so that longer data give more blocks and longer ones.
fn number(independent: f64) -> usize {
    (independent.sqrt().round() as usize).max(1)
}
