//! The progress and the result of an identification.

use serde::Serialize;

use super::stable::Stability;
use crate::data::dataset::DataReport;
use crate::model::{Interpolation, Model};
use crate::solve::outcome::Outcome;

/// The present step of the automatic identification.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Progress {
    /// Smoothing and differentiating.
    Smoothing,
    /// Regressing, with these slopes.
    Regression {
        /// Where slopes come from.
        smoothing: String,
    },
    /// Comparing implicit relations by the trajectories that follow from them.
    Relations {
        /// The relation, from 1.
        number: usize,
        /// Relations of all equations.
        total: usize,
    },
    /// A Gauss–Newton step of the output error.
    OutputError {
        /// The start, from 0.
        start: usize,
        /// Steps from this start.
        step: usize,
        /// Terms kept at present.
        terms: usize,
        /// Largest share of a state's noise that is left, 1 being the aim.
        misfit: f64,
    },
    /// A Gauss–Newton step of the chosen terms on all rows of long data.
    AllRows {
        /// Steps so far.
        step: usize,
    },
}

/// A ratio as people read it: two decimals, or `less than 0.01` where these would be zero.
///
/// ```
/// use sindy::identify::ratio;
/// assert_eq!(ratio(0.987), "0.99");
/// assert_eq!(ratio(3e-6), "less than 0.01");
/// assert_eq!(ratio(4.56e7), "4.6e7");
/// assert_eq!(ratio(f64::INFINITY), "infinitely many");
/// ```
#[must_use]
pub fn ratio(value: f64) -> String {
    match value {
        v if v.is_infinite() => "infinitely many".to_owned(),
        v if v.abs() < 0.01 => "less than 0.01".to_owned(),
        v if v.abs() >= 1e5 => format!("{v:.1e}"),
        v => format!("{v:.2}"),
    }
}

/// The chosen method and the reason for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// How coefficients were determined: `output_error`, `prediction_error`, `best_subset` or `sr3`.
    pub method: String,
    /// λ of SR3, one for each equation (under invariants one for all), where it made the start or the model.
    pub lambda: Option<Vec<f64>>,
    /// ν of SR3, likewise.
    pub nu: Option<Vec<f64>>,
    /// Where slopes came from.
    pub smoothing: String,
    /// In a sentence or two.
    pub reason: String,
}

/// One number of terms of one equation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontPoint {
    /// The best terms of this number.
    pub terms: Vec<String>,
    /// Their error, in [`Equation::unit`].
    pub error: f64,
    /// Whether no other terms of this number are better, by proof.
    pub proven: bool,
    /// Whether these are the model's terms.
    pub chosen: bool,
}

/// One equation and its alternatives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equation {
    /// The state.
    pub state: String,
    /// Estimated noise on it; NaN for a velocity that is not measured.
    pub noise: f64,
    /// Root mean square of its residual, as far as trajectories were followed.
    pub residual: Option<f64>,
    /// Standard deviation by which disturbances move the state in a unit of time, where the system is taken to be disturbed.
    pub disturbance: Option<f64>,
    /// The squared diffusion `g²` of the state, `var(dx)/dt = Σ_j c_j θ_j(x, u)`; no terms where it was not looked for.
    pub diffusion: Vec<DiffusionTerm>,
    /// Terms against error, the other equations held; under invariants of all equations together, which share terms.
    pub front: Vec<FrontPoint>,
    /// Meaning and unit of the front's error.
    pub unit: &'static str,
    /// For each term of the model's equation: the 95 % confidence interval of its coefficient, with Student's t where it
    /// rests on little; `None` where there is no standard error. The choice of terms is not in it.
    pub intervals: Vec<Option<[f64; 2]>>,
}

/// A term of a state's squared diffusion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiffusionTerm {
    /// Its expression.
    pub term: String,
    /// Its coefficient.
    pub coefficient: f64,
    /// The coefficient's standard error.
    pub std_error: f64,
    /// The probability that the term is present.
    pub inclusion: f64,
    /// The 95 % confidence interval of the coefficient. The choice of terms is not in it.
    pub interval: Option<[f64; 2]>,
}

/// A model that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Solver and smoothing.
    pub name: String,
    /// Terms in all equations.
    pub terms: usize,
    /// Root mean square of short simulations from smoothed states, in units of the noise.
    pub free_run: f64,
}

/// The result of an identification.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The model, with standard errors and inclusion probabilities.
    pub model: Model,
    /// One for each state.
    pub equations: Vec<Equation>,
    /// The choice and its reason.
    pub choice: Choice,
    /// Everything that was compared.
    pub candidates: Vec<Candidate>,
    /// Why the last solver stopped.
    pub outcome: Outcome,
    /// What each input was taken to be between its samples; of no account in discrete time and for regressions.
    pub inputs_between: Vec<Interpolation>,
    /// Why all trajectories stay bounded, where that was asked for.
    pub stability: Option<Stability>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Counts of the data.
    pub data: DataReport,
}
