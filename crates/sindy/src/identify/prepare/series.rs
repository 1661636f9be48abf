//! A state at its own times: those of all rows, or of those in which it is measured where it has a rate of its own.

use std::borrow::Cow;

use crate::data::dataset::sampling::pick;
use crate::data::dataset::{Dataset, Stretch};
use crate::data::grid::uniform_period;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;
use crate::numerics::hermite;

/// Periods of stretches that differ by this share are the same.
const SAME_PERIOD: f64 = 1e-3;

/// A state of a stretch at its own times.
pub(super) struct Series<'a> {
    pub time: Cow<'a, [f64]>,
    pub values: Cow<'a, [f64]>,
}

impl<'a> Series<'a> {
    pub(super) fn of(stretch: &Stretch<'a>, state: usize) -> Self {
        let own = stretch.own_rows(state);
        Self {
            time: pick(stretch.time, own.as_deref()),
            values: pick(stretch.columns[state], own.as_deref()),
        }
    }

    /// The measured values alone, without those that bridge rows of no weight.
    pub(super) fn measured(stretch: &Stretch<'a>, state: usize) -> Self {
        let own = stretch.measured_rows(state);
        Self {
            time: pick(stretch.time, own.as_deref()),
            values: pick(stretch.columns[state], own.as_deref()),
        }
    }
}

/// The series that are at least half as long as usual, and no shorter than `least`. Half of the samples lie in series of the usual
/// length or longer: a few short ones do not narrow the window for all.
pub(super) fn long<'s>(series: &'s [Series<'_>], least: usize) -> Vec<(&'s [f64], &'s [f64])> {
    let mut lengths: Vec<usize> = series.iter().map(|s| s.time.len()).collect();
    lengths.sort_unstable_by(|a, b| b.cmp(a));
    let half = lengths.iter().sum::<usize>() / 2;
    let mut samples = 0;
    let usual = lengths.iter().find(|&&n| {
        samples += n;
        samples >= half
    });
    let enough = (usual.copied().unwrap_or(0) / 2).max(least);
    let long = series.iter().filter(|s| s.time.len() >= enough);
    long.map(|s| (&*s.time, &*s.values)).collect()
}

/// Whether each state is sampled at one period, in all of these stretches of the data.
pub(in crate::identify) fn is_uniform(data: &Dataset, stretches: &[Stretch<'_>]) -> bool {
    let states = data.states().len();
    let slow = |i: &usize| stretches.iter().any(|s| s.own_rows(*i).is_some());
    let slow: Vec<usize> = (0..states).filter(slow).collect();
    if slow.is_empty() {
        return data.report().uniform;
    }
    (0..states).all(|i| {
        let series = stretches.iter().map(|s| Series::of(s, i));
        let series = series.filter(|s| s.time.len() > 1);
        let periods: Option<Vec<f64>> = series.map(|s| uniform_period(&s.time)).collect();
        periods.is_some_and(|periods| {
            let mut all = periods.iter();
            all.all(|p| (p / periods[0] - 1.0).abs() < SAME_PERIOD)
        })
    })
}

/// Rows from one sample of a state to the next, in the mean.
pub(super) fn rows_apart(stretches: &[Stretch<'_>], state: usize) -> f64 {
    let (mut rows, mut samples) = (0, 0);
    for s in stretches {
        rows += s.time.len();
        samples += s.own_rows(state).map_or(s.time.len(), |own| own.len());
    }
    rows as f64 / samples.max(1) as f64
}

/// Each state smoothed at its own times by `method`, of state, times and values, and cubics through values and slopes between.
pub(super) fn smoothed(
    stretches: &[Stretch<'_>],
    states: usize,
    method: impl Fn(usize, &[f64], &[f64]) -> Result<Smoothed, SindyError>,
) -> Result<Vec<Vec<Smoothed>>, SindyError> {
    let one = |s: &Stretch<'_>, i: usize| {
        let own = s.own_rows(i).filter(|own| own.len() >= FEWEST);
        let Some(own) = own else {
            return method(i, s.time, s.columns[i]);
        };
        let (time, values) = (pick(s.time, Some(&own)), pick(s.columns[i], Some(&own)));
        Ok(on_rows(s.time, &own, &method(i, &time, &values)?))
    };
    let of = |s: &Stretch<'_>| (0..states).map(|i| one(s, i)).collect();
    stretches.iter().map(of).collect()
}

/// Samples below which a series is smoothed over all rows: no method takes fewer.
const FEWEST: usize = 3;

/// What was smoothed at some rows on all of them: straight on before the first and after the last.
fn on_rows(time: &[f64], own: &[usize], smoothed: &Smoothed) -> Smoothed {
    let (mut value, mut derivative) = (Vec::new(), Vec::new());
    let last = own.len() - 1;
    for (row, t) in time.iter().enumerate() {
        let next = own.partition_point(|&r| r <= row);
        let edge = match next {
            0 => Some(0),
            next if next > last => Some(last),
            _ => None,
        };
        if let Some(k) = edge {
            let slope = smoothed.derivative[k];
            value.push(smoothed.value[k] + slope * (t - time[own[k]]));
            derivative.push(slope);
            continue;
        }
        let (a, b) = (next - 1, next);
        let h = time[own[b]] - time[own[a]];
        let s = (t - time[own[a]]) / h;
        let (from, to) = (smoothed.value[a], smoothed.value[b]);
        let (p, q) = (h * smoothed.derivative[a], h * smoothed.derivative[b]);
        value.push(hermite(from, to, p, q, s));
        // The derivative of the cubic.
        let chord = 6.0 * s * (1.0 - s) * (to - from);
        let ends = (1.0 - s) * (1.0 - 3.0 * s) * p + s * (3.0 * s - 2.0) * q;
        derivative.push((chord + ends) / h);
    }
    Smoothed { value, derivative }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_cubic_at_some_rows_is_the_same_on_all() {
        let time: Vec<f64> = (0..30)
            .map(|k| 0.1 * f64::from(k) + 0.02 * f64::from(k % 3))
            .collect();
        let value = |t: f64| 2.0 - t + t * t - 0.3 * t * t * t;
        let slope = |t: f64| -1.0 + 2.0 * t - 0.9 * t * t;
        let own: Vec<usize> = (1..30).step_by(4).collect();
        let at = |f: &dyn Fn(f64) -> f64| own.iter().map(|&r| f(time[r])).collect();
        let smoothed = Smoothed {
            value: at(&value),
            derivative: at(&slope),
        };
        let all = on_rows(&time, &own, &smoothed);
        for row in 1..=own[own.len() - 1] {
            // A cubic is its own Hermite interpolation, to rounding.
            assert!((all.value[row] - value(time[row])).abs() < 1e-12, "{row}");
            assert!(
                (all.derivative[row] - slope(time[row])).abs() < 1e-12,
                "{row}"
            );
        }
        let before = value(time[1]) + slope(time[1]) * (time[0] - time[1]);
        assert_eq!((all.value[0], all.derivative[0]), (before, slope(time[1])));
    }
}
