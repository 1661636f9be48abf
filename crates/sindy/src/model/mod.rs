//! Models: what a fit becomes.
//!
//! A [`Model`] has named states `x`, named inputs `u` and one sparse sum of terms for each state,
//!
//! ```text
//! continuous time:  dx_i/dt  = Σ_j c_ij θ_ij(x, u)
//! discrete time:    x_i[k+1] = Σ_j c_ij θ_ij(x[k], u[k])
//! ```
//!
//! where each equation may have a library of its own. Units are those of the data that it was fitted to.
//! A model never changes once built; everything that can be wrong with it is found when it is built.
//!
//! | wanted | how |
//! | --- | --- |
//! | right-hand side, one row or whole columns | [`Model::evaluator`], [`Model::predict`], [`Model::predict_source`] |
//! | a run over time | [`Model::simulate`], [`Model::iterate`], with past states [`Model::simulate_past`] |
//! | exact Jacobian, as numbers or expressions | [`Model::jacobian`] |
//! | equilibria and their stability | [`Search`] |
//! | proof that all trajectories stay bounded | [`Model::stability_certificate`] |
//! | text, LaTeX, C99, Rust | `format!("{model:.4}")`, [`Model::to_latex`], [`Model::to_c`], [`Model::to_rust`] |
//! | a file that reads back exactly | [`Model::to_json`], [`Model::from_json`] |
//!
//! ```
//! use sindy::model::{Inputs, Model, RunOutcome, Simulation, Term, Time};
//!
//! // Lotka–Volterra: rabbits and foxes.
//! let model = Model::new(
//!     Time::Continuous,
//!     &["x", "y"],
//!     &[],
//!     vec![
//!         vec![Term::parse("x", 2.0 / 3.0)?, Term::parse("x*y", -4.0 / 3.0)?],
//!         vec![Term::parse("y", -1.0)?, Term::parse("x*y", 1.0)?],
//!     ],
//! )?;
//! assert_eq!(format!("{model:.3}"), "x' = 0.667*x - 1.33*x*y\ny' = -1.00*y + 1.00*x*y\n");
//!
//! let time: Vec<f64> = (0..=1000).map(|k| 0.01 * f64::from(k)).collect();
//! let run = model.simulate(&[1.8, 1.3], &time, &Inputs::none(), &Simulation::adaptive())?;
//! assert_eq!(run.outcome, RunOutcome::Finished);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod check;
mod dopri;
mod equilibria;
mod input;
mod jacobian;
mod json;
mod limits;
mod past;
mod predict;
pub(crate) mod print;
mod simulate;
pub(crate) mod stability;
#[cfg(test)]
mod tests;

use sindy_expr::Expr;

pub use equilibria::{Equilibria, Equilibrium, Search, Stability};
pub use input::{Inputs, Interpolation};
pub use jacobian::Jacobian;
pub use limits::{Limits, Run, RunOutcome};
pub use past::{History, Past};
pub use predict::Evaluator;
pub(crate) use print::{Number, factor};
pub use simulate::{Integrator, Simulation};
pub use stability::{NoCertificate, StabilityCertificate, TrappingRegion};

use crate::error::{SindyError, above_zero, require, same_size};
use crate::library::{Library, parse};
use check::{check_equation, check_names, written};
use predict::Compiled;

/// Whether a model gives derivatives or the next sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Time {
    /// The equations give `dx/dt`.
    Continuous,
    /// The equations give `x[k+1]`.
    Discrete {
        /// Time from one sample to the next, positive, in the unit of time of the data.
        period: f64,
    },
}

/// One term of an equation: coefficient times expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The expression over states and inputs.
    pub expression: Expr,
    /// The coefficient, finite.
    pub coefficient: f64,
    /// The coefficient's standard error where it is known, finite and not negative.
    pub std_error: Option<f64>,
    /// The probability that the term belongs to the equation where it is known, in [0, 1].
    pub inclusion: Option<f64>,
}

impl Term {
    /// A term without statements about its certainty.
    #[must_use]
    pub fn new(expression: Expr, coefficient: f64) -> Self {
        Self {
            expression,
            coefficient,
            std_error: None,
            inclusion: None,
        }
    }

    /// A term from text, such as `x^2*y`.
    ///
    /// # Errors
    /// A text that does not parse.
    pub fn parse(expression: &str, coefficient: f64) -> Result<Self, SindyError> {
        Ok(Self::new(parse(expression)?, coefficient))
    }

    /// The same term with a standard error.
    #[must_use]
    pub fn with_std_error(mut self, std_error: f64) -> Self {
        self.std_error = Some(std_error);
        self
    }

    /// The same term with an inclusion probability.
    #[must_use]
    pub fn with_inclusion(mut self, inclusion: f64) -> Self {
        self.inclusion = Some(inclusion);
        self
    }

    /// The terms of a library whose coefficients are not zero: what a solver found, as an equation.
    ///
    /// # Errors
    /// [`SindyError::Shape`] if there is not one coefficient for each term.
    pub fn of_library(library: &Library, coefficients: &[f64]) -> Result<Vec<Self>, SindyError> {
        same_size(
            "coefficients (one per term)",
            library.len(),
            coefficients.len(),
        )?;
        Ok(library
            .terms()
            .iter()
            .zip(coefficients)
            .filter(|&(_, &c)| c != 0.0)
            .map(|(e, &c)| Self::new(e.clone(), c))
            .collect())
    }
}

/// A dynamical system as one sparse sum of terms for each state; see the [module](self).
#[derive(Clone, Debug)]
pub struct Model {
    time: Time,
    states: Vec<String>,
    inputs: Vec<String>,
    equations: Vec<Vec<Term>>,
    /// Inputs that are what states were.
    past: Vec<Past>,
    compiled: Compiled,
}

/// Two models are equal when all that defines them is.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.time == other.time
            && self.states == other.states
            && self.inputs == other.inputs
            && self.equations == other.equations
            && self.past == other.past
    }
}

impl Model {
    /// A model from its equations, one for each state in the order of `states`. An equation without
    /// terms is zero.
    ///
    /// # Errors
    /// No states; a name that is empty or stands twice; not one equation for each state; a term that uses
    /// an unknown name, stands twice in its equation or is too long to be written down and read back
    /// ([`sindy_expr::MAX_TEXT_BYTES`]); a coefficient, standard error, inclusion or period outside its range.
    pub fn new<S: AsRef<str>>(
        time: Time,
        states: &[S],
        inputs: &[S],
        equations: Vec<Vec<Term>>,
    ) -> Result<Self, SindyError> {
        let own =
            |names: &[S]| -> Vec<String> { names.iter().map(|n| n.as_ref().to_owned()).collect() };
        Self::build(time, own(states), own(inputs), equations)
    }

    /// A model whose equations share one library: `coefficients[i][j]` is that of term j in the equation
    /// of state i. Terms with a zero coefficient are left out.
    ///
    /// Where equations have libraries of their own, or standard errors are known, build each equation
    /// with [`Term::of_library`] and call [`Model::new`].
    ///
    /// # Errors
    /// Those of [`Model::new`], and [`SindyError::Shape`] if a row does not have one coefficient for each
    /// term.
    pub fn from_library<S: AsRef<str>>(
        time: Time,
        states: &[S],
        inputs: &[S],
        library: &Library,
        coefficients: &[Vec<f64>],
    ) -> Result<Self, SindyError> {
        let equations = coefficients
            .iter()
            .map(|row| Term::of_library(library, row))
            .collect::<Result<_, _>>()?;
        Self::new(time, states, inputs, equations)
    }

    fn build(
        time: Time,
        states: Vec<String>,
        inputs: Vec<String>,
        equations: Vec<Vec<Term>>,
    ) -> Result<Self, SindyError> {
        if let Time::Discrete { period } = time {
            above_zero("period", period)?;
        }
        require(!states.is_empty(), "states", "at least one name", "none")?;
        check_names(&states, &inputs)?;
        same_size("equations (one per state)", states.len(), equations.len())?;
        for equation in &equations {
            check_equation(equation)?;
        }
        let compiled = Compiled::new(&states, &inputs, &equations)?;
        Ok(Self {
            time,
            states,
            inputs,
            equations,
            past: Vec::new(),
            compiled,
        })
    }

    /// Continuous or discrete time.
    #[must_use]
    pub fn time(&self) -> Time {
        self.time
    }

    /// The states' names, in order.
    #[must_use]
    pub fn states(&self) -> &[String] {
        &self.states
    }

    /// The inputs' names, in order.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// The terms of each equation, in the order of the states.
    #[must_use]
    pub fn equations(&self) -> &[Vec<Term>] {
        &self.equations
    }

    /// The number of terms in all equations together.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.equations.iter().map(Vec::len).sum()
    }

    /// The right-hand side of state `i` as one expression, summed from the left.
    ///
    /// # Panics
    /// If there is no such state.
    #[must_use]
    pub fn expression(&self, i: usize) -> Expr {
        Expr::sum(
            self.equations[i]
                .iter()
                .map(|t| Expr::constant(t.coefficient) * t.expression.clone()),
        )
    }

    /// States, then inputs: the columns of a row.
    fn columns(&self) -> Vec<&str> {
        self.states
            .iter()
            .chain(&self.inputs)
            .map(String::as_str)
            .collect()
    }
}
