//! States that are not measured in every row: where they are, and what stands between.

use std::borrow::Cow;

use crate::data::gaps::GapSettings;
use crate::error::SindyError;
use crate::numerics::{hermite, spline_slopes};

use super::bridge::BRIDGED;

/// Holes after more than this share of the samples are usual. [`GapSettings::usual`] takes as many long steps of time for uneven
/// sampling.
const USUAL: f64 = 0.05;

/// The rows of one trajectory that hold a measured value of a state.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampling {
    /// By row.
    pub seen: Vec<bool>,
    /// Whether the state has a rate of its own: holes follow more than half of its samples.
    pub slow: bool,
    /// Whether holes are usual, so that it is smoothed at its own times. Otherwise it is measured in nearly every row.
    pub uneven: bool,
}

/// The same of a stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<'a> {
    pub rows: &'a [bool],
    pub slow: bool,
    pub uneven: bool,
}

impl Sampling {
    /// Of a column with NaN where nothing is measured.
    pub(crate) fn of(column: &[f64]) -> Self {
        Self::at(column.iter().map(|v| !v.is_nan()).collect())
    }

    /// Measured in these rows.
    pub(crate) fn at(seen: Vec<bool>) -> Self {
        let rows = rows(&seen);
        let apart = rows.windows(2).filter(|w| w[1] - w[0] > 1).count();
        Self {
            slow: 2 * apart > rows.len(),
            uneven: apart as f64 > USUAL * rows.len() as f64,
            seen,
        }
    }

    /// Writes what is likely between the measured values: the cubic spline through those around. Nothing is written before the first
    /// and after the last, and in gaps: between samples that are far apart for this state where holes are usual, and over more than
    /// three rows elsewhere.
    pub(crate) fn fill(&self, time: &[f64], column: &mut [f64]) -> Result<(), SindyError> {
        let own = rows(&self.seen);
        let times: Vec<f64> = own.iter().map(|&r| time[r]).collect();
        if own.len() < 2 {
            return Ok(());
        }
        let longest = GapSettings::usual(&times, 1)?.longest(&times);
        let is_gap = |a: usize, b: usize| match self.uneven {
            true => time[b] - time[a] > longest,
            false => b - a > BRIDGED + 1,
        };
        for (row, seen) in self.seen.iter().enumerate() {
            if !seen {
                column[row] = f64::NAN;
            }
        }
        for part in own.chunk_by(|a, b| !is_gap(*a, *b)) {
            let (x, y): (Vec<f64>, Vec<f64>) = part.iter().map(|&r| (time[r], column[r])).unzip();
            if part.len() < 2 || part.len() == part[part.len() - 1] - part[0] + 1 {
                continue;
            }
            let slopes = spline_slopes(&x, &y);
            for k in 0..part.len() - 1 {
                between(
                    time,
                    column,
                    [part[k], part[k + 1]],
                    [slopes[k], slopes[k + 1]],
                );
            }
        }
        Ok(())
    }

    /// Takes a row from those that are measured. Of a state that is smoothed at its own times a straight line bridges it.
    pub(crate) fn leave_out(&mut self, row: usize, time: &[f64], column: &mut [f64]) {
        self.seen[row] = false;
        let before = (0..row).rfind(|&k| self.seen[k]);
        let after = (row..self.seen.len()).find(|&k| self.seen[k]);
        if let (true, Some(a), Some(b)) = (self.uneven, before, after) {
            let slope = (column[b] - column[a]) / (time[b] - time[a]);
            between(time, column, [a, b], [slope; 2]);
        }
    }

    /// The rows of a range alone.
    pub(crate) fn part(&self, range: std::ops::Range<usize>) -> Seen<'_> {
        Seen {
            rows: &self.seen[range],
            slow: self.slow,
            uneven: self.uneven,
        }
    }
}

/// The rows that are measured.
pub(crate) fn rows(seen: &[bool]) -> Vec<usize> {
    (0..seen.len()).filter(|&row| seen[row]).collect()
}

/// The rows that are measured and have weight; `None` where all are.
pub(super) fn measured(
    n: usize,
    seen: Option<&[bool]>,
    weights: Option<&[f64]>,
) -> Option<Vec<usize>> {
    let counts = |row: &usize| {
        seen.is_none_or(|seen| seen[*row]) && weights.is_none_or(|weights| weights[*row] > 0.0)
    };
    let own: Vec<usize> = (0..n).filter(counts).collect();
    (own.len() < n).then_some(own)
}

/// Writes cubics with the given slopes at two rows into the rows between.
fn between(time: &[f64], column: &mut [f64], [a, b]: [usize; 2], slopes: [f64; 2]) {
    let h = time[b] - time[a];
    let (from, to) = (column[a], column[b]);
    for row in a + 1..b {
        let part = (time[row] - time[a]) / h;
        column[row] = hermite(from, to, h * slopes[0], h * slopes[1], part);
    }
}

/// The values that are picked by `rows`; all where there are none.
pub(crate) fn pick<'a>(values: &'a [f64], rows: Option<&[usize]>) -> Cow<'a, [f64]> {
    match rows {
        None => Cow::Borrowed(values),
        Some(rows) => Cow::Owned(rows.iter().map(|&row| values[row]).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f64 = f64::NAN;

    #[test]
    fn analytic_cubics_are_bridged_exactly_between_samples_and_not_beyond() {
        let time: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k)).collect();
        let truth = |t: f64| 1.0 - t + 0.5 * t * t - 0.1 * t * t * t;
        let mut column = vec![NAN; 60];
        (2..58)
            .step_by(5)
            .for_each(|row| column[row] = truth(time[row]));
        let sampling = Sampling::of(&column);
        assert!(sampling.slow);
        sampling.fill(&time, &mut column).unwrap();
        for (row, v) in column.iter().enumerate() {
            // A not-a-knot spline through a cubic is that cubic, to rounding.
            let is_right = (v - truth(time[row])).abs() < 1e-12;
            assert_eq!(is_right, (2..58).contains(&row), "{row}: {v}");
        }
    }

    #[test]
    fn prop_gaps_are_judged_by_the_rate_of_the_state() {
        let time: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        // Every fourth row, but for a pause of 40 rows.
        let slow = |row: usize| row.is_multiple_of(4) && !(80..120).contains(&row);
        let often = |row: usize| !row.is_multiple_of(23) && !(80..85).contains(&row);
        // Two rows from one sample to the next are usual: up to six are no gap.
        let uneven = |row: usize| {
            !row.is_multiple_of(9) && !(28..31).contains(&row) && !(80..90).contains(&row)
        };
        for (of, gap) in [
            (&slow as &dyn Fn(usize) -> bool, 77..120),
            (&often, 80..85),
            (&uneven, 80..91),
        ] {
            let value = |row| if of(row) { 1.0 } else { NAN };
            let mut column: Vec<f64> = (0..200).map(value).collect();
            let sampling = Sampling::of(&column);
            assert_eq!(sampling.slow, gap.len() > 11);
            assert_eq!(sampling.uneven, gap.len() > 5);
            sampling.fill(&time, &mut column).unwrap();
            let first = (0..200).find(|&row| of(row)).unwrap();
            let last = (0..200).rfind(|&row| of(row)).unwrap();
            for row in first..=last {
                assert_eq!(column[row].is_nan(), gap.contains(&row), "{row}");
            }
        }
    }
}
