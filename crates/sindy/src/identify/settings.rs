//! Settings of the automatic identification.

use serde::{Deserialize, Serialize};

use crate::choose::Grid;
use crate::derivative::savgol::SavitzkyGolay;
use crate::derivative::{
    Differentiator, FiniteDifference, KalmanSmoother, Motion, SmoothingSpline,
};
use crate::error::{SindyError, above_zero, require};
use crate::statistics::criteria::Criterion;

/// How coefficients are determined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Output error where the model's trajectories follow the data to within the noise, regression
    /// otherwise.
    #[default]
    Automatic,
    /// Output error, whatever it leaves.
    OutputError,
    /// Regression on slopes or in weak form only.
    Regression,
}

/// Where slopes come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Smoothing {
    /// Savitzky–Golay filters and the weak form with strengths from the data, on uneven times a smoothing spline
    /// by cross-validation; the one whose model predicts best is taken.
    #[default]
    Automatic,
    /// The weak form, with its half-width from the data.
    Weak,
    /// A Savitzky–Golay filter.
    SavitzkyGolay {
        /// Samples, odd.
        window: usize,
        /// Degree of its polynomial.
        degree: usize,
    },
    /// A cubic smoothing spline by generalised cross-validation.
    Spline,
    /// A Kalman smoother of constant acceleration by maximum likelihood.
    Kalman,
    /// Finite differences, for data without noise.
    FiniteDifference {
        /// 2, 4 or 6.
        order: usize,
    },
}

impl Smoothing {
    /// The differentiator of a fixed choice, `None` for the others.
    pub(super) fn differentiator(self) -> Result<Option<Differentiator>, SindyError> {
        Ok(match self {
            Self::Automatic | Self::Weak => None,
            Self::SavitzkyGolay { window, degree } => {
                Some(SavitzkyGolay::new(window, degree)?.into())
            }
            Self::Spline => Some(SmoothingSpline::cross_validated().into()),
            Self::Kalman => {
                Some(KalmanSmoother::maximum_likelihood(Motion::ConstantAcceleration).into())
            }
            Self::FiniteDifference { order } => Some(FiniteDifference::new(order)?.into()),
        })
    }
}

/// Where the data's noise comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseSource {
    /// Found from the data: the measurement, or disturbances beside it where trajectories cannot be followed.
    #[default]
    Automatic,
    /// The measurement alone, of any colour: whole trajectories are followed.
    Measurement,
    /// Disturbances of the system alone: rows are states, and the model predicts each from the one before.
    Process,
    /// Both: an extended Kalman filter tells them apart.
    Both,
}

/// What inputs are between their samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Between {
    /// Chosen for each input from its samples. An input that keeps its value and then jumps is held. It is cubic where a
    /// cubic predicts held-out samples better than straight lines do. An input that neither predicts is also tried
    /// held.
    #[default]
    Automatic,
    /// The value of the sample before.
    Hold,
    /// A straight line.
    Linear,
    /// A cubic spline.
    Cubic,
}

/// What regressions are compared by. Whatever it is, models with different slopes are ranked by free run, the one
/// yardstick that they share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Score {
    /// Free runs in continuous time, the Bayesian criterion in discrete time: there the error of the next sample is what a
    /// regression minimises, and a chaotic map has lost its start after some samples.
    #[default]
    Automatic,
    /// Short simulations against the measured states.
    FreeRun,
    /// Error of the slope on held-out blocks.
    LeftOut,
    /// Akaike's criterion.
    Aic,
    /// Akaike's criterion, corrected for few rows.
    Aicc,
    /// The Bayesian criterion.
    Bic,
    /// Bayesian evidence.
    Evidence,
}

impl Score {
    pub(super) fn criterion(self) -> Option<Criterion> {
        match self {
            Self::Automatic | Self::FreeRun | Self::LeftOut => None,
            Self::Aic => Some(Criterion::Aic),
            Self::Aicc => Some(Criterion::Aicc),
            Self::Bic => Some(Criterion::Bic),
            Self::Evidence => Some(Criterion::Evidence),
        }
    }
}

/// All that can be set; the defaults are the automatic choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Whether the equations give the next sample instead of the slope.
    pub discrete: bool,
    /// Whether single samples of the states that are far off their neighbours ([`crate::derivative::spikes`]) are
    /// taken for outliers and have no weight; in discrete time, those far off what a robust map predicts from the row before. Not in
    /// a stream.
    pub outliers: bool,
    /// Parts of equations that are known: `x' = v` (the whole equation), `v' = -9.81 + ...` (the rest is looked for), in discrete
    /// time `x[k+1] = y`. Not in a stream.
    pub known: Vec<String>,
    /// Signs that coefficients must have: `v': v < 0` (the coefficient of v in the equation of v is below 0, or the term is
    /// left out), in discrete time `x[k+1]: x > 0`. Not in a stream and not in implicit equations.
    pub signs: Vec<String>,
    /// Invariants that the equations keep exactly, as expressions of the states: `v^2/2 - cos(x)`. Not in discrete time, in a stream
    /// or in implicit equations, and not beside `known`, `signs` or `second_order`.
    pub conserve: Vec<String>,
    /// Linear relations between coefficients, of one equation or of several, that hold exactly: `[x': y] = -[y': x]` (the coefficient
    /// of y in the equation of x is minus that of x in the equation of y), `[x': x] + [y': y] = 0`. Not in discrete time, in a stream
    /// or in implicit equations, and not beside `signs`.
    pub constraints: Vec<String>,
    /// Whether all trajectories of the model must stay bounded. Candidates are linear in the states, and all eigenvalues decay; or of
    /// degree 2, and there is a [trapping region](crate::model::StabilityCertificate). Not in discrete time, in a stream or in implicit
    /// equations, and not beside `known`, `signs`, `conserve`, `constraints` or `second_order`.
    pub stable: bool,
    /// States whose equation is of second order and whose velocity is not measured: x gets a velocity `x_dot`, and `x_dot' =
    /// f(x, x_dot, u)` is looked for. The velocity is estimated with the model. Not in discrete time or in a stream.
    pub second_order: Vec<String>,
    /// How coefficients are determined.
    pub method: Method,
    /// Where the noise comes from. In discrete time noise of the measurement, or the automatic choice between it and noise of the map
    /// itself, for which regressions minimise the error of the next sample.
    pub noise: NoiseSource,
    /// Candidate terms of the squared diffusion `g_i²` of each state in `dx_i = f_i dt + g_i dW_i`, as texts for
    /// [`Library::specifications`](crate::Library::specifications): disturbances whose size depends on the state. Constant where
    /// there are none. Only where `noise` is `process` or `both`, and not beside `second_order`.
    pub diffusion: Vec<String>,
    /// Where slopes come from.
    pub smoothing: Smoothing,
    /// What regressions are compared by.
    pub score: Score,
    /// What inputs are between their samples, in continuous time.
    pub inputs_between: Between,
    /// Thresholds η = √(2 λ ν) of SR3 on scaled coefficients that are tried.
    pub thresholds: Vec<f64>,
    /// Relaxations ν of SR3 that are tried.
    pub nus: Vec<f64>,
    /// Greatest number of folds of the cross-validation. Fewer trajectories are cut into blocks until there are as many
    /// blocks as folds (or blocks have only twenty rows). More trajectories are distributed over the folds.
    pub folds: usize,
    /// Weight of the penalty for each term; 1 is the extended Bayesian criterion.
    pub penalty: f64,
    /// A term that contributes less than this share of its equation's largest term is left out, however
    /// significant: in data without noise even the error of the simulation that made them is.
    pub relevance: f64,
    /// An arc of a trajectory ends where a change of its start has grown by this factor.
    pub growth: f64,
    /// Gauss–Newton steps of the output error, at most.
    pub iterations: usize,
    /// Rows on which the output error chooses terms, at most: evenly spread pieces of longer data. The coefficients of a model that
    /// follows whole trajectories are then those of all rows.
    pub rows: usize,
}

impl Default for Settings {
    fn default() -> Self {
        let Grid { thresholds, nus } = Grid::default();
        Self {
            discrete: false,
            outliers: true,
            known: Vec::new(),
            signs: Vec::new(),
            conserve: Vec::new(),
            constraints: Vec::new(),
            stable: false,
            second_order: Vec::new(),
            method: Method::default(),
            noise: NoiseSource::default(),
            diffusion: Vec::new(),
            smoothing: Smoothing::default(),
            score: Score::default(),
            inputs_between: Between::default(),
            thresholds,
            nus,
            folds: 5,
            penalty: 1.0,
            relevance: 1e-4,
            growth: 1e3,
            iterations: 60,
            rows: 50_000,
        }
    }
}

impl Settings {
    /// What regressions are compared by, chosen where that is left to the automatic choice.
    pub(super) fn chosen_score(&self) -> Score {
        match self.score {
            Score::Automatic if self.discrete => Score::Bic,
            Score::Automatic => Score::FreeRun,
            chosen => chosen,
        }
    }

    /// Refuses values outside their range.
    ///
    /// # Errors
    /// The first of them, by its key.
    pub fn validate(&self) -> Result<(), SindyError> {
        let all = |values: &[f64], allowed: fn(f64) -> bool| {
            !values.is_empty() && values.iter().all(|v| v.is_finite() && allowed(*v))
        };
        let (thresholds, nus) = (&self.thresholds, &self.nus);
        require(
            all(thresholds, |t| t >= 0.0),
            "thresholds",
            "one or more finite numbers, at least 0",
            format!("{thresholds:?}"),
        )?;
        require(
            all(nus, |nu| nu > 0.0),
            "nus",
            "one or more finite numbers above 0",
            format!("{nus:?}"),
        )?;
        require(
            (2..=1000).contains(&self.folds),
            "folds",
            "2 to 1000",
            self.folds,
        )?;
        above_zero("penalty", self.penalty)?;
        let relevant = (0.0..1.0).contains(&self.relevance);
        require(
            relevant,
            "relevance",
            "at least 0 and below 1",
            self.relevance,
        )?;
        let grows = self.growth > 1.0 && self.growth.is_finite();
        require(grows, "growth", "a finite number above 1", self.growth)?;
        require(self.iterations != 0, "iterations", "at least 1", 0)?;
        let order = !self.discrete || self.second_order.is_empty();
        let found = self.second_order.join(", ");
        require(order, "second_order", "none in discrete time", found)?;
        let follows = match self.noise {
            NoiseSource::Automatic => true,
            NoiseSource::Measurement => self.method != Method::Regression,
            _ => !self.discrete && self.method != Method::Regression,
        };
        require(
            follows,
            "noise",
            "automatic or measurement in discrete time, automatic for regressions alone",
            format!("{:?}", self.noise).to_lowercase(),
        )?;
        super::conserve::check(self)?;
        super::diffusion::check(self)?;
        super::stable::check(self)?;
        require(self.rows >= 100, "rows", "at least 100", self.rows)?;
        self.smoothing.differentiator().map(|_| ())
    }
}
