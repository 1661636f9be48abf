//! Settings of the refinement, and what may be asked of it.

use super::Record;
use super::model::OdeModel;
use crate::error::{SindyError, require, same_size};

/// Settings of the refinement; checked by [`Shooting::refine`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shooting {
    /// Length of a window (time unit of the data); infinite: the whole record.
    pub window: f64,
    /// Distance between the starts of two windows.
    pub stride: f64,
    /// Every how many samples a residual is taken.
    pub every: usize,
    /// Standard deviation of the prior on a window's start around its guess, in the state's unit;
    /// 0 keeps the guess.
    pub start_sd: f64,
    /// Standard deviation of the output's noise, that weighs data against priors.
    pub noise_sd: f64,
    /// Steps at most.
    pub max_iterations: usize,
}

impl Default for Shooting {
    fn default() -> Self {
        Self {
            window: 2.0,
            stride: 1.5,
            every: 3,
            start_sd: 1.0,
            noise_sd: 0.1,
            max_iterations: 40,
        }
    }
}

/// A parameter's start, bounds and prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Where the search starts, and the prior's centre.
    pub start: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// Standard deviation of the prior around `start`; infinite for none.
    pub prior_sd: f64,
}

impl Parameter {
    /// A parameter without bounds or prior.
    #[must_use]
    pub fn free(start: f64) -> Self {
        Self {
            start,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            prior_sd: f64::INFINITY,
        }
    }

    /// The same between bounds.
    #[must_use]
    pub fn within(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }

    /// The same with a normal prior of standard deviation `prior_sd` around the start.
    #[must_use]
    pub fn prior(self, prior_sd: f64) -> Self {
        Self { prior_sd, ..self }
    }
}

impl Shooting {
    /// Refuses settings out of range, and records that do not fit the model.
    pub(super) fn check(
        &self,
        model: &OdeModel,
        records: &[Record<'_>],
        parameters: &[Parameter],
    ) -> Result<(), SindyError> {
        let positive = |key, v: f64| require(v > 0.0, key, "a number above 0", v);
        positive("window", self.window)?;
        positive("stride", self.stride)?;
        positive("noise_sd", self.noise_sd)?;
        require(
            self.start_sd >= 0.0,
            "start_sd",
            "a number, at least 0",
            self.start_sd,
        )?;
        require(self.every != 0, "every", "at least 1", self.every)?;
        same_size("parameters", model.parameters.len(), parameters.len())?;
        for (p, name) in parameters.iter().zip(&model.parameters) {
            let ordered = p.min <= p.max && p.start.is_finite() && p.prior_sd > 0.0;
            if !ordered {
                let expected = "start finite, min <= max, prior_sd above 0";
                let found = format!("`{name}`: {p:?}");
                return Err(SindyError::setting("parameters", expected, found));
            }
        }
        for record in records {
            let rows = record.time.len();
            same_size(
                "inputs of a record",
                model.inputs.len(),
                record.inputs.len(),
            )?;
            same_size(
                "start guesses of a record",
                model.states.len(),
                record.start.len(),
            )?;
            for column in record
                .inputs
                .iter()
                .chain(&record.start)
                .chain([&record.measured])
            {
                same_size("rows of a record", rows, column.len())?;
            }
            if let Some(index) = (1..rows).find(|&i| !(record.time[i] > record.time[i - 1])) {
                return Err(SindyError::TimeNotIncreasing { index });
            }
        }
        Ok(())
    }
}
