//! Where a run ends early, and what a run is.

use super::Model;
use crate::data::samples::position;
use crate::error::{SindyError, require};

/// Range of states in which a simulation continues.
///
/// By default every state up to a magnitude of 10¹²; ranges of single states can be added, such as those
/// that the training data covered.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    blow_up: f64,
    ranges: Vec<(String, f64, f64)>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            blow_up: 1e12,
            ranges: Vec::new(),
        }
    }
}

impl Limits {
    /// A run has blown up when the magnitude of any state exceeds `magnitude` or is not finite.
    #[must_use]
    pub fn blow_up_above(mut self, magnitude: f64) -> Self {
        self.blow_up = magnitude;
        self
    }

    /// A run is out of range when `state` is below `low` or above `high`.
    #[must_use]
    pub fn range(mut self, state: &str, low: f64, high: f64) -> Self {
        self.ranges.push((state.to_owned(), low, high));
        self
    }

    /// The limits for the states of a model.
    pub(super) fn check(&self, model: &Model) -> Result<Guard, SindyError> {
        require(
            self.blow_up > 0.0,
            "blow_up_above",
            "a positive magnitude",
            self.blow_up,
        )?;
        let mut ranges = Vec::with_capacity(self.ranges.len());
        for (state, low, high) in &self.ranges {
            if !(low < high) {
                let found = format!("{low} to {high} for `{state}`");
                return Err(SindyError::setting(
                    "range",
                    "a lower end below the upper end",
                    found,
                ));
            }
            ranges.push((position(&model.states, state)?, *low, *high));
        }
        Ok(Guard {
            blow_up: self.blow_up,
            ranges,
            names: model.states.clone(),
        })
    }
}

/// How a run ended. All are ordinary ends of a run; those other than `Finished` leave out the rows after
/// `time`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RunOutcome {
    /// All requested times were reached.
    Finished,
    /// A state or its derivative stopped being finite, or exceeded the limit of magnitude.
    BlewUp {
        /// End of the first step that failed; of the last that succeeded if none can be made after it.
        time: f64,
    },
    /// A state left its range.
    OutOfRange {
        /// End of the first step that ended out of range.
        time: f64,
        /// The state's name.
        state: String,
    },
    /// The tolerance cannot be met by any step that moves the time (the problem is too stiff, or
    /// discontinuous).
    StepTooSmall {
        /// End of the last step that succeeded.
        time: f64,
    },
    /// The number of steps allowed was used up.
    StepLimit {
        /// End of the last step.
        time: f64,
    },
}

/// A run of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The requested times that were reached.
    pub time: Vec<f64>,
    /// One column for each state, each as long as `time`.
    pub states: Vec<Vec<f64>>,
    /// How the run ended.
    pub outcome: RunOutcome,
    /// Evaluations of the right-hand side.
    pub evaluations: usize,
    /// Steps taken, those that were rejected included.
    pub steps: usize,
}

impl Run {
    pub(super) fn new(states: usize, rows: usize) -> Self {
        Self {
            time: Vec::with_capacity(rows),
            states: vec![Vec::with_capacity(rows); states],
            outcome: RunOutcome::Finished,
            evaluations: 0,
            steps: 0,
        }
    }

    pub(super) fn push(&mut self, time: f64, state: &[f64]) {
        self.time.push(time);
        for (column, &value) in self.states.iter_mut().zip(state) {
            column.push(value);
        }
    }
}

/// [`Limits`] checked against a model.
#[derive(Debug)]
pub(super) struct Guard {
    blow_up: f64,
    ranges: Vec<(usize, f64, f64)>,
    names: Vec<String>,
}

impl Guard {
    /// The outcome if a run ends in this state.
    pub(super) fn violated(&self, time: f64, state: &[f64]) -> Option<RunOutcome> {
        // Written so that NaN counts as too large.
        if !state.iter().all(|x| x.abs() <= self.blow_up) {
            return Some(RunOutcome::BlewUp { time });
        }
        self.ranges
            .iter()
            .find(|&&(i, low, high)| state[i] < low || state[i] > high)
            .map(|&(i, ..)| RunOutcome::OutOfRange {
                time,
                state: self.names[i].clone(),
            })
    }
}
