//! Finds where clocks of a log were set back, and shifts the later stamps of all topics.

use super::extract::Series;
use std::collections::BTreeMap;

/// Least permanent step back of a clock that was set back, s. Messages out of order are late by less;
/// a vehicle that restarts sets its clock back by more.
pub(super) const RESET_S: f64 = 10.0;
/// Number of successive messages that must continue from the earlier time. A single stray stamp must
/// not shift the rest of the log.
const LASTING: usize = 5;

/// A row from which on a topic's stamps are shifted further.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reset {
    row: usize,
    shift_s: f64,
}

/// Shifts the stamps of all topics where those of one topic were set back permanently. The shift puts
/// one median step between that topic's rows, and is the same for all topics, so that simultaneous
/// messages stay simultaneous. Returns the number of shifts.
pub(super) fn align(series: &mut BTreeMap<String, Series>, by: &str) -> usize {
    let Some(first) = series.get_mut(by) else {
        return 0;
    };
    let resets = find(&mut first.time_s);
    let breaks = std::mem::take(&mut first.breaks);
    // The place in the file, as a row of each topic.
    let places: Vec<Option<usize>> = resets
        .iter()
        .map(|reset| breaks.iter().rposition(|&row| row == reset.row))
        .collect();
    for (_, other) in series.iter_mut().filter(|(key, _)| *key != by) {
        let backs: Vec<usize> = backs(&other.time_s).collect();
        let starts: Vec<(usize, f64)> = resets
            .iter()
            .zip(&places)
            .filter_map(|(reset, place)| {
                let about = *other.breaks.get((*place)?)?;
                Some((start(&other.time_s, &backs, about), reset.shift_s))
            })
            .collect();
        for (row, shift_s) in starts {
            other.time_s[row..].iter_mut().for_each(|t| *t += shift_s);
        }
    }
    resets.len()
}

/// The row near this one at which a topic's stamps are set back.
fn start(time_s: &[f64], backs: &[usize], about: usize) -> usize {
    let is_near = |row: &usize| {
        let between = &time_s[about.min(*row)..about.max(*row)];
        let ends = between.first().zip(between.last());
        ends.is_none_or(|(first, last)| (last - first).abs() < RESET_S)
    };
    let near = backs.iter().copied().filter(is_near);
    near.min_by_key(|row| row.abs_diff(about)).unwrap_or(about)
}

/// Rows whose stamp is far before that of the previous row.
fn backs(time_s: &[f64]) -> impl Iterator<Item = usize> {
    let pairs = time_s.windows(2).enumerate();
    pairs.filter_map(|(row, pair)| (pair[1] < pair[0] - RESET_S).then_some(row + 1))
}

/// Shifts the later stamps of one topic after each permanent step back, so that one median step lies
/// between. Returns the number of shifts.
pub(super) fn unwrap(time_s: &mut [f64]) -> usize {
    find(time_s).len()
}

fn find(time_s: &mut [f64]) -> Vec<Reset> {
    let mut resets = Vec::new();
    if backs(time_s).next().is_none() {
        return resets;
    }
    let step_s = median_step(time_s).unwrap_or(0.0);
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
            let by_s = latest_s + step_s - shifted_s;
            resets.push(Reset { row, shift_s: by_s });
            shift_s += by_s;
        }
        time_s[row] += shift_s;
        // The log must not continue from a single stray stamp far ahead.
        let stray = row + 1 < time_s.len() && time_s[row + 1] + shift_s < time_s[row] - RESET_S;
        let lasting_stray = stray && time_s[row] - latest_s > RESET_S;
        if !lasting_stray {
            latest_s = latest_s.max(time_s[row]);
        }
    }
    resets
}

/// Median of the steps forward.
pub(super) fn median_step(time_s: &[f64]) -> Option<f64> {
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_all_topics_go_on_by_one_shift() {
        // Set back by an hour at 100 s: 100 Hz, 2 Hz, one message before, one topic after.
        let at = |t: f64| if t < 100.0 { t + 4000.0 } else { t + 400.0 };
        let times = |from_s: f64, step_s: f64, n: i32| -> Vec<f64> {
            (0..n).map(|i| from_s + step_s * f64::from(i)).collect()
        };
        // Each at its own phase again after it.
        let quick = times(90.0, 0.01, 2000);
        let slow = [times(90.2, 0.5, 20), times(100.05, 0.5, 20)].concat();
        let of = |times: Vec<f64>, breaks: usize| Series {
            time_s: times.into_iter().map(at).collect(),
            breaks: vec![breaks],
            ..Series::default()
        };
        let mut series = BTreeMap::from([
            ("imu".to_owned(), of(quick.clone(), 1000)),
            // The slow one's first message after comes before the quick one's in the file.
            ("range".to_owned(), of(slow.clone(), 21)),
            ("home".to_owned(), of(vec![91.0], 1)),
            ("late".to_owned(), of(vec![101.0, 102.0], 0)),
        ]);
        assert_eq!(align(&mut series, "imu"), 1);
        let expect: [(&str, Vec<f64>); 4] = [
            ("imu", quick),
            ("range", slow),
            ("home", vec![91.0]),
            ("late", vec![101.0, 102.0]),
        ];
        for (key, times) in expect {
            for (found, t) in series[key].time_s.iter().zip(times) {
                // Rounding of stamps of 4000 s.
                assert!((found - 4000.0 - t).abs() < 1e-9, "{key}: {found}, {t}");
            }
        }
        // Nothing set back, nothing moved.
        assert_eq!(align(&mut series, "range"), 0);
    }
}
