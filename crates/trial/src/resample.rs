use crate::trial::median_step;
use crate::{Trial, TrialError};

/// Neighbours in a channel with gap rows between them are joined up to this multiple of the
/// channel's own median step. It lets a channel that reports more seldom than the table has rows
/// be joined, and leaves out one missing value of a channel that reports in every row (factor 2).
const JOIN_ACROSS_ROWS: f64 = 1.5;
/// Neighbours without a gap row between them are joined up to this multiple of the channel's
/// median step: farther apart, the record itself has a hole.
const JOIN_NEIGHBOURS: f64 = 10.0;
/// Most rows that a resampled trial may have (800 MB a channel).
const MOST_ROWS: f64 = 1e8;
/// The last grid point may lie this part of a period beyond the last stamp, for rounding.
const GRID_SLACK: f64 = 1e-6;

impl Trial {
    /// The rows with `from_s <= time_s <= to_s`; stamps stay as they are. An infinite end is open.
    /// No row in the window is an empty trial, not an error.
    ///
    /// # Errors
    /// [`TrialError::Window`] unless `from_s <= to_s`.
    pub fn window(&self, from_s: f64, to_s: f64) -> Result<Self, TrialError> {
        if from_s.is_nan() || to_s.is_nan() || from_s > to_s {
            return Err(TrialError::Window { from_s, to_s });
        }
        let first = self.time_s.partition_point(|&t| t < from_s);
        let end = self.time_s.partition_point(|&t| t <= to_s);
        let mut part = Self {
            name: self.name.clone(),
            time_s: self.time_s[first..end].to_vec(),
            channels: self
                .channels()
                .map(|(name, values)| (name.to_owned(), values[first..end].to_vec()))
                .collect(),
            provenance: self.provenance.clone(),
        };
        part.note(format!("window {from_s} s to {to_s} s"));
        Ok(part)
    }

    /// The trial on the uniform grid `t₀ + k·period_s`, by linear interpolation between neighbours
    /// of each channel, without bridging gaps.
    ///
    /// Two neighbouring values of a channel (gap rows passed over) are joined where they are at
    /// most 1.5 median steps of *that channel* apart, so that a load cell that reports in every
    /// tenth row is joined and a value that is missing from every-row data stays missing. Where no
    /// gap row lies between them, jitter is allowed for: they are joined up to 10 median steps.
    /// All else is NaN in the result. For another limit see
    /// [`resample_linear_within`](Self::resample_linear_within).
    ///
    /// No low-pass filter is applied: a period longer than the source's aliases.
    ///
    /// # Errors
    /// [`TrialError::Period`] unless `period_s` is finite, positive and gives at most 10⁸ rows.
    pub fn resample_linear(&self, period_s: f64) -> Result<Self, TrialError> {
        let mut trial = self.on_grid(period_s, |times, left, right, gap_rows| {
            let factor = if gap_rows {
                JOIN_ACROSS_ROWS
            } else {
                JOIN_NEIGHBOURS
            };
            times
                .median_step
                .is_some_and(|step| right - left <= factor * step)
        })?;
        trial.note(format!("resampled linearly to {period_s} s"));
        Ok(trial)
    }

    /// As [`resample_linear`](Self::resample_linear), but neighbours are joined where they are at
    /// most `max_gap_s` apart, whatever lies between.
    ///
    /// # Errors
    /// [`TrialError::Period`] for a bad `period_s` or a `max_gap_s` that is negative or NaN.
    pub fn resample_linear_within(
        &self,
        period_s: f64,
        max_gap_s: f64,
    ) -> Result<Self, TrialError> {
        if max_gap_s.is_nan() || max_gap_s < 0.0 {
            return Err(TrialError::Period {
                key: "max_gap_s",
                expected: "a number not below 0",
                found: max_gap_s,
            });
        }
        let mut trial = self.on_grid(period_s, |_, left, right, _| right - left <= max_gap_s)?;
        trial.note(format!(
            "resampled linearly to {period_s} s, joined across at most {max_gap_s} s"
        ));
        Ok(trial)
    }

    fn on_grid(
        &self,
        period_s: f64,
        joined: impl Fn(&KnownValues, f64, f64, bool) -> bool,
    ) -> Result<Self, TrialError> {
        let rows = (self.duration_s() / period_s + GRID_SLACK).floor() + 1.0;
        if !(period_s > 0.0 && period_s.is_finite() && rows <= MOST_ROWS) {
            return Err(TrialError::Period {
                key: "period_s",
                expected: "a finite number above 0 that gives at most 1e8 rows",
                found: period_s,
            });
        }
        let Some(&start_s) = self.time_s.first() else {
            return Ok(self.clone());
        };
        let grid: Vec<f64> = (0..rows as usize)
            .map(|k| start_s + k as f64 * period_s)
            .collect();
        let channels = self
            .channels()
            .map(|(name, values)| {
                let known = KnownValues::of(&self.time_s, values);
                (name.to_owned(), known.at(&grid, period_s, &joined))
            })
            .collect();
        let mut trial = Self {
            name: self.name.clone(),
            time_s: Vec::new(),
            channels,
            provenance: self.provenance.clone(),
        };
        // Beside a large start a tiny period may vanish in rounding; then two stamps are equal.
        if grid.windows(2).any(|pair| pair[1] <= pair[0]) {
            return Err(TrialError::Period {
                key: "period_s",
                expected: "a step that is not lost in rounding beside the stamps",
                found: period_s,
            });
        }
        trial.time_s = grid;
        Ok(trial)
    }
}

/// The values of one channel that are no gaps.
struct KnownValues {
    time_s: Vec<f64>,
    value: Vec<f64>,
    row: Vec<usize>,
    median_step: Option<f64>,
}

impl KnownValues {
    fn of(time_s: &[f64], values: &[f64]) -> Self {
        let row: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
        let known_s: Vec<f64> = row.iter().map(|&i| time_s[i]).collect();
        Self {
            value: row.iter().map(|&i| values[i]).collect(),
            median_step: median_step(&known_s),
            time_s: known_s,
            row,
        }
    }

    /// Values at the grid's times; one pass, both being in order.
    fn at(
        &self,
        grid: &[f64],
        period_s: f64,
        joined: &impl Fn(&Self, f64, f64, bool) -> bool,
    ) -> Vec<f64> {
        let slack_s = GRID_SLACK * period_s;
        let mut next = 0; // first known value that is later than t, but for the slack
        grid.iter()
            .map(|&t| {
                while next < self.time_s.len() && self.time_s[next] <= t + slack_s {
                    next += 1;
                }
                let Some(before) = next.checked_sub(1) else {
                    return f64::NAN;
                };
                let left = self.time_s[before];
                if t - left <= slack_s {
                    return self.value[before];
                }
                let Some(&right) = self.time_s.get(next) else {
                    return f64::NAN;
                };
                let gap_rows = self.row[next] - self.row[before] > 1;
                if !joined(self, left, right, gap_rows) {
                    return f64::NAN;
                }
                let share = (t - left) / (right - left);
                // This form stays finite for finite ends of any size.
                self.value[before] * (1.0 - share) + self.value[next] * share
            })
            .collect()
    }
}
