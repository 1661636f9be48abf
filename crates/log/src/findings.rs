use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Largest part of the rows that may be dropped before input counts as lost.
const TOLERATED_LOSS: f64 = 0.01;

/// What a reader counted, dropped and warned of.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Findings {
    /// Data rows found, whole or not; blank lines and comments do not count.
    pub rows_read: usize,
    /// Source rows that are in the result.
    pub rows_used: usize,
    /// Rows without a single value; dropped.
    pub empty_rows: usize,
    /// Rows with too few or too many cells, or with text in a column of numbers; dropped.
    pub corrupt_rows: usize,
    /// Whether the last row breaks off; it is dropped.
    pub truncated: bool,
    /// Rows whose stamp repeats an earlier one; dropped.
    pub duplicate_stamps: usize,
    /// Rows whose stamp is out of order; dropped.
    pub backward_stamps: usize,
    /// Rows without a stamp; dropped.
    pub absent_stamps: usize,
    /// Rows that the map's filter left out.
    pub rows_filtered: usize,
    /// Rows outside of the map's windows.
    pub rows_outside_windows: usize,
    /// Values that an expression made infinite; they became gaps.
    pub infinite_values: usize,
    /// Gaps by column, for columns of numbers that have any.
    pub empty_cells: BTreeMap<String, usize>,
    /// Columns of text.
    pub text_columns: Vec<String>,
    /// What a person should know, one sentence each.
    pub warnings: Vec<String>,
}

impl Findings {
    /// Rows that were dropped because something is wrong with them.
    #[must_use]
    pub fn rows_dropped(&self) -> usize {
        self.corrupt_rows
            + usize::from(self.truncated)
            + self.duplicate_stamps
            + self.backward_stamps
            + self.absent_stamps
    }

    /// Whether input was lost: a truncated last record, a corrupt section, or more than 1 % of the
    /// rows dropped. Rows that a map leaves out on purpose are no loss.
    #[must_use]
    pub fn is_lossy(&self) -> bool {
        self.truncated
            || self.corrupt_rows > 0
            || self.rows_dropped() as f64 > TOLERATED_LOSS * self.rows_read as f64
    }

    /// The loss in one sentence; `None` where nothing was lost.
    #[must_use]
    pub fn loss(&self) -> Option<String> {
        self.is_lossy().then(|| {
            format!(
                "{} of {} rows lost: {} corrupt, {} truncated, {} duplicate, {} out of order, {} without a stamp",
                self.rows_dropped(),
                self.rows_read,
                self.corrupt_rows,
                usize::from(self.truncated),
                self.duplicate_stamps,
                self.backward_stamps,
                self.absent_stamps
            )
        })
    }

    /// The findings of two steps on the same input, this one first: rows read are this step's,
    /// rows used the later step's, all else adds up.
    #[must_use]
    pub fn then(mut self, later: Self) -> Self {
        self.rows_used = later.rows_used;
        self.empty_rows += later.empty_rows;
        self.corrupt_rows += later.corrupt_rows;
        self.truncated |= later.truncated;
        self.duplicate_stamps += later.duplicate_stamps;
        self.backward_stamps += later.backward_stamps;
        self.absent_stamps += later.absent_stamps;
        self.rows_filtered += later.rows_filtered;
        self.rows_outside_windows += later.rows_outside_windows;
        self.infinite_values += later.infinite_values;
        for (column, gaps) in later.empty_cells {
            *self.empty_cells.entry(column).or_default() += gaps;
        }
        self.text_columns.extend(later.text_columns);
        self.warnings.extend(later.warnings);
        self
    }
}
