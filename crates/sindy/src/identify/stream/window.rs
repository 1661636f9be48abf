//! Rows of a trajectory as they pass: windows that overlap, and the stretches without gaps in them.

use std::borrow::Cow;
use std::ops::Range;

use crate::data::dataset::{BRIDGED, DataReport, FEWEST, bridge};
use crate::data::gaps::{GapSettings, segments};
use crate::error::SindyError;

/// Consecutive rows of a trajectory.
#[derive(Clone, Debug)]
pub(super) struct Window {
    /// Time, states, inputs, and weights if there are any.
    pub columns: Vec<Vec<f64>>,
    /// Whether rows of the same trajectory came before.
    pub continued: bool,
    /// Number of its first row in the pass.
    pub first: usize,
}

/// A stretch without gaps in a window.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WindowStretch {
    /// Its rows in the window.
    pub rows: Range<usize>,
    /// Those of them that belong to this window, and to no other.
    pub own: Range<usize>,
    /// Whether the stretch begins and ends here, and not in another window.
    pub begins: bool,
    pub ends: bool,
}

impl WindowStretch {
    /// The own rows without those at the ends of a stretch whose slopes err more, where enough is left without them.
    pub(super) fn inner(&self, edge: usize) -> Range<usize> {
        let whole = self.begins && self.ends;
        let edge = if whole && self.rows.len() <= 4 * edge {
            0
        } else {
            edge
        };
        let start = self.rows.start + if self.begins { edge } else { 0 };
        let end = self.rows.end - if self.ends { edge } else { 0 };
        let start = start.max(self.own.start);
        start..end.min(self.own.end).max(start)
    }
}

impl Window {
    /// The same with straight lines through the states of up to three rows in succession without weight, and NaN
    /// where there are more, as in a [`Dataset`](crate::Dataset). In discrete time, where the row before would take the
    /// line for its next sample, none are bridged.
    pub(super) fn bridged(&self, states: usize, data: usize, discrete: bool) -> Cow<'_, Self> {
        let Some(weights) = self.columns.get(1 + data) else {
            return Cow::Borrowed(self);
        };
        if weights.iter().all(|w| *w > 0.0) {
            return Cow::Borrowed(self);
        }
        let mut out = self.clone();
        let longest = if discrete { 0 } else { BRIDGED };
        bridge(
            &self.columns[0],
            &mut out.columns[1..=states],
            weights,
            longest,
        );
        Cow::Owned(out)
    }

    pub(super) fn new(columns: usize, first: usize) -> Self {
        Self {
            columns: vec![Vec::new(); columns],
            continued: false,
            first,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.columns[0].len()
    }

    pub(super) fn extend(&mut self, columns: &[&[f64]], rows: Range<usize>) {
        for (own, column) in self.columns.iter_mut().zip(columns) {
            own.extend_from_slice(&column[rows.clone()]);
        }
    }

    /// Forgets all but the rows that the next window needs.
    pub(super) fn advance(&mut self, overlap: usize) {
        let gone = self.len().saturating_sub(3 * overlap);
        self.columns.iter_mut().for_each(|c| drop(c.drain(..gone)));
        self.first += gone;
        self.continued = true;
    }

    /// The rows that belong to this window. With `more` to come, the last `overlap` are the next one's, which sees
    /// twice as many before them.
    fn own(&self, overlap: usize, more: bool) -> Range<usize> {
        let start = if self.continued { 2 * overlap } else { 0 };
        let end = self.len() - if more { overlap } else { 0 };
        start.min(end)..end
    }

    /// The stretches of three rows or more with rows of this window; what is there, and what is set aside, is counted.
    pub(super) fn parts(
        &self,
        data: usize,
        overlap: usize,
        more: bool,
        report: &mut DataReport,
    ) -> Result<Vec<WindowStretch>, SindyError> {
        let time = &self.columns[0];
        let columns: Vec<&[f64]> = self.columns[1..=data].iter().map(Vec::as_slice).collect();
        let found =
            segments(time, &columns, GapSettings::usual(time, 1)?).map_err(
                |error| match error {
                    SindyError::TimeNotIncreasing { index } => SindyError::TimeNotIncreasing {
                        index: index + self.first,
                    },
                    other => other,
                },
            )?;
        let own = self.own(overlap, more);
        report.rows += own.len();
        report.missing_rows += own.len();
        let mut parts = Vec::new();
        let mut before = None;
        for rows in found.ranges {
            let begins = rows.start > 0 || !self.continued;
            let ends = rows.end < self.len() || !more;
            let long = rows.len() >= FEWEST || !(begins && ends);
            if begins && own.contains(&rows.start) {
                report.holes += usize::from(before == Some(rows.start));
                report.stretches += usize::from(long);
            }
            before = Some(rows.end);
            let start = rows.start.max(own.start);
            let own = start..rows.end.min(own.end).max(start);
            report.missing_rows -= own.len();
            if !long {
                report.short_rows += own.len();
            } else if !own.is_empty() {
                parts.push(WindowStretch {
                    rows,
                    own,
                    begins,
                    ends,
                });
            }
        }
        Ok(parts)
    }
}
