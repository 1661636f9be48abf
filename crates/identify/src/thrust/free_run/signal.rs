//! A command between its samples, and its exact first-order lag with a dead time of any size.

use sindy::trajectory::delay::{Decay, first_order_lag};

/// Share of steps without a change from which a throttle holds its values.
/// Held commands stand still for nearly all steps, measured ones for hardly any: any share between decides alike.
const STILL: f64 = 0.5;
/// A change is at least this share of the throttle's standard deviation, or it is the last digit of a slope.
/// Twice the value takes fine staircases for slopes.
const JUMP: f64 = 0.05;

/// Bend of a throttle (see [`bend`]) up to which it is smooth: a sine with six samples in its period. No straight lines show a
/// faster one, and a random one that is new in every sample bends by 2 to 3.
pub(super) const SMOOTH: f64 = 1.0;

/// Twice the logarithm of a ratio of likelihoods that is very strong evidence (Kass & Raftery, "Bayes Factors", 1995): odds of 150 to
/// 1. Chance does not reach it where commands change at samples.
const VERY_STRONG: f64 = 10.0;

/// What a throttle is between its samples.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Between {
    /// The last sample's value (zero-order hold).
    Held,
    /// A straight line.
    Linear,
}

impl Between {
    /// What the samples of throttles look like.
    pub(crate) fn of<'a>(throttles: impl IntoIterator<Item = &'a [f64]> + Clone) -> Self {
        let (mut rows, mut sum, mut square) = (0.0, 0.0, 0.0);
        let (mut steps, mut jumps) = (0_usize, Vec::new());
        for s in throttles.clone() {
            rows += s.len() as f64;
            sum += s.iter().sum::<f64>();
            square += s.iter().map(|v| v * v).sum::<f64>();
            steps += s.len().saturating_sub(1);
            jumps.extend(changes(s).into_iter().map(f64::abs));
        }
        let sd = (square / rows - (sum / rows).powi(2)).max(0.0).sqrt();
        let still = 1.0 - jumps.len() as f64 / steps.max(1) as f64;
        let jump = crate::thrust::plateau::median(jumps.into_iter()).unwrap_or(0.0);
        if still >= STILL && jump > JUMP * sd || bend(throttles) > SMOOTH {
            Self::Held
        } else {
            Self::Linear
        }
    }

    /// What a throttle that looks held is, by the squares of the errors of both over so many rows.
    pub(in crate::thrust) fn likelier(held: f64, lines: f64, rows: usize) -> Self {
        let evidence = rows as f64 * (held - lines) / held;
        if evidence > VERY_STRONG {
            Self::Linear
        } else {
            Self::Held
        }
    }

    /// How much shorter and longer than found a dead time may be (s), because a log of this period does not know when in it a
    /// command changed. That errs alike at every change, and is added, not averaged. What is logged as held may have changed at any
    /// time since the sample before.
    pub(in crate::thrust) fn clock_s(self, period_s: f64) -> [f64; 2] {
        match self {
            Self::Held => [0.5 * period_s, period_s],
            Self::Linear => [0.5 * period_s; 2],
        }
    }
}

/// Changes between samples, where there are any.
fn changes(samples: &[f64]) -> Vec<f64> {
    let all = samples.windows(2).map(|w| w[1] - w[0]);
    all.filter(|c| *c != 0.0).collect()
}

/// How much throttles bend between samples: the mean square of the changes of their changes, over that of the changes. It is
/// `(ω P)²` of a sine of angular frequency ω at a short sampling period P, and 3 of white noise.
pub(crate) fn bend<'a>(throttles: impl IntoIterator<Item = &'a [f64]>) -> f64 {
    let (mut square, mut bends) = (0.0, 0.0);
    for s in throttles {
        let changes = changes(s);
        square += changes.iter().map(|c| c * c).sum::<f64>();
        let pairs = changes.windows(2);
        bends += pairs.map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
    }
    bends / square
}

/// `τ y' = u(t - d) - y` from `y = u` at the start, exact for held and for linear `u`.
/// A lag of 0 is the pure delay.
pub(crate) fn lagged(
    time: &[f64],
    values: &[f64],
    between: Between,
    lag_s: f64,
    dead_time_s: f64,
) -> Vec<f64> {
    match between {
        Between::Held => first_order_lag(time, values, lag_s, dead_time_s),
        Between::Linear => linear_lag(time, values, lag_s, dead_time_s),
    }
}

fn linear_lag(time: &[f64], values: &[f64], lag_s: f64, dead_time_s: f64) -> Vec<f64> {
    let Some(&first) = values.first() else {
        return Vec::new();
    };
    let n = time.len();
    let mut out = Vec::with_capacity(n);
    out.push(first);
    let mut y = first;
    let mut decay = Decay::new(lag_s);
    // The sample that the delayed command has reached; none before the first one arrives.
    let mut at: Option<usize> = None;
    for pair in time.windows(2) {
        let (mut now, end) = (pair[0], pair[1]);
        while now < end {
            let (u, slope, until) = match at {
                None => (first, 0.0, time[0] + dead_time_s),
                Some(k) if k + 1 < n => {
                    let slope = (values[k + 1] - values[k]) / (time[k + 1] - time[k]);
                    let since = now - time[k] - dead_time_s;
                    (values[k] + slope * since, slope, time[k + 1] + dead_time_s)
                }
                Some(k) => (values[k], 0.0, f64::INFINITY),
            };
            let to = end.min(until).max(now);
            let late = slope * lag_s;
            // The lag's answer to a command that starts at `u` and rises with `slope`.
            y = u + slope * (to - now) - late + (y - u + late) * decay.over(to - now);
            now = to;
            if until <= end {
                at = Some(at.map_or(0, |k| k + 1));
            }
        }
        out.push(y);
    }
    out
}

/// The rows of a record with those added at which a held and delayed command changes, so that straight lines between
/// rows are the held command: times, values, and the row of the record for each (none for added ones).
pub(crate) fn unfolded(
    time: &[f64],
    values: &[f64],
    dead_time_s: f64,
) -> (Vec<f64>, Vec<f64>, Vec<Option<usize>>) {
    // A change takes this share of the shortest period: below what any integration resolves.
    const EDGE: f64 = 1e-6;
    let shortest = time
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(f64::INFINITY, f64::min);
    let edge = EDGE * shortest;
    let mut rows: Vec<(f64, Option<usize>)> = time
        .iter()
        .enumerate()
        .map(|(i, t)| (*t, Some(i)))
        .collect();
    for k in 1..time.len() {
        if values[k] != values[k - 1] {
            let at = time[k] + dead_time_s;
            rows.extend([(at - edge, None), (at, None)]);
        }
    }
    rows.retain(|(t, _)| *t <= time[time.len() - 1]);
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Of rows at one time, that of the record stays.
    rows.dedup_by(|b, a| {
        let same = b.0 - a.0 < 0.5 * edge;
        if same {
            a.1 = a.1.or(b.1);
        }
        same
    });
    let times: Vec<f64> = rows.iter().map(|r| r.0).collect();
    let mut next = 0;
    let mut held = values[0];
    let values = times
        .iter()
        .map(|t| {
            while next < time.len() && time[next] + dead_time_s <= t + 0.25 * edge {
                held = values[next];
                next += 1;
            }
            held
        })
        .collect();
    (times, values, rows.into_iter().map(|r| r.1).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lag_of_a_ramp_between_and_at_samples() {
        // u = t from t = 0: y = t' - τ (1 - e^(-t'/τ)) with t' = t - d.
        let (lag, dead) = (0.07, 0.033);
        let time: Vec<f64> = (0..200).map(|i| 0.02 * f64::from(i)).collect();
        let y = lagged(&time, &time, Between::Linear, lag, dead);
        for (t, y) in time.iter().zip(&y) {
            let since = (t - dead).max(0.0);
            let expected = since - lag * (1.0 - (-since / lag).exp());
            // Rounding of a few hundred steps.
            assert!((y - expected).abs() < 1e-12, "{t}: {y} {expected}");
        }
        let pure = lagged(&time, &time, Between::Linear, 0.0, dead);
        assert!((pure[100] - (2.0 - dead)).abs() < 1e-12);
    }

    #[test]
    fn analytic_samples_say_what_is_between_them() {
        let steps: Vec<f64> = (0..300).map(|i| f64::from(i / 30 % 4)).collect();
        assert_eq!(Between::of([steps.as_slice()]), Between::Held);
        let sine: Vec<f64> = (0..300).map(|i| (0.05 * f64::from(i)).sin()).collect();
        assert_eq!(Between::of([sine.as_slice()]), Between::Linear);
        let digits: Vec<f64> = (0..3000).map(|i| f64::from(i / 3)).collect();
        assert_eq!(Between::of([digits.as_slice()]), Between::Linear);
        // New in every sample: squares modulo a prime are as good as random.
        let random: Vec<f64> = (0..300_u32).map(|n| f64::from(n * n % 97) / 97.0).collect();
        assert_eq!(Between::of([random.as_slice()]), Between::Held);
    }

    #[test]
    fn analytic_bend_of_a_sine_and_of_a_ramp() {
        // The changes of a sine are (ω P) cos: the mean square of their changes is 4 sin²(ω P/2) of theirs.
        let sine: Vec<f64> = (0..6000).map(|i| (0.5 * f64::from(i)).sin()).collect();
        let expected = 4.0 * 0.25_f64.sin().powi(2);
        // The ends of 6000 samples.
        assert!((bend([sine.as_slice()]) / expected - 1.0).abs() < 1e-3);
        let ramp: Vec<f64> = (0..300).map(|i| f64::from(i / 3)).collect();
        assert_eq!(bend([ramp.as_slice()]), 0.0);
    }

    #[test]
    fn analytic_unfolded_rows_hold_a_delayed_command() {
        let time: Vec<f64> = (0..6).map(|i| 0.1 * f64::from(i)).collect();
        let (t, u, row) = unfolded(&time, &[1.0, 1.0, 2.0, 2.0, 2.0, 2.0], 0.05);
        // The change of 0.2 s arrives at 0.25 s, between two rows of the record.
        assert_eq!(row.iter().flatten().count(), 6);
        for (t, u) in t.iter().zip(&u) {
            assert_eq!(*u, if *t < 0.25 - 1e-9 { 1.0 } else { 2.0 }, "{t}");
        }
        assert!(t.windows(2).all(|w| w[1] > w[0]));
        // Without dead time, the change stands at a row.
        let (t, u, _) = unfolded(&time, &[1.0, 1.0, 2.0, 2.0, 2.0, 2.0], 0.0);
        assert_eq!((t.len(), u[2], u[3]), (7, 1.0, 2.0));
    }
}
