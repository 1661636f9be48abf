//! Errors of a fit in free run, and what the data do not resolve.
//!
//! Curvature gives the errors of the curve's coefficients. Those of lag and dead time come from the profile of the sum of
//! squares S, which curvature misstates near zero and for slow commands:
//!
//! ```text
//! { θ : S(θ) - S_min ≤ t² c σ² },    S(θ) = min over all other parameters
//! ```
//!
//! with Student's t over pieces of the records. c is the variance of the estimate over those pieces relative to that of
//! white noise, at least 1: correlated residuals widen the interval. With a parabolic profile this is the interval by
//! curvature.
//!
//! Source: D. M. Bates, D. G. Watts, *Nonlinear Regression Analysis and Its Applications* (1988), chapter 6.

use nalgebra::{DMatrix, DVector};
use sindy::statistics::regression::{ClusterErrors, student_95};
use sindy::{Gram, Library, Samples};

use super::early::Early;
use super::signal::{Between, SMOOTH, bend};
use super::solve::{Free, LONGEST_DEAD_TIME_S, Problem, SHORTEST_LAG_S, Solution};
use crate::error::Result;
use crate::estimate::Estimate;

/// Standard deviation of a uniform error of one period: a command may have changed anywhere between two samples.
const UNIFORM_SD: f64 = 0.288_675_134_594_812_9;
/// Share of the period that a lag's interval must lie above. Below half of it, all of the answer lies between two samples.
const LEAST_PERIODS: f64 = 0.5;
/// Share of the largest thrust that every measurement errs by at least: logs have about six digits.
const DIGITS: f64 = 1e-6;
/// Steps that an interval's end is sought with: to a hundredth of intervals that are a thousandth of the way to the bound.
pub(super) const STEPS: usize = 14;
/// Student's t of normal noise at 97.5 %.
const NORMAL_95: f64 = 1.96;

/// A lag or dead time as far as data resolve it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Resolved {
    /// With standard error and interval.
    Within(Estimate),
    /// Not above this bound (95 %); the value is the most likely one below it.
    Below {
        /// Most likely value (s).
        value: f64,
        /// Its upper bound (s).
        bound: f64,
    },
    /// At a bound of its search, or without an upper end: the data do not identify it.
    AtBound {
        /// The value (s).
        value: f64,
    },
}

/// The errors of a fit.
#[derive(Clone, Debug)]
pub(crate) struct Certainty {
    /// The curve's coefficients.
    pub coefficients: Vec<Estimate>,
    /// The lag, where it is free.
    pub lag: Option<Resolved>,
    /// The dead time, where it is free.
    pub dead_time: Option<Resolved>,
    /// An answer before its command, where the lag is another then. Not sought where the dead time is free.
    pub early: Option<Early>,
}

/// Student's t, and the cost by which the profile may rise within an interval.
pub(super) struct Threshold {
    pub squares: f64,
    pub t: f64,
}

impl Problem<'_> {
    /// The errors of a fit with these free parameters.
    ///
    /// # Errors
    /// Pieces that no statistics can be made of.
    pub(crate) fn certainty(&self, at: &Solution, free: Free) -> Result<Certainty> {
        let (by, predicted) = self.derivatives(at, free);
        let p = by.len();
        let variance = self.variance(at, p);
        let (errors, degrees, colour) = self.errors(&by, &predicted, variance)?;
        let k = self.shape.coefficients();
        let coefficients = (0..k)
            .map(|j| {
                let half = student_95(degrees[j]) * errors[j];
                let value = at.linear[j];
                Estimate {
                    value,
                    std_error: errors[j],
                    ci95: [value - half, value + half],
                }
            })
            .collect();
        let threshold = |j: usize| {
            let t = student_95(degrees[j]);
            let squares = t * t * colour[j] * variance;
            Threshold { squares, t }
        };
        let last = p - 1;
        let lag_at = last - usize::from(free.dead_time);
        let lag = free.lag.then(|| self.lag(at, free, &threshold(lag_at)));
        let early = match lag {
            Some(lag) if !free.dead_time => self.early(at, free, lag, &threshold(lag_at)),
            _ => None,
        };
        Ok(Certainty {
            coefficients,
            lag,
            early,
            dead_time: free
                .dead_time
                .then(|| self.dead_time(at, free, &threshold(last))),
        })
    }

    /// Variance of the noise (N²), of at least the digits that thrust is written with.
    fn variance(&self, at: &Solution, parameters: usize) -> f64 {
        let spare = self.len().saturating_sub(parameters).max(1) as f64;
        let largest = self.measured.iter().fold(0.0_f64, |a, m| a.max(m.abs()));
        (at.squares / spare).max((DIGITS * largest).powi(2))
    }

    /// Standard error, degrees of freedom, and ratio of variances (pieces over white noise) of each parameter.
    fn errors(
        &self,
        by: &[Vec<f64>],
        predicted: &[f64],
        variance: f64,
    ) -> Result<(Vec<f64>, Vec<f64>, Vec<f64>)> {
        let p = by.len();
        let names: Vec<String> = (0..p).map(|j| format!("p{j}")).collect();
        let mut all: Vec<&str> = names.iter().map(String::as_str).collect();
        all.push("y");
        let mut samples = Samples::new(&all);
        let rows: Vec<usize> = (0..self.len()).collect();
        for run in rows.chunk_by(|&a, &b| self.pieces[a] == self.pieces[b]) {
            let mut columns: Vec<Vec<f64>> = by
                .iter()
                .map(|c| run.iter().map(|&i| c[i]).collect())
                .collect();
            columns.push(
                run.iter()
                    .map(|&i| self.measured[i] - predicted[i])
                    .collect(),
            );
            samples.push_group(columns)?;
        }
        let grams = Gram::accumulate(&Library::parse(&names)?, "y", &samples)?;
        let total = Gram::total(&grams);
        let inverse = inverse_diagonal(&total.xtx);
        let clusters = ClusterErrors::new(&grams, &DVector::zeros(p), &vec![true; p]);
        let (mut errors, mut degrees, mut colour) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..p {
            let white = variance * inverse[j];
            let of_pieces = clusters
                .as_ref()
                .map(|c| (c.std_errors[j].powi(2), c.degrees[j]))
                .filter(|(v, d)| v.is_finite() && *d >= 1.0);
            let (pieces, freedom) =
                of_pieces.unwrap_or((white, (grams.len() as f64 - 1.0).max(1.0)));
            errors.push(pieces.max(white).sqrt());
            degrees.push(freedom);
            colour.push(if white > 0.0 {
                (pieces / white).max(1.0)
            } else {
                f64::INFINITY
            });
        }
        Ok((errors, degrees, colour))
    }

    pub(super) fn lag(&self, at: &Solution, free: Free, threshold: &Threshold) -> Resolved {
        let value = at.lag_s;
        let fixed = Free { lag: false, ..free };
        let rise = |lag_s: f64| {
            let start = Solution {
                lag_s,
                ..at.clone()
            };
            self.refine(start, fixed, None, 5).squares - at.squares
        };
        let within = |log: f64| rise(log.exp()) <= threshold.squares;
        let bounds = [SHORTEST_LAG_S, self.longest_lag_s].map(f64::ln);
        let [low, high] = ends(value.ln(), bounds, within);
        let Some(high) = high.map(f64::exp) else {
            return Resolved::AtBound { value };
        };
        let smear = self.smear_s(value);
        let least = LEAST_PERIODS * self.period_s;
        match low.map(f64::exp) {
            Some(low) if low > least => {
                Resolved::Within(widened(value, [low, high], smear, threshold))
            }
            _ => Resolved::Below {
                value,
                bound: high.max(least),
            },
        }
    }

    /// What a lag takes in of the time between samples (s).
    ///
    /// Held, a change anywhere within a period P spreads the answer by the variance of that time, `P²/12`, of which a lag τ takes
    /// in `P²/(24 τ)`. Straight lines between the samples of a smooth throttle cut a share `(ω P)²/12` off its sine of frequency ω.
    /// A lag loses as much by `(1 + (ω τ)²) P²/(12 τ)`.
    fn smear_s(&self, lag_s: f64) -> f64 {
        let of_period = (self.period_s * UNIFORM_SD).powi(2) / lag_s;
        match self.between {
            Between::Held => 0.5 * of_period,
            Between::Linear => {
                let throttles = self.records.iter().flat_map(|r| &r.motors);
                let bend = bend(throttles.map(Vec::as_slice));
                // What bends more is no smooth throttle, but steps whose times are not known.
                let curved = if bend <= SMOOTH { bend } else { 0.0 };
                of_period + UNIFORM_SD.powi(2) * curved * lag_s
            }
        }
    }

    fn dead_time(&self, at: &Solution, free: Free, threshold: &Threshold) -> Resolved {
        let value = at.dead_time_s;
        let fixed = Free {
            dead_time: false,
            ..free
        };
        let within = |dead_time_s: f64| {
            let start = Solution {
                dead_time_s,
                ..at.clone()
            };
            self.refine(start, fixed, None, 5).squares - at.squares <= threshold.squares
        };
        let [low, high] = ends(value, [0.0, LONGEST_DEAD_TIME_S], within);
        match high {
            None => Resolved::AtBound { value },
            Some(high) => {
                let [sooner, later] = self.between.clock_s(self.period_s);
                let ends = [low.unwrap_or(0.0) - sooner, high + later];
                let mut estimate = widened(value, ends, 0.0, threshold);
                estimate.ci95[0] = estimate.ci95[0].max(0.0);
                Resolved::Within(estimate)
            }
        }
    }
}

/// The diagonal of the inverse of a matrix of products; infinite where it has none.
fn inverse_diagonal(products: &DMatrix<f64>) -> Vec<f64> {
    let p = products.nrows();
    let scale: Vec<f64> = (0..p).map(|j| products[(j, j)].sqrt()).collect();
    let scaled = DMatrix::from_fn(p, p, |a, b| products[(a, b)] / (scale[a] * scale[b]));
    let inverse = scaled.try_inverse();
    let of = |j: usize| {
        let value = inverse.as_ref().map(|m| m[(j, j)] / scale[j].powi(2));
        value.filter(|v| *v > 0.0).unwrap_or(f64::INFINITY)
    };
    (0..p).map(of).collect()
}

/// The ends of the interval around `value` within which the profile stays; none where it reaches a bound.
fn ends(value: f64, bounds: [f64; 2], within: impl Fn(f64) -> bool) -> [Option<f64>; 2] {
    bounds.map(|bound| {
        // Where the bound itself is as likely, there is no end.
        if value == bound || within(bound) {
            return None;
        }
        let (mut inside, mut outside) = (value, bound);
        for _ in 0..STEPS {
            // Intervals are short beside the way to the bound: a quarter of it at a time.
            let middle = inside + 0.25 * (outside - inside);
            if within(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(outside)
    })
}

/// A value with an interval by its profile, and an error beside it that the profile does not know.
fn widened(value: f64, [low, high]: [f64; 2], beside: f64, threshold: &Threshold) -> Estimate {
    let with = |half: f64| half.hypot(NORMAL_95 * beside);
    let ci95 = [value - with(value - low), value + with(high - value)];
    Estimate {
        value,
        std_error: 0.5 * (ci95[1] - ci95[0]) / threshold.t,
        ci95,
    }
}
