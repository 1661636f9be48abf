//! Interpolates the columns of a topic at the stamps of another.

use super::extract::{Series, Values};
use super::resets::{median_step, unwrap};
use crate::map::Join;
use crate::tables::stamps::{increasing, is_increasing};
use std::rc::Rc;

/// Longest interval over which values are interpolated, in median steps of their topic, unless the map
/// sets a limit. Half of it turns jitter of a slow topic into gaps; twice of it bridges real gaps.
const JOINED_STEPS: f64 = 10.0;
/// Least such limit, s. Below it, a topic at 1 kHz would have gaps whenever the logger pauses.
const SHORTEST_LIMIT_S: f64 = 0.05;

/// Repairs of the stamps of a topic.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Repairs {
    pub(super) resets: usize,
    pub(super) dropped: usize,
}

/// Shifts the stamps after a clock was set back permanently, and drops messages that are still out of
/// order. The clock's own rows are only shifted; the code that makes the trial drops and counts them.
pub(super) fn repair(series: &mut Series, is_clock: bool) -> Repairs {
    let resets = unwrap(&mut series.time_s);
    if is_clock || is_increasing(&series.time_s) {
        return Repairs { resets, dropped: 0 };
    }
    let all: Vec<usize> = (0..series.time_s.len()).collect();
    let kept = increasing(&series.time_s, &all).rows;
    let dropped = all.len() - kept.len();
    series.pick(&kept);
    Repairs { resets, dropped }
}

/// The longest interval of interpolation without a limit in the map, s.
pub(super) fn usual_limit_s(time_s: &[f64]) -> f64 {
    let step_s = median_step(time_s).unwrap_or(0.0);
    (JOINED_STEPS * step_s).max(SHORTEST_LIMIT_S)
}

/// Neighbouring stamps of a topic for each stamp of a clock, block by block.
#[derive(Debug)]
pub(super) struct Stamps {
    time_s: Rc<Vec<f64>>,
    how: Join,
    limit_s: f64,
    /// The first stamp after the clock's latest.
    next: usize,
    latest_s: f64,
    /// For each stamp of the block: the index of the value before it, and the fraction of the interval
    /// to the next value. The index is `usize::MAX` if no value is near enough.
    places: Vec<(usize, f64)>,
    /// Number of the block.
    block: Option<usize>,
}

impl Stamps {
    pub(super) fn new(time_s: Rc<Vec<f64>>, how: Join, limit_s: f64) -> Self {
        Self {
            time_s,
            how,
            limit_s,
            next: 0,
            latest_s: f64::NEG_INFINITY,
            places: Vec::new(),
            block: None,
        }
    }

    /// Goes on to a block of the clock, that with this number.
    pub(super) fn locate(&mut self, block: usize, clock_s: &[f64]) {
        if self.block == Some(block) {
            return;
        }
        self.block = Some(block);
        self.places.clear();
        let time_s = &self.time_s;
        for &t in clock_s {
            if t < self.latest_s {
                self.next = time_s.partition_point(|&stamp| stamp <= t);
            }
            let before = self.next;
            self.latest_s = t;
            while self.next < time_s.len() && time_s[self.next] <= t {
                self.next += 1;
            }
            let place = match self.next.checked_sub(1) {
                Some(i) if self.how == Join::Once => {
                    let is_new = i >= before && t - time_s[i] <= self.limit_s;
                    (if is_new { i } else { usize::MAX }, 0.0)
                }
                Some(i) if time_s[i] == t => (i, 0.0),
                Some(i) if self.how == Join::Hold && t - time_s[i] <= self.limit_s => (i, 0.0),
                Some(i) if self.how == Join::Linear && self.next < time_s.len() => {
                    let step_s = time_s[self.next] - time_s[i];
                    if step_s <= self.limit_s {
                        (i, (t - time_s[i]) / step_s)
                    } else {
                        (usize::MAX, 0.0)
                    }
                }
                _ => (usize::MAX, 0.0),
            };
            self.places.push(place);
        }
    }

    /// The values of a column at the block's stamps, gaps as they are; NaN as well where none is
    /// near enough.
    pub(super) fn join(&self, values: &Values, into: &mut [f64]) {
        match values {
            Values::Narrow(values) => self.join_by(|i| values[i].into(), into),
            Values::Wide(values) => self.join_by(|i| values[i], into),
        }
    }

    fn join_by(&self, value: impl Fn(usize) -> f64, into: &mut [f64]) {
        for (&(i, part), into) in self.places.iter().zip(into) {
            *into = match i {
                usize::MAX => f64::NAN,
                i if part == 0.0 => value(i),
                i => {
                    let before = value(i);
                    before + part * (value(i + 1) - before)
                }
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(known: &[(f64, f64)], clock_s: &[f64], how: Join, limit_s: f64) -> String {
        let mut values = Values::default();
        known.iter().for_each(|&(_, value)| values.push(value));
        let time_s = known.iter().map(|&(t, _)| t).collect();
        let mut stamps = Stamps::new(Rc::new(time_s), how, limit_s);
        let mut all = Vec::new();
        // In blocks of three.
        for (block, clock_s) in clock_s.chunks(3).enumerate() {
            let mut into = vec![0.0; clock_s.len()];
            stamps.locate(block, clock_s);
            stamps.join(&values, &mut into);
            all.extend(into);
        }
        format!("{all:?}")
    }

    #[test]
    fn analytic_hold_and_linear() {
        let known = [(0.0, 0.0), (1.0, 10.0), (30.0, 40.0)];
        let clock_s = [-1.0, 0.0, 0.5, 1.0, 1.5, 2.5, 30.0, 31.0];
        assert_eq!(
            joined(&known, &clock_s, Join::Linear, 5.0),
            "[NaN, 0.0, 5.0, 10.0, NaN, NaN, 40.0, NaN]"
        );
        assert_eq!(
            joined(&known, &clock_s, Join::Hold, 1.0),
            "[NaN, 0.0, 0.0, 10.0, 10.0, NaN, 40.0, 40.0]"
        );
        // Each value in the first row from its stamp on; that of 30 is more than 0.5 s older than its row.
        assert_eq!(
            joined(&known, &[0.0, 0.5, 1.2, 1.4, 2.5, 30.6], Join::Once, 0.5),
            "[0.0, NaN, 10.0, NaN, NaN, NaN]"
        );
        // A clock that goes back.
        assert_eq!(
            joined(&known, &[11.0, 0.5, 1.5, 0.75], Join::Hold, 10.0),
            "[10.0, 0.0, 10.0, 0.0]"
        );
        assert_eq!(joined(&[], &[1.0], Join::Linear, 1.0), "[NaN]");
        // Ten median steps of 1 s.
        assert_eq!(usual_limit_s(&[0.0, 1.0, 2.0, 30.0]), 10.0);
    }

    #[test]
    fn analytic_a_clock_set_back_goes_on_and_a_stray_stamp_goes() {
        let mut series = Series {
            time_s: (0..20)
                .map(|i| 0.1 * f64::from(i % 10) + 7200.0 * f64::from(i32::from(i < 10)))
                .collect(),
            columns: vec![Values::Wide((0..20).map(f64::from).collect())],
            ..Series::default()
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
        assert_eq!(series.columns[0].get(4), 5.0);
    }
}
