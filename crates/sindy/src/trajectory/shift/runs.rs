//! Rows that follow each other at one period.

use std::ops::Range;

use crate::data::samples::{BlockSource, Samples};
use crate::error::{SindyError, above_zero};
use crate::numerics::upper_median;

/// The largest part of the period by which a step may differ from it: the jitter of printed times.
const TOLERANCE: f64 = 1e-3;

/// Steps of at least this many periods are gaps: half a period more than one, less than a missing row.
const GAP: f64 = 1.5;

/// The rows of all groups, cut at gaps.
pub(super) struct Runs {
    /// Group, and rows of it that follow each other.
    pub(super) ranges: Vec<(usize, Range<usize>)>,
    /// Steps at which a group was cut.
    pub(super) gaps: usize,
    /// Rows without a time.
    pub(super) untimed: usize,
    /// The period, where there is a time.
    pub(super) period: Option<f64>,
}

impl Runs {
    /// Without a time, all rows of a group follow each other.
    pub(super) fn new(
        samples: &Samples,
        time: Option<&str>,
        period: Option<f64>,
    ) -> Result<Self, SindyError> {
        if let Some(period) = period {
            above_zero("period", period)?;
        }
        let Some(name) = time else {
            let rows = |g: usize| samples.group(g).first().map_or(0, Vec::len);
            return Ok(Self {
                ranges: (0..samples.groups()).map(|g| (g, 0..rows(g))).collect(),
                gaps: 0,
                untimed: 0,
                period,
            });
        };
        let column = samples.position(name)?;
        let times: Vec<&[f64]> = (0..samples.groups())
            .map(|g| samples.group(g)[column].as_slice())
            .collect();
        for time in &times {
            check_order(name, time)?;
        }
        let Some(period) = period.or_else(|| median_step(&times)) else {
            return Err(SindyError::too_short(2, samples.rows().min(1)));
        };
        let mut runs = Self {
            ranges: Vec::new(),
            gaps: 0,
            untimed: 0,
            period: Some(period),
        };
        for (group, time) in times.iter().enumerate() {
            runs.cut(group, time, period)?;
        }
        Ok(runs)
    }

    fn cut(&mut self, group: usize, time: &[f64], period: f64) -> Result<(), SindyError> {
        let found = Cut::new(time, period);
        if let Some((row, step)) = found.uneven.or(found.other_period()) {
            return Err(uneven(
                period,
                step,
                &format!("sample {row} of trajectory {}", group + 1),
            ));
        }
        self.gaps += found.gaps;
        self.untimed += found.untimed;
        self.ranges
            .extend(found.ranges.into_iter().map(|r| (group, r)));
        Ok(())
    }
}

/// The rows of one time column that follow each other at one period: steps within a thousandth of it. Steps of at least
/// one and a half are gaps.
#[derive(Debug, Default)]
pub(crate) struct Cut {
    pub(crate) ranges: Vec<Range<usize>>,
    pub(crate) gaps: usize,
    /// Rows without a time.
    untimed: usize,
    /// Whether any step is one period.
    pub(crate) regular: bool,
    /// The first gap: the row after it and its step.
    pub(crate) first_gap: Option<(usize, f64)>,
    /// The first step that is neither a period nor a gap.
    pub(crate) uneven: Option<(usize, f64)>,
}

impl Cut {
    pub(crate) fn new(time: &[f64], period: f64) -> Self {
        let mut cut = Self::default();
        let mut start = 0;
        for row in 0..=time.len() {
            let there = time.get(row).is_some_and(|t| !t.is_nan());
            cut.untimed += usize::from(row < time.len() && !there);
            if there && row > start {
                let step = time[row] - time[row - 1];
                if (step / period - 1.0).abs() <= TOLERANCE {
                    cut.regular = true;
                    continue;
                }
                if step < GAP * period {
                    cut.uneven = cut.uneven.or(Some((row, step)));
                }
                cut.gaps += 1;
                cut.first_gap = cut.first_gap.or(Some((row, step)));
            } else if there {
                continue;
            }
            if row > start {
                cut.ranges.push(start..row);
            }
            start = if there { row } else { row + 1 };
        }
        cut
    }

    /// Nothing but gaps: another period, not a group with holes.
    fn other_period(&self) -> Option<(usize, f64)> {
        self.first_gap.filter(|_| !self.regular)
    }
}

/// What times with a step that is neither a period nor a gap are refused with.
pub(crate) fn uneven(period: f64, step: f64, before: &str) -> SindyError {
    let expected = format!(
        "steps of {period} (to {TOLERANCE} of it), or gaps of at least {GAP} of them: other times have to be resampled first"
    );
    SindyError::setting(
        "time",
        expected,
        format!("a step of {step} before {before}"),
    )
}

fn check_order(name: &str, time: &[f64]) -> Result<(), SindyError> {
    let mut last = f64::NEG_INFINITY;
    for (index, &t) in time.iter().enumerate().filter(|(_, t)| !t.is_nan()) {
        if t.is_infinite() {
            let what = format!("column `{name}`");
            return Err(SindyError::NotFinite { what, index });
        }
        if !(t > last) {
            return Err(SindyError::TimeNotIncreasing { index });
        }
        last = t;
    }
    Ok(())
}

fn median_step(times: &[&[f64]]) -> Option<f64> {
    let steps = times.iter().flat_map(|t| t.windows(2).map(|w| w[1] - w[0]));
    upper_median(&mut steps.filter(|s| !s.is_nan()).collect::<Vec<f64>>())
}
