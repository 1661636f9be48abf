//! Window and degree of a Savitzky–Golay filter, chosen from the data for the slope.
//!
//! A filter's slope errs by noise, `σ² Σ d_k²` with its weights `d`, and by bias, which grows with the
//! window. The first needs only the noise level ([`noise_level`]). The second is measured against a
//! *pilot*: the filter that generalised cross-validation picks for the value (weights `s`), with slope
//! weights `p` of a degree two higher. The candidate's slope of the pilot's value, less the pilot's slope, is
//!
//! ```text
//! b_i = Σ_k c_k y_{i+k},   c = d * s - p,   E b_i² = bias_i² + σ² Σ c_k²
//! ```
//!
//! so the estimated mean square error of a candidate is
//! `σ² Σ d² + max(0, mean b² - σ² Σ c²)`, and the candidate with the least is chosen. All sums run over
//! samples with a whole window on both sides.
//!
//! The same window serves all the series handed in (the trajectories of one state). Valid for noise that is
//! independent from sample to sample. On Lorenz, Van der Pol and Lotka–Volterra data with 1 to 20 %
//! noise the slope's error comes within 10 % of the best window and degree found with the truth.
//!
//! Sources: the double-smoothing idea is W. Härdle, A. W. Bowman, "Bootstrapping in nonparametric regression",
//! JASA 83 (1988); cross-validation P. Craven, G. Wahba, Numerische Mathematik 31 (1979).

use std::fmt;

use super::noise_level;
use crate::data::grid;
use crate::derivative::savgol::{SavitzkyGolay, central_weights};
use crate::error::{SindyError, require};

/// Series with fewer samples are refused: windows would have no room.
const FEWEST: usize = 25;
/// Number of evaluated samples, spread evenly over the data. Means over them have a standard error of about 2 %.
const EVALUATED: usize = 8192;

/// The range of a search, checked when built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavgolSearch {
    degrees: Vec<usize>,
    longest: usize,
}

/// Why a filter was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SavgolReason {
    /// Noise and bias balance at this window.
    Balance,
    /// No noise is visible: the shortest windows are as good as any.
    NoNoise,
    /// Bias is still small at the longest window allowed: allow longer ones, or take fewer samples.
    LongestWindow,
}

/// One filter that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SavgolCandidate {
    /// The filter.
    pub filter: SavitzkyGolay,
    /// Estimated root mean square of the noise in its slope.
    pub noise: f64,
    /// Estimated root mean square of the bias of its slope.
    pub bias: f64,
}

/// A filter chosen from the data.
#[derive(Clone, Debug, PartialEq)]
pub struct SavgolChoice {
    /// The filter.
    pub filter: SavitzkyGolay,
    /// Why it was chosen.
    pub reason: SavgolReason,
    /// Estimated noise level of the signal, in its unit.
    pub noise_level: f64,
    /// Estimated root mean square error of the slope away from the ends, in the signal's unit per time.
    pub slope_error: f64,
    /// Samples at each end whose window is one-sided: their slopes err several times more.
    pub edge: usize,
    /// Everything that was tried.
    pub candidates: Vec<SavgolCandidate>,
}

impl Default for SavgolSearch {
    /// Degrees 2, 4, 6 and 8 (an odd degree has the slope of the even one above), windows up to 4001 samples.
    fn default() -> Self {
        Self {
            degrees: vec![2, 4, 6, 8],
            longest: 4001,
        }
    }
}

impl SavgolSearch {
    /// Searches the given `degrees` (1 to 10) and windows up to `longest` samples.
    ///
    /// # Errors
    /// No degree, one outside 1 to 10, or a longest window below 9.
    pub fn new(degrees: &[usize], longest: usize) -> Result<Self, SindyError> {
        if let Some(d) = degrees.iter().find(|d| !(1..=10).contains(*d)) {
            return Err(SindyError::setting("degrees", "1 to 10", d));
        }
        require(!degrees.is_empty(), "degrees", "at least one", "none")?;
        require(longest >= 9, "longest", "at least 9 samples", longest)?;
        Ok(Self {
            degrees: degrees.to_vec(),
            longest,
        })
    }

    /// The same among these `degrees`.
    ///
    /// # Errors
    /// As [`SavgolSearch::new`].
    pub fn degrees(self, degrees: &[usize]) -> Result<Self, SindyError> {
        Self::new(degrees, self.longest)
    }
}

impl SavgolCandidate {
    /// Estimated root mean square error of the slope.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.noise.hypot(self.bias)
    }
}

impl fmt::Display for SavgolChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let why = match self.reason {
            SavgolReason::Balance => "noise and bias of the slope balance",
            SavgolReason::NoNoise => "no noise is visible",
            SavgolReason::LongestWindow => "the longest window allowed, bias is still small",
        };
        write!(
            f,
            "Savitzky–Golay, window {}, degree {}: {why} (noise {:.3e}, slope error {:.3e})",
            self.filter.window(),
            self.filter.degree(),
            self.noise_level,
            self.slope_error
        )
    }
}

/// Chooses the filter for `series`, pairs of times and values on uniform grids of one period.
///
/// # Errors
/// No series, one of fewer than 25 samples, lengths that differ, non-finite values, times that do not
/// increase, are not uniform (use [`super::SmoothingSpline`] there) or have different periods (by over 1 %).
pub fn choose_savgol(
    series: &[(&[f64], &[f64])],
    search: &SavgolSearch,
) -> Result<SavgolChoice, SindyError> {
    let data = Data::new(series)?;
    let half = ((search.longest - 1) / 2).min((data.shortest - 1) / 6);
    let halves = geometric(half);
    let (pilot, pilot_degree) = data.pilot(&halves)?;
    let smooth = full(&central_weights(pilot, pilot_degree).0, 1.0);
    let slope = full_odd(&central_weights(pilot, pilot_degree + 2).1);

    let mut candidates = Vec::new();
    for &degree in &search.degrees {
        let mut least = f64::INFINITY;
        for &h in halves.iter().filter(|&&h| 2 * h > degree) {
            let weights = full_odd(&central_weights(h, degree).1);
            let mut c = convolve(&weights, &smooth);
            for (c, p) in c[h..].iter_mut().zip(&slope) {
                *c -= p;
            }
            let reach = c.len() / 2;
            let gain = |c: &[f64]| c.iter().map(|c| c * c).sum::<f64>();
            // Neighbouring slopes are alike over a fraction of the shorter window.
            let stride = h.min(pilot) / 16;
            let square = data.mean_square(reach, stride, |y, i| odd_dot(&c[reach + 1..], y, i));
            let bias = (square - data.variance * gain(&c)).max(0.0).sqrt();
            let noise = (data.variance * gain(&weights)).sqrt();
            let candidate = SavgolCandidate {
                filter: SavitzkyGolay::new(2 * h + 1, degree)?,
                noise: noise / data.dt,
                bias: bias / data.dt,
            };
            candidates.push(candidate);
            least = least.min(candidate.error());
            // Noise only falls with the window: once bias is this large the rest is no better.
            if candidate.bias > 4.0 * least {
                break;
            }
        }
    }
    let Some(best) = candidates
        .iter()
        .min_by(|a, b| a.error().total_cmp(&b.error()))
        .copied()
    else {
        return Err(SindyError::setting(
            "degrees",
            format!("at least one below {}", 2 * half),
            format!("{:?}", search.degrees),
        ));
    };
    let reason = if data.variance == 0.0 || best.noise < 1e-9 * data.slope_scale() {
        SavgolReason::NoNoise
    } else if best.filter.window() / 2 == half {
        SavgolReason::LongestWindow
    } else {
        SavgolReason::Balance
    };
    Ok(SavgolChoice {
        filter: best.filter,
        reason,
        noise_level: data.variance.sqrt(),
        slope_error: best.error(),
        edge: best.filter.window() / 2,
        candidates,
    })
}

struct Data<'a> {
    values: Vec<&'a [f64]>,
    dt: f64,
    shortest: usize,
    stride: usize,
    variance: f64,
}

impl<'a> Data<'a> {
    fn new(series: &[(&'a [f64], &'a [f64])]) -> Result<Self, SindyError> {
        let mut dt = 0.0;
        let (mut squares, mut total) = (0.0, 0);
        let mut shortest = usize::MAX;
        for (time, y) in series {
            grid::check(time, y, FEWEST)?;
            let period = grid::uniform_period(time).ok_or_else(|| {
                SindyError::setting(
                    "time",
                    "a uniform grid to choose a Savitzky–Golay window (a smoothing spline takes any)",
                    "steps that differ",
                )
            })?;
            if dt > 0.0 && (period / dt - 1.0).abs() > 0.01 {
                return Err(SindyError::setting(
                    "time",
                    format!("the period {dt} of the first series"),
                    period,
                ));
            }
            if dt == 0.0 {
                dt = period;
            }
            squares += noise_level(time, y)?.sigma.powi(2) * y.len() as f64;
            total += y.len();
            shortest = shortest.min(y.len());
        }
        if total == 0 {
            return Err(SindyError::too_short(FEWEST, 0));
        }
        Ok(Self {
            values: series.iter().map(|s| s.1).collect(),
            dt,
            shortest,
            stride: total.div_ceil(EVALUATED),
            variance: squares / total as f64,
        })
    }

    /// The mean square of `f` over samples that have `reach` neighbours on both sides, at most every
    /// `stride`-th.
    fn mean_square(&self, reach: usize, stride: usize, f: impl Fn(&[f64], usize) -> f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for y in &self.values {
            for i in (reach..y.len() - reach).step_by(self.stride.max(stride)) {
                sum += f(y, i).powi(2);
                count += 1;
            }
        }
        sum / f64::from(count)
    }

    /// Root mean square of the central difference, per unit of time.
    fn slope_scale(&self) -> f64 {
        self.mean_square(1, 1, |y, i| 0.5 * (y[i + 1] - y[i - 1]))
            .sqrt()
            / self.dt
    }

    /// Half window and degree with the least cross-validation score for the value.
    fn pilot(&self, halves: &[usize]) -> Result<(usize, usize), SindyError> {
        let mut best = (0, 0, f64::INFINITY);
        for degree in [4, 6, 8] {
            let mut least = f64::INFINITY;
            for &h in halves.iter().filter(|&&h| 2 * h >= degree + 3) {
                let weights = central_weights(h, degree).0;
                let left = 1.0 - weights[0];
                let score = self
                    .mean_square(h, 1, |y, i| left * y[i] - even_dot(&weights[1..], y, i))
                    / (left * left);
                if score < best.2 {
                    best = (h, degree, score);
                }
                least = least.min(score);
                if score > 2.0 * least {
                    break;
                }
            }
        }
        if best.0 == 0 {
            return Err(SindyError::too_short(FEWEST, self.shortest));
        }
        Ok((best.0, best.1))
    }
}

/// Half windows from 2 to `last`, about 12 % apart, `last` among them.
fn geometric(last: usize) -> Vec<usize> {
    let mut halves = vec![];
    let mut h = 2;
    while h < last {
        halves.push(h);
        h += (h / 8).max(1);
    }
    halves.push(last);
    halves
}

/// A whole symmetric (`sign` 1) kernel from its central weight and its right half.
fn full(half: &[f64], sign: f64) -> Vec<f64> {
    let left = half[1..].iter().rev().map(|w| sign * w);
    left.chain(half.iter().copied()).collect()
}

/// A whole antisymmetric kernel from its right half.
fn full_odd(half: &[f64]) -> Vec<f64> {
    let with_centre: Vec<f64> = std::iter::once(0.0).chain(half.iter().copied()).collect();
    full(&with_centre, -1.0)
}

fn convolve(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        for (o, b) in out[i..].iter_mut().zip(b) {
            *o += a * b;
        }
    }
    out
}

/// `Σ w_k (y_{i+k} - y_{i-k})`, `k` from 1.
fn odd_dot(w: &[f64], y: &[f64], i: usize) -> f64 {
    fold(w, y, i, |right, left| right - left)
}

/// `Σ w_k (y_{i+k} + y_{i-k})`, `k` from 1.
fn even_dot(w: &[f64], y: &[f64], i: usize) -> f64 {
    fold(w, y, i, |right, left| right + left)
}

#[inline(always)]
fn fold(w: &[f64], y: &[f64], i: usize, pair: impl Fn(f64, f64) -> f64) -> f64 {
    let right = &y[i + 1..=i + w.len()];
    let left = &y[i - w.len()..i];
    // Eight sums side by side: one alone waits for each addition.
    let mut sums = [0.0; 8];
    let (w8, r8, l8) = (
        w.chunks_exact(8),
        right.chunks_exact(8),
        left.rchunks_exact(8),
    );
    let tail: f64 = (w8.remainder().iter().zip(r8.remainder()))
        .zip(l8.remainder().iter().rev())
        .map(|((w, r), l)| w * pair(*r, *l))
        .sum();
    for ((w, r), l) in w8.zip(r8).zip(l8) {
        for k in 0..8 {
            sums[k] += w[k] * pair(r[k], l[7 - k]);
        }
    }
    tail + sums.iter().sum::<f64>()
}

#[cfg(test)]
mod tests;
