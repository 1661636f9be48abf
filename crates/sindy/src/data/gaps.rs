//! Trajectories with gaps: missing rows and holes in time split them.
//!
//! No differentiator may look across a gap. [`segments`] finds the stretches without one and counts what it
//! leaves out, so that nothing is dropped in silence.

use std::ops::Range;

use crate::error::{SindyError, require, same_size};
use crate::numerics::{nearest_quantile, upper_median};

/// How a trajectory is split, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSettings {
    hole: f64,
    shortest: usize,
}

/// A time step longer than this multiple of the longer steps is a gap. Exponentially random steps exceed it once in eight
/// thousand; at half the value, a single missing row splits a record.
const HOLE: f64 = 3.0;

/// The stretches of a trajectory without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segments {
    /// Row ranges without a missing row or a hole, in order, each at least as long as asked for.
    pub ranges: Vec<Range<usize>>,
    /// Rows in which the time or any column is NaN.
    pub missing_rows: usize,
    /// Steps of time, between rows that follow each other, that were too long.
    pub holes: usize,
    /// Stretches that were shorter than asked for and were left out.
    pub short: usize,
    /// Rows in those stretches.
    pub short_rows: usize,
}

impl Default for GapSettings {
    /// Steps above 3 median periods are holes; stretches of any length are kept.
    fn default() -> Self {
        Self {
            hole: 3.0,
            shortest: 1,
        }
    }
}

impl GapSettings {
    /// The default of [`crate::Dataset`]: a gap is a time step above three times the 95th percentile of all steps, so that
    /// uneven and random sampling has no gaps. Stretches of fewer than `shortest` rows are dropped.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn usual(time: &[f64], shortest: usize) -> Result<Self, SindyError> {
        let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        steps.retain(|s| *s > 0.0);
        let hole = HOLE * nearest_quantile(&mut steps, 0.95) / nearest_quantile(&mut steps, 0.5);
        // Not finite where there are no steps.
        Self::new(
            if hole.is_finite() {
                hole.max(HOLE)
            } else {
                HOLE
            },
            shortest,
        )
    }

    /// A step longer than `hole` median periods splits; stretches of fewer than `shortest` rows are left out.
    ///
    /// # Errors
    /// A `hole` that is not above 1 (infinity: time never splits), or no `shortest` row.
    pub fn new(hole: f64, shortest: usize) -> Result<Self, SindyError> {
        require(hole > 1.0, "hole", "above 1 median period", hole)?;
        require(shortest != 0, "shortest", "at least 1 row", shortest)?;
        Ok(Self { hole, shortest })
    }

    /// The longest step of these times that is no gap.
    pub(crate) fn longest(&self, time: &[f64]) -> f64 {
        self.longest_of(time.windows(2).map(|w| w[1] - w[0]).collect())
    }

    fn longest_of(&self, mut steps: Vec<f64>) -> f64 {
        upper_median(&mut steps).map_or(f64::INFINITY, |step| self.hole * step)
    }
}

/// Splits a trajectory at rows in which `time` or any of `columns` is NaN, and at holes in time.
///
/// The period is the median step between rows that follow each other and are both there.
///
/// # Errors
/// Columns whose length is not that of `time`, infinite values, times that do not increase over the rows
/// that are there.
pub fn segments(
    time: &[f64],
    columns: &[&[f64]],
    settings: GapSettings,
) -> Result<Segments, SindyError> {
    let n = time.len();
    for (index, column) in std::iter::once(&time).chain(columns).enumerate() {
        same_size("rows of a column", n, column.len())?;
        if let Some(row) = column.iter().position(|v| v.is_infinite()) {
            let what = match index {
                0 => "time".into(),
                c => format!("column {}", c - 1),
            };
            return Err(SindyError::NotFinite { what, index: row });
        }
    }
    let mut there: Vec<bool> = time.iter().map(|t| !t.is_nan()).collect();
    for column in columns {
        for (there, v) in there.iter_mut().zip(*column) {
            *there &= !v.is_nan();
        }
    }
    let mut last = f64::NEG_INFINITY;
    for (index, &t) in time.iter().enumerate().filter(|(_, t)| !t.is_nan()) {
        if !(t > last) {
            return Err(SindyError::TimeNotIncreasing { index });
        }
        last = t;
    }
    let steps = (1..n)
        .filter(|&i| there[i] && there[i - 1])
        .map(|i| time[i] - time[i - 1]);
    let longest = settings.longest_of(steps.collect());
    let mut out = Segments {
        ranges: Vec::new(),
        missing_rows: there.iter().filter(|t| !**t).count(),
        holes: 0,
        short: 0,
        short_rows: 0,
    };
    let mut start = None;
    for i in 0..=n {
        let here = i < n && there[i];
        let hole = here && start.is_some() && time[i] - time[i - 1] > longest;
        out.holes += usize::from(hole);
        if let Some(s) = start
            && (!here || hole)
        {
            if i - s >= settings.shortest {
                out.ranges.push(s..i);
            } else {
                out.short += 1;
                out.short_rows += i - s;
            }
            start = None;
        }
        if here && start.is_none() {
            start = Some(i);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn analytic_nan_and_holes_split_and_are_counted() {
        let nan = f64::NAN;
        let time = [0.0, 1.0, 2.0, 3.0, 4.0, 10.0, 11.0, nan, 13.0];
        let x = [1.0, 1.0, nan, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let settings = GapSettings::new(3.0, 2).unwrap();
        let found = segments(&time, &[&x], settings).unwrap();
        let ranges = vec![0..2, 3..5, 5..7];
        assert_eq!(
            found,
            Segments {
                ranges,
                missing_rows: 2,
                holes: 1,
                short: 1,
                short_rows: 1
            }
        );
    }

    #[test]
    fn prop_bad_input_is_named() {
        let d = GapSettings::default();
        assert!(GapSettings::new(f64::NAN, 1).is_err() && GapSettings::new(1.0, 1).is_err());
        assert!(GapSettings::new(2.0, 0).is_err());
        assert!(matches!(
            segments(&[0.0, 1.0], &[&[0.0]], d),
            Err(SindyError::Shape { .. })
        ));
        assert!(matches!(
            segments(&[0.0, 1.0], &[&[0.0, f64::INFINITY]], d),
            Err(SindyError::NotFinite { index: 1, .. })
        ));
        assert!(matches!(
            segments(&[0.0, f64::NAN, 0.0], &[], d),
            Err(SindyError::TimeNotIncreasing { index: 2 })
        ));
        assert_eq!(segments(&[], &[], d).unwrap().ranges, vec![]);
        assert_eq!(segments(&[f64::NAN], &[], d).unwrap().missing_rows, 1);
    }

    proptest! {
        #[test]
        fn prop_every_row_is_kept_or_counted(
            rows in proptest::collection::vec((0.01..2.0f64, any::<bool>()), 0..60),
            shortest in 1usize..5,
        ) {
            let time: Vec<f64> = rows.iter().scan(0.0, |t, r| { *t += r.0; Some(*t) }).collect();
            let x: Vec<f64> = rows.iter().map(|r| if r.1 { 1.0 } else { f64::NAN }).collect();
            let s = segments(&time, &[&x], GapSettings::new(1.5, shortest).unwrap()).unwrap();
            let kept: usize = s.ranges.iter().map(Range::len).sum();
            prop_assert_eq!(kept + s.missing_rows + s.short_rows, rows.len());
            for r in &s.ranges {
                prop_assert!(r.len() >= shortest && x[r.clone()].iter().all(|v| v.is_finite()));
            }
        }
    }
}
