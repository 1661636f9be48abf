//! Plateaus: stretches of constant throttle in which the thrust has settled.

use touchdown_trial::Trial;

use crate::error::Result;

/// Seconds that a plateau must last beyond its settling time.
/// Ten readings at 50 Hz, whose median is known to 0.4 of their noise.
const LEAST_S: f64 = 0.2;

/// A steady point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plateau {
    /// Throttle.
    pub throttle: f64,
    /// Median thrust (N).
    pub thrust_n: f64,
    /// Median battery voltage (V), where it was measured.
    pub battery_v: Option<f64>,
    /// Start of the step (s).
    pub start_s: f64,
    /// Whether throttle came down to this level.
    pub descending: bool,
}

/// Finds the plateaus of a trial with `throttle` and `thrust_n`: medians from `settle_s` after each step.
///
/// # Errors
/// A missing channel.
pub fn find(trial: &Trial, settle_s: f64) -> Result<Vec<Plateau>> {
    let throttle = super::throttle(trial)?;
    let (time, thrust) = (trial.time_s(), trial.require("thrust_n")?);
    let battery = trial.channel("battery_v");
    let period_s = trial.period_s().unwrap_or(0.0);
    let rows: Vec<usize> = (0..time.len())
        .filter(|&i| throttle[i].is_finite())
        .collect();
    let mut out = Vec::new();
    let mut last: Option<f64> = None;
    for run in rows.chunk_by(|&a, &b| throttle[a] == throttle[b]) {
        let level = throttle[run[0]];
        let descending = last.is_some_and(|l| level < l);
        last = Some(level);
        let start = time[run[0]];
        if !settles(held_s(time, run, period_s), settle_s) {
            continue;
        }
        let settled = || run.iter().copied().filter(|&i| time[i] - start >= settle_s);
        let Some(thrust_n) = median(settled().map(|i| thrust[i])) else {
            continue;
        };
        let battery_v = battery.and_then(|b| median(settled().map(|i| b[i])));
        out.push(Plateau {
            throttle: level,
            thrust_n,
            battery_v,
            start_s: start,
            descending,
        });
    }
    Ok(out)
}

/// The rows of a trial, each taken as one steady point.
///
/// # Errors
/// A missing channel.
pub fn rows(trial: &Trial) -> Result<Vec<Plateau>> {
    let throttle = super::throttle(trial)?;
    let (time, thrust) = (trial.time_s(), trial.require("thrust_n")?);
    let battery = trial.channel("battery_v");
    let (mut last, mut descending) = (f64::NAN, false);
    let mut out = Vec::new();
    for i in 0..time.len() {
        if !throttle[i].is_finite() {
            continue;
        }
        // Rows of one level keep the direction in which it was reached.
        if throttle[i] != last {
            descending = throttle[i] < last;
            last = throttle[i];
        }
        if thrust[i].is_finite() {
            out.push(Plateau {
                throttle: throttle[i],
                thrust_n: thrust[i],
                battery_v: battery.map(|b| b[i]).filter(|v| v.is_finite()),
                start_s: time[i],
                descending,
            });
        }
    }
    Ok(out)
}

/// Rows of one throttle from which on they are a step, not points of a table or of a ramp.
const STEP_ROWS: usize = 3;
/// If a throttle goes through more than this share of its range while the thrust settles, no row is at rest. A lag of 0.1 s shifts
/// the throttle by a fortieth of its range then. A ramp over the range in 5 s is slower.
const RESTLESS: f64 = 0.2;

/// The median time for which throttle stays (s), of a trial in which it stays too short for the thrust to settle: its rows are no
/// steady points.
///
/// # Errors
/// A missing channel.
pub fn unsettled(trial: &Trial, settle_s: f64) -> Result<Option<f64>> {
    let throttle = super::throttle(trial)?;
    let time = trial.time_s();
    let rows: Vec<usize> = (0..time.len())
        .filter(|&i| throttle[i].is_finite())
        .collect();
    let runs: Vec<&[usize]> = rows.chunk_by(|&a, &b| throttle[a] == throttle[b]).collect();
    let steps: Vec<&[usize]> = runs
        .iter()
        .copied()
        .filter(|run| run.len() >= STEP_ROWS)
        .collect();
    let in_steps: usize = steps.iter().map(|run| run.len()).sum();
    let period_s = trial.period_s().unwrap_or(0.0);
    let stays_s = |runs: &[&[usize]]| median(runs.iter().map(|run| held_s(time, run, period_s)));
    let of_steps = stays_s(&steps).filter(|_| 2 * in_steps > rows.len());
    let stays_s = of_steps.or_else(|| {
        let restless = moves(&throttle, time, &rows, settle_s)? > RESTLESS;
        stays_s(&runs).filter(|_| restless)
    });
    Ok(stays_s.filter(|&stays_s| !settles(stays_s, settle_s)))
}

/// Median share of its range that a throttle goes through within a time (s).
fn moves(throttle: &[f64], time: &[f64], rows: &[usize], within_s: f64) -> Option<f64> {
    let span = |rows: &[usize]| {
        let [low, high] = crate::fitted::range(rows.iter().map(|&i| throttle[i]))?;
        Some(high - low)
    };
    let from_s = time[*rows.first()?];
    let window = |i: usize| ((time[i] - from_s) / within_s).floor();
    let windows = rows.chunk_by(|&a, &b| window(a) == window(b));
    let all = span(rows)?;
    median(windows.filter_map(span).map(|part| part / all))
}

/// Time for which the throttle of a run of rows is held (s): also for the period that its last row begins.
fn held_s(time: &[f64], run: &[usize], period_s: f64) -> f64 {
    time[run[run.len() - 1]] - time[run[0]] + period_s
}

/// Whether the thrust settles in that time, and leaves enough to read. Stamps of a clock err by some of their last digits.
fn settles(held_s: f64, settle_s: f64) -> bool {
    held_s > (settle_s + LEAST_S) * (1.0 - 1e-3)
}

/// The first and the ninth decile of the finite values, which gross outliers hardly move; none without a value.
pub(crate) fn tenths(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let mut v: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    v.sort_by(f64::total_cmp);
    Some([*v.get(v.len() / 10)?, *v.get(v.len() * 9 / 10)?])
}

/// Median of the finite values.
#[must_use]
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut v: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    let n = v.len();
    if n == 0 {
        return None;
    }
    let (below, upper, _) = v.select_nth_unstable_by(n / 2, f64::total_cmp);
    match n.is_multiple_of(2) {
        true => Some(0.5 * (below.iter().copied().fold(f64::NEG_INFINITY, f64::max) + *upper)),
        false => Some(*upper),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn analytic_staircase_with_gaps_gives_its_medians() {
        let time: Vec<f64> = (0..600).map(|i| 0.01 * f64::from(i)).collect();
        let level = |i: usize| [0.2, 0.4, 0.3][i / 200];
        let throttle = (0..600).map(level).collect();
        // Thrust only every 15th row, an overshoot in the first half second of each level.
        let thrust = (0..600)
            .map(|i| match i % 15 {
                0 if i % 200 < 50 => 99.0,
                0 => 10.0 * level(i),
                _ => f64::NAN,
            })
            .collect();
        let trial = Trial::new("steps", time)
            .unwrap()
            .with_channel("throttle", throttle)
            .unwrap()
            .with_channel("thrust_n", thrust)
            .unwrap();
        let found = find(&trial, 0.8).unwrap();
        let expected = [(0.2, 2.0, false), (0.4, 4.0, false), (0.3, 3.0, true)];
        assert_eq!(found.len(), 3);
        for (p, (s, t, down)) in found.iter().zip(expected) {
            assert_eq!((p.throttle, p.thrust_n, p.descending), (s, t, down));
        }
    }

    #[test]
    fn analytic_a_throttle_that_does_not_rest_differs_from_plateaus_ramps_and_tables() {
        let rows = |period_s: f64, throttle: &dyn Fn(u32) -> f64| {
            let time = (0..600).map(|i| period_s * f64::from(i)).collect();
            let trial = Trial::new("log", time).unwrap();
            let throttle = (0..600).map(throttle).collect();
            unsettled(&trial.with_channel("throttle", throttle).unwrap(), 0.8).unwrap()
        };
        let steps = |of: u32| move |i: u32| f64::from((7 * (i / of)) % 11) / 11.0;
        // Ten rows at 20 Hz.
        let held_s = rows(0.05, &steps(10)).unwrap();
        assert!((held_s - 0.5).abs() < 1e-9);
        assert_eq!(rows(0.05, &steps(30)), None);
        // A second, 0.8 s to settle and 0.2 s to read, is enough at every rate.
        for of in [5, 10, 20, 100] {
            assert_eq!(rows(1.0 / f64::from(of), &steps(of)), None, "{of}");
            assert!(rows(0.98 / f64::from(of), &steps(of)).is_some(), "{of}");
        }
        assert_eq!(rows(0.05, &|i| f64::from(i) / 600.0), None);
        // A table of points that were measured twice, a second apart, is at rest; at 10 Hz it is no table.
        assert_eq!(rows(1.0, &steps(2)), None);
        // Times have rounding errors.
        let stays = |of: u32| rows(0.1, &steps(of)).unwrap();
        assert!((stays(2) - 0.2).abs() < 1e-9);
        // New in every row, a sine of 2 s, and a slow one.
        assert!((stays(1) - 0.1).abs() < 1e-9);
        let sine = |period_s: f64| move |i: u32| (0.1 * f64::from(i) / period_s * TAU).sin();
        assert!(rows(0.1, &sine(2.0)).is_some());
        assert_eq!(rows(0.1, &sine(20.0)), None);
    }
}
