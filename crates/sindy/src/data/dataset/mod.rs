//! Data sets: trajectories of named states and inputs over time.
//!
//! A [`Dataset`] is what a whole identification starts from. It takes trajectories of unequal length and
//! any increasing time, checks each when it is added, splits it where rows are missing (NaN) or time
//! jumps, and keeps count of all that it sets aside ([`Dataset::report`]).
//!
//! ```
//! use sindy::Dataset;
//!
//! let mut data = Dataset::new(&["x"], &["u"])?;
//! let nan = f64::NAN;
//! let time = (0..7).map(|i| 0.1 * f64::from(i)).collect();
//! let x = vec![1.0, 1.1, 1.2, nan, 1.4, 1.5, 1.6];
//! data.push("first", time, vec![x, vec![0.0; 7]], None)?;
//! assert_eq!(data.stretches().len(), 2);
//! assert_eq!(data.report().missing_rows, 1);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod bridge;
pub(crate) mod sampling;
#[cfg(test)]
mod tests;

use std::ops::Range;

use crate::data::gaps::{GapSettings, segments};
use crate::data::grid::uniform_period;
use crate::data::samples::Samples;
use crate::error::{SindyError, require, same_size};
use crate::numerics::nearest_quantile;
pub(crate) use bridge::{BRIDGED, bridge};
pub(crate) use sampling::{Sampling, Seen};

/// One trajectory of the caller's data.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// What messages call it: a file, a flight.
    pub name: String,
    /// Times, increasing.
    pub time: Vec<f64>,
    /// States, then inputs: one column each.
    pub columns: Vec<Vec<f64>>,
    /// A weight for each row, where rows do not count alike.
    pub weights: Option<Vec<f64>>,
    /// Where each state is measured; none where all are in all rows.
    sampling: Vec<Sampling>,
    /// The stretches without gaps.
    ranges: Vec<Range<usize>>,
}

impl Trajectory {
    /// The rows of each stretch without gaps.
    pub(crate) fn ranges(&self) -> &[Range<usize>] {
        &self.ranges
    }

    /// Where each state is measured; none where all are in all rows.
    pub(crate) fn sampling(&self) -> &[Sampling] {
        &self.sampling
    }

    /// The rows of a range that hold a measured value of a state and have weight, counted from its first; `None` where all do.
    pub(crate) fn measured_rows(&self, state: usize, range: &Range<usize>) -> Option<Vec<usize>> {
        let seen = self.sampling.get(state).map(|s| &s.seen[range.clone()]);
        let weights = self.weights.as_ref().map(|w| &w[range.clone()]);
        sampling::measured(range.len(), seen, weights)
    }
}

/// A stretch of a trajectory without gaps.
#[derive(Clone, Debug)]
pub struct Stretch<'a> {
    /// Index of the trajectory.
    pub trajectory: usize,
    /// Times, increasing.
    pub time: &'a [f64],
    /// States, then inputs.
    pub columns: Vec<&'a [f64]>,
    /// A weight for each row, where rows do not count alike.
    pub weights: Option<&'a [f64]>,
    /// Where each state is measured; none where all are in all rows.
    pub(crate) seen: Vec<Seen<'a>>,
}

/// Whether a column has one value in all rows.
pub(crate) fn is_constant(stretches: &[Stretch<'_>], column: usize) -> bool {
    let values = stretches.iter().flat_map(|s| s.columns[column]);
    let mut values = values.filter(|v| v.is_finite());
    match values.next() {
        Some(first) => values.all(|v| v == first),
        None => false,
    }
}

impl Stretch<'_> {
    /// The rows of `range` alone.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        let seen = self.seen.iter().map(|s| Seen {
            rows: &s.rows[range.clone()],
            ..*s
        });
        Self {
            trajectory: self.trajectory,
            time: &self.time[range.clone()],
            columns: self.columns.iter().map(|c| &c[range.clone()]).collect(),
            weights: self.weights.map(|w| &w[range.clone()]),
            seen: seen.collect(),
        }
    }

    /// Whether a state has a rate of its own.
    pub(crate) fn has_slow_state(&self) -> bool {
        self.seen.iter().any(|s| s.slow)
    }

    /// The rows that hold a measured value of a state and have weight; `None` where all do.
    pub(crate) fn measured_rows(&self, state: usize) -> Option<Vec<usize>> {
        let seen = self.seen.get(state).map(|s| s.rows);
        sampling::measured(self.time.len(), seen, self.weights)
    }

    /// The rows in which a state is measured whose holes are usual; `None` of others, which are smoothed over all rows.
    pub(crate) fn own_rows(&self, state: usize) -> Option<Vec<usize>> {
        let seen = self.seen.get(state).filter(|s| s.uneven)?;
        Some(sampling::rows(seen.rows))
    }
}

/// Counts of a data set: rows, stretches, and rows that were left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DataReport {
    /// Trajectories that were added.
    pub trajectories: usize,
    /// Their rows.
    pub rows: usize,
    /// Stretches without gaps.
    pub stretches: usize,
    /// Rows with a NaN, which split a trajectory.
    pub missing_rows: usize,
    /// Jumps of time, which split a trajectory.
    pub holes: usize,
    /// Rows in stretches of fewer than three rows, which are left out.
    pub short_rows: usize,
    /// The median step of time.
    pub period: f64,
    /// Whether every stretch has one and the same period (within the rounding of its times).
    pub uniform: bool,
}

/// Trajectories of the same states and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    states: Vec<String>,
    inputs: Vec<String>,
    trajectories: Vec<Trajectory>,
    report: DataReport,
}

/// Rows below which a stretch does not identify a slope, and is left out.
pub(crate) const FEWEST: usize = 3;
/// A weight is at most this: sums of more are not finite.
const HEAVIEST: f64 = 1e150;

/// Scales weights to a mean of one over those above 0.
fn scale(weights: &mut [f64]) -> Result<(), SindyError> {
    let counted = weights.iter().filter(|w| **w > 0.0).count();
    require(counted != 0, "weights", "some above 0", "all 0")?;
    let mean = weights.iter().sum::<f64>() / counted as f64;
    weights.iter_mut().for_each(|w| *w /= mean);
    Ok(())
}

impl Dataset {
    /// An empty data set of the given states and inputs.
    ///
    /// # Errors
    /// No states, an empty name, or a name that stands twice.
    pub fn new<S: AsRef<str>>(states: &[S], inputs: &[S]) -> Result<Self, SindyError> {
        let own =
            |names: &[S]| -> Vec<String> { names.iter().map(|n| n.as_ref().to_owned()).collect() };
        let (states, inputs) = (own(states), own(inputs));
        require(!states.is_empty(), "states", "at least one name", "none")?;
        let mut seen: Vec<&str> = Vec::new();
        for name in states.iter().chain(&inputs) {
            if name.is_empty() || seen.contains(&name.as_str()) {
                return Err(SindyError::setting(
                    "states, inputs",
                    "names that are not empty and differ",
                    format!("`{name}`"),
                ));
            }
            seen.push(name);
        }
        Ok(Self {
            states,
            inputs,
            trajectories: Vec::new(),
            report: DataReport::default(),
        })
    }

    /// Adds a trajectory: times, and one column for each state and then each input.
    ///
    /// Rows with a NaN split it, and so do steps of time above three times the 95th percentile of all steps
    /// (three periods on uniform times); both are counted. Weights are relative: they are scaled to a mean of one
    /// over the rows that have any. Up to three rows in succession without weight are bridged by a straight line
    /// where slopes are needed; more count as missing.
    ///
    /// # Errors
    /// A wrong number of columns, columns (or weights) of another length than the times, no rows, infinite
    /// values, times that do not increase, weights that are negative or not finite. Nothing is added then.
    pub fn push(
        &mut self,
        name: impl Into<String>,
        time: Vec<f64>,
        columns: Vec<Vec<f64>>,
        weights: Option<Vec<f64>>,
    ) -> Result<(), SindyError> {
        self.push_sampled(name, time, columns, (weights, Vec::new()))
    }

    /// The same where states are measured in some rows only: the others hold values that are likely there.
    pub(crate) fn push_sampled(
        &mut self,
        name: impl Into<String>,
        time: Vec<f64>,
        mut columns: Vec<Vec<f64>>,
        (mut weights, sampling): (Option<Vec<f64>>, Vec<Sampling>),
    ) -> Result<(), SindyError> {
        let expected = self.states.len() + self.inputs.len();
        same_size("columns (states, then inputs)", expected, columns.len())?;
        if time.is_empty() {
            return Err(SindyError::too_short(FEWEST, 0));
        }
        for (name, column) in self.states.iter().chain(&self.inputs).zip(&columns) {
            if let Some(index) = column.iter().position(|v| v.is_infinite()) {
                let what = format!("column `{name}`");
                return Err(SindyError::NotFinite { what, index });
            }
        }
        if let Some(weights) = &weights {
            same_size("weights (one per row)", time.len(), weights.len())?;
            if let Some(w) = weights.iter().find(|w| !(**w <= HEAVIEST && **w >= 0.0)) {
                let expected = format!("0 to {HEAVIEST:e}");
                return Err(SindyError::setting("weights", expected, w));
            }
        }
        if let Some(weights) = &mut weights {
            scale(weights)?;
            bridge(&time, &mut columns[..self.states.len()], weights, BRIDGED);
        }
        let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let found = segments(&time, &all, GapSettings::usual(&time, FEWEST)?)?;
        self.trajectories.push(Trajectory {
            name: name.into(),
            time,
            columns,
            weights,
            sampling,
            ranges: found.ranges,
        });
        let report = &mut self.report;
        report.trajectories += 1;
        report.missing_rows += found.missing_rows;
        report.holes += found.holes;
        report.short_rows += found.short_rows;
        report.rows += self.trajectories.last().map_or(0, |t| t.time.len());
        Ok(())
    }

    /// The same with other values of states, each by trajectory, row and state, at rows that no longer have weight.
    pub(crate) fn mended(&self, values: &[(usize, usize, usize, f64)]) -> Self {
        let mut out = self.clone();
        for &(trajectory, row, state, value) in values {
            let t = &mut out.trajectories[trajectory];
            t.columns[state][row] = value;
            match t.sampling.get_mut(state) {
                Some(own) => own.leave_out(row, &t.time, &mut t.columns[state]),
                None => t.weights.get_or_insert_with(|| vec![1.0; t.time.len()])[row] = 0.0,
            }
        }
        out
    }

    /// Whether values are missing one by one: a row lacks the value of a state and not of another, or a column is measured in some
    /// rows only, as where columns have rates of their own.
    #[must_use]
    pub fn lacks_single_values(&self) -> bool {
        let n = self.states.len();
        self.trajectories.iter().any(|t| {
            let lacks = |row: usize| t.columns[..n].iter().filter(|c| c[row].is_nan()).count();
            (0..t.time.len()).any(|row| (1..n).contains(&lacks(row)))
        }) || self.has_own_rates()
    }

    /// Whether a column is measured in some rows only, far apart.
    pub(crate) fn has_own_rates(&self) -> bool {
        let mut columns = self.trajectories.iter().flat_map(|t| &t.columns);
        columns.any(|c| Sampling::of(c).slow)
    }

    /// The states' names.
    #[must_use]
    pub fn states(&self) -> &[String] {
        &self.states
    }

    /// The inputs' names.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// States, then inputs.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.states.iter().chain(&self.inputs).cloned().collect()
    }

    /// The trajectories as they were added.
    #[must_use]
    pub fn trajectories(&self) -> &[Trajectory] {
        &self.trajectories
    }

    /// What there is, and what was set aside.
    #[must_use]
    pub fn report(&self) -> DataReport {
        let mut report = self.report;
        let mut steps = Vec::new();
        let mut periods: Vec<Option<f64>> = Vec::new();
        for stretch in self.stretches() {
            steps.extend(stretch.time.windows(2).map(|w| w[1] - w[0]));
            periods.push(uniform_period(stretch.time));
        }
        report.stretches = periods.len();
        report.period = nearest_quantile(&mut steps, 0.5);
        report.uniform = !periods.is_empty()
            && periods
                .iter()
                .all(|p| p.is_some_and(|p| (p / report.period - 1.0).abs() < 1e-3));
        report
    }

    /// All stretches without gaps, in the order of the trajectories and of time.
    #[must_use]
    pub fn stretches(&self) -> Vec<Stretch<'_>> {
        let mut all = Vec::new();
        for (index, t) in self.trajectories.iter().enumerate() {
            for range in &t.ranges {
                all.push(Stretch {
                    trajectory: index,
                    time: &t.time[range.clone()],
                    columns: t.columns.iter().map(|c| &c[range.clone()]).collect(),
                    weights: t.weights.as_ref().map(|w| &w[range.clone()]),
                    seen: t.sampling.iter().map(|s| s.part(range.clone())).collect(),
                });
            }
        }
        all
    }

    /// The rows as [`Samples`], one group for each trajectory, gaps as they are; the time column is
    /// named [`Dataset::TIME`].
    ///
    /// # Errors
    /// None for a data set that was built here.
    pub fn samples(&self) -> Result<Samples, SindyError> {
        let mut names = vec![Self::TIME];
        names.extend(self.states.iter().chain(&self.inputs).map(String::as_str));
        let mut samples = Samples::new(&names);
        for t in &self.trajectories {
            let mut columns = vec![t.time.clone()];
            columns.extend(t.columns.iter().cloned());
            samples.push_group(columns)?;
        }
        Ok(samples)
    }

    /// The name of the time column in [`Dataset::samples`]; no expression can contain it.
    pub const TIME: &'static str = "(time)";
}
