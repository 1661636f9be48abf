//! Brings the columns of a topic to the stamps of another.

use super::extract::Series;
use crate::map::Join;
use crate::stamps::increasing;

/// Values are joined over so many median steps of their topic, unless the map says otherwise.
const JOINED_STEPS: f64 = 10.0;
/// No limit is shorter than this, in s.
const SHORTEST_LIMIT_S: f64 = 0.05;
/// Steps back of more than this, in s, that last are a clock set anew.
const RESET_S: f64 = 10.0;
/// Messages in a row that have to go on from a step back.
const LASTING: usize = 5;

/// What was put right in the stamps of a topic.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Repairs {
    pub(super) resets: usize,
    pub(super) dropped: usize,
}

/// Lets time go on where a clock was set back for good, and drops what is still out of order.
/// The clock's own rows are only unwrapped: whoever makes the trial drops and counts them.
pub(super) fn repair(series: &mut Series, is_clock: bool) -> Repairs {
    let resets = unwrap(&mut series.time_s);
    if is_clock {
        return Repairs { resets, dropped: 0 };
    }
    let all: Vec<usize> = (0..series.time_s.len()).collect();
    let kept = increasing(&series.time_s, &all).rows;
    let dropped = all.len() - kept.len();
    if dropped > 0 {
        let pick = |values: &[f64]| kept.iter().map(|&row| values[row]).collect::<Vec<_>>();
        series.time_s = pick(&series.time_s);
        for column in &mut series.columns {
            *column = pick(column);
        }
    }
    Repairs { resets, dropped }
}

/// Where a clock steps back for good, all that follows is shifted so that one median step lies
/// between.
fn unwrap(time_s: &mut [f64]) -> usize {
    let goes_back = |pair: &[f64]| pair[1] < pair[0] - RESET_S;
    if !time_s.windows(2).any(goes_back) {
        return 0;
    }
    let step_s = median_step(time_s).unwrap_or(0.0);
    let mut resets = 0;
    let mut shift_s = 0.0;
    let mut latest_s = f64::NEG_INFINITY;
    for row in 0..time_s.len() {
        let shifted_s = time_s[row] + shift_s;
        let after = &time_s[row..time_s.len().min(row + LASTING)];
        let lasts = after.len() == LASTING
            && after
                .windows(2)
                .all(|p| p[1] >= p[0] && p[1] - p[0] < RESET_S);
        if shifted_s < latest_s - RESET_S && lasts {
            resets += 1;
            shift_s += latest_s + step_s - shifted_s;
        }
        time_s[row] += shift_s;
        // A single stray stamp far ahead is no time to go on from.
        let stray = row + 1 < time_s.len() && time_s[row + 1] + shift_s < time_s[row] - RESET_S;
        let lasting_stray = stray && time_s[row] - latest_s > RESET_S;
        if !lasting_stray {
            latest_s = latest_s.max(time_s[row]);
        }
    }
    resets
}

/// Median of the steps forward.
fn median_step(time_s: &[f64]) -> Option<f64> {
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Over how long values are joined without a word in the map, in s.
pub(super) fn usual_limit_s(time_s: &[f64]) -> f64 {
    let step_s = median_step(time_s).unwrap_or(0.0);
    (JOINED_STEPS * step_s).max(SHORTEST_LIMIT_S)
}

/// The values of a column at the times of a clock; NaN where none is near enough.
pub(super) fn join(
    time_s: &[f64],
    values: &[f64],
    clock_s: &[f64],
    how: Join,
    limit_s: f64,
) -> Vec<f64> {
    let known: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    if known.is_empty() {
        return vec![f64::NAN; clock_s.len()];
    }
    let mut next = 0; // the first known value after t
    let mut latest_s = f64::NEG_INFINITY;
    clock_s
        .iter()
        .map(|&t| {
            if t < latest_s {
                next = known.partition_point(|&i| time_s[i] <= t);
            }
            latest_s = t;
            while next < known.len() && time_s[known[next]] <= t {
                next += 1;
            }
            let before = next.checked_sub(1).map(|at| known[at]);
            let after = known.get(next).copied();
            match (how, before, after) {
                (_, Some(i), _) if time_s[i] == t => values[i],
                (Join::Hold, Some(i), _) if t - time_s[i] <= limit_s => values[i],
                (Join::Linear, Some(i), Some(j)) if time_s[j] - time_s[i] <= limit_s => {
                    let part = (t - time_s[i]) / (time_s[j] - time_s[i]);
                    values[i] + part * (values[j] - values[i])
                }
                _ => f64::NAN,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_hold_and_linear() {
        let (time_s, values) = ([0.0, 1.0, 2.0, 30.0], [0.0, 10.0, f64::NAN, 40.0]);
        let clock_s = [-1.0, 0.0, 0.5, 1.0, 1.5, 2.5, 30.0, 31.0];
        let text = |v: Vec<f64>| format!("{v:?}");
        assert_eq!(
            text(join(&time_s, &values, &clock_s, Join::Linear, 5.0)),
            "[NaN, 0.0, 5.0, 10.0, NaN, NaN, 40.0, NaN]"
        );
        assert_eq!(
            text(join(&time_s, &values, &clock_s, Join::Hold, 1.0)),
            "[NaN, 0.0, 0.0, 10.0, 10.0, NaN, 40.0, 40.0]"
        );
        // Ten median steps of 1 s.
        assert_eq!(usual_limit_s(&time_s), 10.0);
        assert_eq!(join(&time_s, &values, &[11.0], Join::Hold, 10.0), [10.0]);
        assert!(join(&[], &[], &[1.0], Join::Linear, 1.0)[0].is_nan());
    }

    #[test]
    fn analytic_a_clock_set_back_goes_on_and_a_stray_stamp_goes() {
        let mut series = Series {
            time_s: (0..20)
                .map(|i| 0.1 * f64::from(i % 10) + 7200.0 * f64::from(i32::from(i < 10)))
                .collect(),
            columns: vec![(0..20).map(f64::from).collect()],
            absent: 0,
        };
        assert_eq!(
            repair(&mut series, false),
            Repairs {
                resets: 1,
                dropped: 0
            }
        );
        for (i, t) in series.time_s.iter().enumerate() {
            assert!((t - 7200.0 - 0.1 * i as f64).abs() < 1e-9, "{i}: {t}");
        }
        series.time_s[4] = 1e6;
        assert_eq!(
            repair(&mut series, false),
            Repairs {
                resets: 0,
                dropped: 1
            }
        );
        assert_eq!(series.columns[0].len(), 19);
        assert_eq!(series.columns[0][4], 5.0);
    }
}
