//! The noise level of a signal, from the signal alone.
//!
//! The `k`-th difference removes polynomials of degree `k - 1`, so for `k` large enough it is noise only.
//! On any grid, over `k + 1` neighbouring samples,
//!
//! ```text
//! δ_i = Σ_j c_j y_{i+j},   c_j ∝ 1 / Π_{l≠j} (t_{i+j} - t_{i+l}),   Σ c_j² = 1
//! ```
//!
//! has the standard deviation `σ` of white noise in `y`. `σ` is the median of `|δ|` over 0.6745 (so spikes and
//! short fast stretches do not matter), at the lowest `k` up to 10 beyond which it no longer falls.
//!
//! Valid for noise that is independent from sample to sample, and a signal whose fastest part is well below
//! half the sampling rate for more than half of the time. Noise that is correlated (filtered sensors) is
//! underestimated. A signal in whole steps `q` (digits of a file, bits of a converter) has at least the noise of
//! rounding, `q/√12`; where most differences are zero, the root mean square of `δ` is taken.
//!
//! Sources: T. Gasser, L. Sroka, C. Jennen-Steinmetz, "Residual variance and residual pattern in nonlinear
//! regression", Biometrika 73 (1986); P. Hall, J. W. Kay, D. M. Titterington, "Asymptotically optimal
//! difference-based estimation of variance", Biometrika 77 (1990).

use rayon::prelude::*;

use crate::data::grid;
use crate::error::SindyError;
use crate::numerics::upper_median;

/// The highest order of difference that is tried; each order removes a power of time from the signal.
const HIGHEST: usize = 10;
/// Samples below which no estimate is made: too few differences for a variance.
const FEWEST: usize = 8;

/// An estimated noise level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLevel {
    /// Standard deviation of the noise, in the signal's unit.
    pub sigma: f64,
    /// The order of difference that it was taken from.
    pub order: usize,
}

/// Estimates the noise level of `y` sampled at `time`.
///
/// # Errors
/// Fewer than 8 samples, lengths that differ, non-finite values, times that do not increase.
pub fn noise_level(time: &[f64], y: &[f64]) -> Result<NoiseLevel, SindyError> {
    grid::check(time, y, FEWEST)?;
    let n = y.len();
    let uniform = grid::uniform_period(time).is_some();
    let quantum = quantum(y).unwrap_or(0.0);
    let level = |order: usize| {
        let fixed: [f64; HIGHEST + 1] =
            contrast(&std::array::from_fn::<f64, { HIGHEST + 1 }, _>(|i| i as f64)[..=order]);
        let mut size: Vec<f64> = (0..n - order)
            .map(|i| {
                let c = match uniform {
                    true => fixed,
                    false => contrast(&time[i..=i + order]),
                };
                let d: f64 = c.iter().zip(&y[i..=i + order]).map(|(c, y)| c * y).sum();
                d.abs()
            })
            .collect();
        let mean_square = size.iter().map(|d| d * d).sum::<f64>() / size.len() as f64;
        let median = upper_median(&mut size).unwrap_or(0.0);
        // 0.6745 is the median of |N(0, 1)|.
        // Differences of whole steps are zero but for the rounding of decimal digits.
        if median > 1e-4 * quantum {
            median / 0.674_489_750_196_081_7
        } else {
            mean_square.sqrt()
        }
    };
    let orders = 1..HIGHEST.min(n / 4) + 1;
    let levels: Vec<f64> = orders.into_par_iter().map(level).collect();
    let least = levels.iter().copied().fold(f64::INFINITY, f64::min);
    // A median absolute deviation of n independent values scatters by 1.17 σ / √n; neighbouring differences
    // of order 10 are alike, which doubles that. Levels closer than twice the scatter count as equal.
    let alike = least * (1.0 + 4.7 / (n as f64).sqrt().max(4.7));
    let chosen = levels.iter().position(|&l| l <= alike).unwrap_or(0);
    Ok(NoiseLevel {
        sigma: levels[chosen].max(quantum / 12.0_f64.sqrt()),
        order: chosen + 1,
    })
}

/// The step of which all differences between neighbours are multiples; `None` where there is none, or the signal does
/// not change.
pub(super) fn quantum(y: &[f64]) -> Option<f64> {
    // Less is the rounding of the numbers themselves.
    let is_change = |w: &&[f64]| (w[1] - w[0]).abs() > 1e-12 * w[0].abs().max(w[1].abs());
    let changes = || y.windows(2).filter(is_change).map(|w| (w[1] - w[0]).abs());
    let least = changes().fold(f64::INFINITY, f64::min);
    let whole = |s: f64| {
        let times = s / least;
        (times - times.round()).abs() <= 1e-3
    };
    if !(least.is_finite() && changes().all(whole)) {
        return None;
    }
    // Ramps and parabolas have whole steps by nature: a difference of theirs is zero throughout.
    let mut left: Vec<f64> = y
        .windows(2)
        .map(|w| ((w[1] - w[0]) / least).round())
        .collect();
    for _ in 0..4 {
        left = left.windows(2).map(|w| w[1] - w[0]).collect();
        if left.iter().all(|d| *d == 0.0) {
            return None;
        }
    }
    Some(least)
}

/// The weights of the difference over `points`, of unit norm.
fn contrast(points: &[f64]) -> [f64; HIGHEST + 1] {
    let span = points[points.len() - 1] - points[0];
    let mut c = [0.0; HIGHEST + 1];
    for (j, &t) in points.iter().enumerate() {
        c[j] = 1.0
            / points
                .iter()
                .enumerate()
                .filter(|&(l, _)| l != j)
                .map(|(_, &s)| (t - s) / span)
                .product::<f64>();
    }
    let norm = c.iter().map(|c| c * c).sum::<f64>().sqrt();
    c.map(|c| c / norm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivative::tests::signals::{gauss, lorenz};

    /// 24 samples a turn: the first difference of this signal is a hundred times the noise.
    fn fast(n: usize, dt: f64) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..n).map(|i| dt * i as f64).collect();
        let y = t.iter().map(|t| 5.0 * (t / dt * 0.26).sin()).collect();
        (t, y)
    }

    #[test]
    fn analytic_known_noise_on_fast_signals() {
        for (seed, sigma) in [(1, 0.01), (2, 0.1), (3, 1.0)] {
            let (t, y) = fast(4000, 0.01);
            let y: Vec<f64> = y
                .iter()
                .zip(gauss(seed, 4000))
                .map(|(y, e)| y + sigma * e)
                .collect();
            let found = noise_level(&t, &y).unwrap();
            // Scatter of the median at order 10 over 4000 samples: 4 %; three of them.
            assert!(
                (found.sigma / sigma - 1.0).abs() < 0.12,
                "{sigma}: {found:?}"
            );
        }
        let (t, x, _) = lorenz(5000, 0.002);
        for percent in [0.1, 1.0, 20.0] {
            let y: Vec<f64> = x
                .iter()
                .zip(gauss(5, 5000))
                .map(|(x, e)| x + 0.08 * percent * e)
                .collect();
            let found = noise_level(&t, &y).unwrap().sigma / (0.08 * percent);
            // As above.
            assert!((found - 1.0).abs() < 0.12, "{percent}: {found}");
        }
    }

    #[test]
    fn analytic_spikes_and_uneven_time_do_not_matter() {
        let (t, y) = fast(4000, 1.0);
        let jitter = gauss(9, 4000);
        let t: Vec<f64> = t
            .iter()
            .zip(&jitter)
            .map(|(t, j)| t + 0.1 * j.clamp(-3.0, 3.0))
            .collect();
        let mut y: Vec<f64> = t
            .iter()
            .map(|t| 5.0 * (t * 0.1).sin())
            .zip(&y)
            .map(|(y, _)| y)
            .collect();
        for (y, e) in y.iter_mut().zip(gauss(4, 4000)) {
            *y += 0.1 * e;
        }
        for i in (0..4000).step_by(200) {
            y[i] += 50.0;
        }
        let found = noise_level(&t, &y).unwrap();
        // A spike in 200 samples touches one difference in 30 (order 5): a few percent upward.
        assert!((found.sigma / 0.1 - 1.0).abs() < 0.2, "{found:?}");
    }

    #[test]
    fn analytic_whole_steps_have_the_noise_of_rounding() {
        // As in a file with two digits: differences of the steps are zero but for the rounding of 0.01.
        let t: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        for digits in [1.0, 2.0, 5.0] {
            let step = 10.0_f64.powf(-digits);
            let y: Vec<f64> = t
                .iter()
                .map(|t| (t.sin() / step).round() / 10.0_f64.powf(digits))
                .collect();
            let found = noise_level(&t, &y).unwrap().sigma * 12.0_f64.sqrt() / step;
            // Neighbours round alike where steps are coarse, which differences do not see; never less than rounding.
            assert!((1.0 - 1e-9..3.0).contains(&found), "{digits}: {found}");
            let q = quantum(&y).unwrap();
            assert!((q / step - 1.0).abs() < 1e-6, "{q}");
        }
        let smooth: Vec<f64> = t.iter().map(|t| t.sin()).collect();
        assert_eq!(quantum(&smooth), None);
        let mut spoilt = smooth.clone();
        spoilt[700] = 1e300;
        assert_eq!(quantum(&spoilt), None);
        let ramp: Vec<f64> = t.iter().map(|t| 3.0 - 0.7 * t).collect();
        let fall: Vec<f64> = t.iter().map(|t| 5.0 - 4.905 * t * t).collect();
        for y in [&ramp[..], &fall, &[1.0; 9]] {
            assert_eq!(quantum(y), None);
        }
        assert!(noise_level(&t, &smooth).unwrap().sigma < 1e-13);
    }

    #[test]
    fn prop_no_noise_and_bad_input() {
        let t: Vec<f64> = (0..50).map(f64::from).collect();
        assert_eq!(noise_level(&t, &[3.0; 50]).unwrap().sigma, 0.0);
        assert!(matches!(
            noise_level(&t[..7], &t[..7]),
            Err(SindyError::TooShort { needed: 8, .. })
        ));
    }
}
