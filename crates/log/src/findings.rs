use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};

/// Largest share of dropped rows that is not a loss. A logger on a vehicle repeats or swaps a
/// few stamps in a thousand; the value only decides between exit status 0 and 3.
const TOLERATED_LOSS: f64 = 0.01;

/// Counts and warnings of a reader.
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
    /// Whether the last row is incomplete; it is dropped.
    pub truncated: bool,
    /// Rows whose stamp repeats an earlier one; dropped.
    pub duplicate_stamps: usize,
    /// Rows whose stamp is out of order; dropped.
    pub backward_stamps: usize,
    /// Rows without a stamp; dropped.
    pub absent_stamps: usize,
    /// Rows that the map's filter removed.
    pub rows_filtered: usize,
    /// Rows outside the map's windows.
    pub rows_outside_windows: usize,
    /// Values that an expression made infinite; they became gaps.
    pub infinite_values: usize,
    /// Gaps by column, for columns of numbers that have any.
    pub empty_cells: BTreeMap<String, usize>,
    /// Columns of text.
    pub text_columns: Vec<String>,
    /// What was done as it should be: which map was taken.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
}

impl Findings {
    /// Rows that were dropped because they are faulty.
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

    /// The loss in one sentence; `None` without a loss.
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

    /// Keeps the first mention of each column of text; each part of a table mentions its own.
    pub(crate) fn unite_text_columns(&mut self) {
        let mut seen = HashSet::new();
        self.text_columns.retain(|name| seen.insert(name.clone()));
    }

    /// Combines the findings of two steps on the same input, this one first. Rows read are
    /// those of this step, rows used those of the later step; all other counts add up.
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
        self.notes.extend(later.notes);
        self.warnings.extend(later.warnings);
        self
    }
}
