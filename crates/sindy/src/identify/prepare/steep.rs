//! Rows whose times run over orders of magnitude, as of a stiff system that is sampled evenly in the logarithm of time.
//!
//! Such rows resolve fast motion where steps are short, and slow motion where they are long. So the number of the row, `k`, is the
//! time in which signals are equally smooth everywhere: splines smooth over `k`, and `dx/dt = (dx/dk) / (dt/dk)`. Between geometric
//! steps `h` and `g = r h`,
//!
//! ```text
//! dt/dk = √(h g) (q/2) / sinh(q/2),    q = ln r.
//! ```
//!
//! A slope then has noise of about `σ/(√2 dt/dk)`, large where steps are short. Where they are long the terms have the larger noise:
//! that of the states times the Jacobian, which is large for fast modes. Rows count by the inverse of both variances together.

use super::{Noise, Slopes, series::smoothed};
use crate::data::dataset::Stretch;
use crate::derivative::{FiniteDifference, SmoothingSpline};
use crate::error::SindyError;

/// A longest step over the shortest from which rows count as steep: the largest step of a Runge-Kutta method is 2.8 time constants, and
/// with 32 steps between samples, the most that are made, it is stable over 89 of those that the shortest step resolves.
const STEEP: f64 = 100.0;
/// Rows whose mean step is looked at: a jitter of times is no change of scale.
const ROWS: usize = 10;
/// Rows at each end whose slopes err more, as for other splines.
const EDGE: usize = 5;

/// Whether the times of some stretch run over orders of magnitude.
pub(in crate::identify) fn is_steep(stretches: &[Stretch<'_>]) -> bool {
    let ratio = |s: &Stretch<'_>| {
        let spans = s.time.windows(ROWS + 1).map(|w| w[ROWS] - w[0]);
        let (least, most) = spans.fold((f64::INFINITY, 0.0_f64), |(a, b), h| (a.min(h), b.max(h)));
        most / least
    };
    stretches.iter().any(|s| ratio(s) > STEEP)
}

/// Slopes by splines over the number of the row.
pub(in crate::identify) fn by_row(
    stretches: &[Stretch<'_>],
    states: usize,
) -> Result<Slopes, SindyError> {
    let smoothed = smoothed(stretches, states, |_, time, column| {
        let rows: Vec<f64> = (0..time.len()).map(|k| k as f64).collect();
        match SmoothingSpline::cross_validated().apply(&rows, column) {
            Err(SindyError::TooShort { .. }) => FiniteDifference::new(2)?.apply(time, column),
            Err(other) => Err(other),
            Ok(mut smooth) => {
                let paces = paces(time);
                let pairs = smooth.derivative.iter_mut().zip(paces);
                pairs.for_each(|(slope, pace)| *slope /= pace);
                Ok(smooth)
            }
        }
    })?;
    Ok(Slopes {
        name: "smoothing spline over rows".into(),
        smoothed,
        edge: EDGE,
        window: (2 * EDGE + 1) as f64,
        weights: Vec::new(),
    })
}

/// Weights of the rows by stretch, state and row. `terms` is the noise that the states' leaves in each equation, by stretch, equation and
/// row.
pub(in crate::identify) fn weights(
    stretches: &[Stretch<'_>],
    noise: &Noise,
    terms: &[Vec<Vec<f64>>],
) -> Vec<Vec<Vec<f64>>> {
    let of = |(s, terms): (&Stretch<'_>, &Vec<Vec<f64>>)| {
        let paces = paces(s.time);
        let state = |(own, sigma): (&Vec<f64>, &f64)| {
            let row = |(k, terms): (usize, &f64)| {
                let slope = sigma / paces[k];
                let given = s.weights.map_or(1.0, |w| w[k]);
                given / (0.5 * slope * slope + terms * terms)
            };
            own.iter().enumerate().map(row).collect()
        };
        terms.iter().zip(&noise.sigma).map(state).collect()
    };
    stretches.iter().zip(terms).map(of).collect()
}

/// `dt/dk` at each row.
fn paces(time: &[f64]) -> Vec<f64> {
    let last = time.len() - 1;
    let step = |k: usize| time[k + 1] - time[k];
    let at = |k: usize| {
        if k == 0 || k == last {
            return step(k.min(last - 1));
        }
        let (h, g) = (step(k - 1), step(k));
        let half = 0.5 * (g / h).ln();
        let shape = if half == 0.0 { 1.0 } else { half / half.sinh() };
        (h * g).sqrt() * shape
    };
    (0..=last).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_paces_of_geometric_and_even_times() {
        let time: Vec<f64> = (0..40).map(|k| 1e-3 * 1.3_f64.powi(k)).collect();
        for (k, pace) in paces(&time).iter().enumerate().skip(1).take(38) {
            // To rounding of differences.
            assert!(
                (pace / (1.3_f64.ln() * time[k]) - 1.0).abs() < 1e-12,
                "{k}: {pace}"
            );
        }
        assert_eq!(paces(&[1.0, 3.0, 5.0, 7.0]), [2.0; 4]);
    }
}
