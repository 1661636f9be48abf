//! Whether chains have converged: split R̂ and effective sample size.
//!
//! Draws are replaced by the normal quantiles of their ranks over all chains, so that both hold for tails of any weight. Each
//! chain is split in halves. With n draws in each of m halves, the mean W of their variances, the variance B/n of their
//! means and `V = (n-1)/n W + B/n`,
//!
//! ```text
//! R̂ = √(V/W),   ρ_t = 1 - (W - mean autocovariance at lag t)/V,   ESS = m n / (-1 + 2 Σ_k P_k),   P_k = ρ_2k + ρ_2k+1
//! ```
//!
//! The sum ends before the first P_k that is negative, whose ρ_2k counts once if it is positive (as in Stan). No P_k counts more
//! than the one before.
//!
//! Sources: A. Vehtari, A. Gelman, D. Simpson, B. Carpenter, P.-C. Bürkner, "Rank-normalization, folding, and localization: an
//! improved R̂", Bayesian Analysis 16 (2021); C. J. Geyer, Statistical Science 7 (1992), for the end of the sum.

use statrs::distribution::{ContinuousCDF, Normal};

/// R̂ from which on chains have not converged (Vehtari et al., section 4).
pub(super) const MOST_R_HAT: f64 = 1.01;

/// Effective sample size that each chain has to contribute (Vehtari et al., section 4: 50 for each half).
pub(super) const FEWEST_EFFECTIVE_A_CHAIN: f64 = 100.0;

/// Fewest draws of a chain whose halves have a variance.
const FEWEST_DRAWS: usize = 4;

/// How well the draws of one quantity agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagnostic {
    /// Split R̂ of the ranks: 1 where all chains have the same distribution. NaN with fewer than four draws in a chain.
    pub r_hat: f64,
    /// Effective sample size of the ranks: independent draws that would be worth as much. NaN with fewer than four draws.
    pub effective_draws: f64,
}

impl Diagnostic {
    /// Of draws of `chains` chains of the same length, one after the other.
    pub(super) fn of(draws: &[f64], chains: usize) -> Self {
        let length = draws.len() / chains;
        if length < FEWEST_DRAWS {
            return Self {
                r_hat: f64::NAN,
                effective_draws: f64::NAN,
            };
        }
        let half = length / 2;
        // Of an odd number of draws the one in the middle is left out.
        let split: Vec<f64> = draws
            .chunks_exact(length)
            .flat_map(|chain| [&chain[..half], &chain[length - half..]].concat())
            .collect();
        let ranks = normal_ranks(&split);
        let means: Vec<f64> = ranks.chunks_exact(half).map(mean).collect();
        let halves: Vec<Vec<f64>> = ranks.chunks_exact(half).map(centred).collect();
        let n = half as f64;
        let within = autocovariance(&halves, 0) * n / (n - 1.0);
        let between: f64 = centred(&means).iter().map(|v| v * v).sum();
        let total = (n - 1.0) / n * within + between / (means.len() as f64 - 1.0);
        let correlation = |lag| 1.0 - (within - autocovariance(&halves, lag)) / total;
        let (mut sum, mut last, mut rest) = (0.0, f64::INFINITY, 0.0);
        for lag in (0..half - 1).step_by(2) {
            let even = if lag == 0 { 1.0 } else { correlation(lag) };
            let pair = even + correlation(lag + 1);
            if pair < 0.0 {
                rest = even.max(0.0);
                break;
            }
            last = last.min(pair);
            sum += last;
        }
        let draws = n * means.len() as f64;
        // Chains that alternate may be worth more than as many independent draws; the bound is that of Stan.
        let time = (2.0 * sum - 1.0 + rest).max(1.0 / draws.log10());
        Self {
            r_hat: (total / within).sqrt(),
            effective_draws: draws / time,
        }
    }

    /// Whether the quantity's chains have converged.
    pub(super) fn is_good(&self, chains: usize) -> bool {
        self.r_hat <= MOST_R_HAT && self.effective_draws >= FEWEST_EFFECTIVE_A_CHAIN * chains as f64
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = mean(values);
    values.iter().map(|v| v - mean).collect()
}

/// The mean over halves of the autocovariance, each divided by its number of draws.
fn autocovariance(halves: &[Vec<f64>], lag: usize) -> f64 {
    let of_one = |x: &Vec<f64>| -> f64 {
        let products: f64 = x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum();
        products / x.len() as f64
    };
    halves.iter().map(of_one).sum::<f64>() / halves.len() as f64
}

/// Normal quantiles of the ranks, of equal values that of their mean rank (offsets of Blom).
fn normal_ranks(draws: &[f64]) -> Vec<f64> {
    let n = draws.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| draws[a].total_cmp(&draws[b]));
    let normal = Normal::standard();
    let mut out = vec![0.0; n];
    let mut before = 0;
    for equal in order.chunk_by(|&a, &b| draws[a] == draws[b]) {
        let rank = before as f64 + 0.5 * (equal.len() as f64 + 1.0);
        let quantile = normal.inverse_cdf((rank - 0.375) / (n as f64 + 0.25));
        equal.iter().for_each(|&i| out[i] = quantile);
        before += equal.len();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four chains `x_t = α x_t-1 + cos(5.3 t² + c)`, each moved by a shift more than the one before.
    fn chains(alpha: f64, shift: f64, draws: usize) -> Vec<f64> {
        let chain = |c: usize| {
            let mut x = 0.0;
            let step = move |t: usize| {
                let t = t as f64;
                x = alpha * x + (5.3 * t * t + c as f64).cos();
                x + shift * c as f64
            };
            (0..draws).map(step)
        };
        (0..4).flat_map(chain).collect()
    }

    #[test]
    fn xval_arviz_on_the_same_chains() {
        // ArviZ 0.23 (Python): `rhat(x, method="z_scale")` and `ess(x, method="bulk")`; rounded draws have equal ranks.
        let cases = [
            (0.7, 0.0, 251, false, 1.0056590685453697, 187.9732494915938),
            (0.7, 0.0, 251, true, 1.0051287620379312, 208.1359316917876),
            (-0.5, 0.0, 200, false, 0.9969197533185186, 2322.471989593555),
            (0.9, 0.3, 300, false, 1.0180578505286504, 87.65659263813181),
            (0.9, 0.3, 300, true, 1.0177648909291026, 91.82135400796292),
            (0.0, 0.0, 64, false, 1.0028980152493012, 262.78706336599106),
        ];
        for (alpha, shift, draws, rounded, r_hat, effective) in cases {
            let mut x = chains(alpha, shift, draws);
            if rounded {
                x.iter_mut().for_each(|v| *v = v.round_ties_even());
            }
            let found = Diagnostic::of(&x, 4);
            // Two implementations of the normal quantile, each good to 1e-9 or so.
            assert!((found.r_hat - r_hat).abs() < 1e-7, "{alpha}: {found:?}");
            assert!(
                (found.effective_draws / effective - 1.0).abs() < 1e-6,
                "{alpha}: {found:?}"
            );
            // Ranks are those of any increasing function.
            let other: Vec<f64> = x.iter().map(|v| (0.5 * v).exp()).collect();
            assert_eq!(Diagnostic::of(&other, 4), found);
        }
    }

    #[test]
    fn prop_few_draws_have_no_diagnostic() {
        let found = Diagnostic::of(&[1.0, 2.0, 3.0], 1);
        assert!(found.r_hat.is_nan() && found.effective_draws.is_nan() && !found.is_good(1));
    }
}
