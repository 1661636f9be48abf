//! Rational equations that were found.

use std::fmt;

use serde::Serialize;
use sindy_expr::Expr;

use crate::data::dataset::DataReport;
use crate::model::{Interpolation, Model, Number, factor};
use crate::solve::outcome::Outcome;

/// A term of a numerator or denominator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RationalTerm {
    /// The term.
    pub term: String,
    #[serde(skip)]
    pub(super) expression: Expr,
    /// Its coefficient, in the units of the data.
    pub coefficient: f64,
    /// Its standard error; `None` of the term that is held at 1, and where there is none.
    pub std_error: Option<f64>,
    /// The odds that the term belongs to the equation, as a probability.
    pub inclusion: Option<f64>,
    /// The 95 % interval of the coefficient.
    pub interval: Option<[f64; 2]>,
}

/// `x' = N/D`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RationalEquation {
    /// The state.
    pub state: String,
    /// The terms of N.
    pub numerator: Vec<RationalTerm>,
    /// The terms of D, the one with the coefficient 1 first. It alone, and constant, where the equation is explicit.
    pub denominator: Vec<RationalTerm>,
    /// Estimated noise of the state.
    pub noise: f64,
    /// Root mean square of what the model leaves of the state, where it followed the trajectories.
    pub residual: Option<f64>,
    /// The relations that were compared by trajectories, best first.
    pub compared: Vec<ComparedRelation>,
}

/// A relation that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedRelation {
    /// The equation, with four digits.
    pub equation: String,
    /// Its coefficients that were estimated.
    pub coefficients: usize,
    /// Twice the logarithm of the odds against it, beside the best of these; infinite where trajectories could not be followed.
    pub against: f64,
    /// The same without the penalty for coefficients: twice the logarithm of the likelihood's ratio.
    pub worse: f64,
    /// Whether it has other terms than the best, at most one coefficient more, and cannot write the best with a shared factor.
    #[serde(skip)]
    pub(super) rival: bool,
}

/// The result of an identification of implicit equations.
#[derive(Clone, Debug)]
pub struct ImplicitIdentification {
    /// One for each state.
    pub equations: Vec<RationalEquation>,
    /// The model, whose terms are those of the numerators over the denominators.
    pub model: Model,
    /// Why the last solver stopped.
    pub outcome: Outcome,
    /// How the equations were chosen, in a sentence.
    pub reason: String,
    /// What each input was taken to be between its samples.
    pub inputs_between: Vec<Interpolation>,
    /// Counts of the data.
    pub data: DataReport,
    /// What qualifies the numbers.
    pub warnings: Vec<String>,
}

impl RationalEquation {
    /// Whether the equation is an ordinary one, without a denominator.
    #[must_use]
    pub fn is_explicit(&self) -> bool {
        matches!(self.denominator.as_slice(), [one] if one.term == "1")
    }
}

/// `x' = (0.18 - 0.9*x)/(0.3 + x)`; `{equation:.4}` prints coefficients with 4 significant digits.
impl fmt::Display for RationalEquation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let above = sum(&self.numerator, f.precision());
        if self.is_explicit() {
            return write!(f, "{}' = {above}", self.state);
        }
        let below = sum(&self.denominator, f.precision());
        let bracketed = |text: &str, terms: &[RationalTerm]| match terms.len() {
            1 if !text.contains(' ') && !text.contains('/') => text.to_owned(),
            _ => format!("({text})"),
        };
        let above = bracketed(&above, &self.numerator);
        let below = match below.contains('*') && self.denominator.len() == 1 {
            true => format!("({below})"),
            false => bracketed(&below, &self.denominator),
        };
        write!(f, "{}' = {above}/{below}", self.state)
    }
}

/// A sum of terms as text.
fn sum(terms: &[RationalTerm], digits: Option<usize>) -> String {
    let mut out = String::new();
    for (i, term) in terms.iter().enumerate() {
        out.push_str(match (i, term.coefficient.is_sign_negative()) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        });
        let size = Number::new(term.coefficient.abs(), digits).text();
        let held = term.coefficient == 1.0 && term.std_error.is_none();
        out.push_str(&match factor(&term.expression, Expr::to_string, "*") {
            None if held => "1".to_owned(),
            None => size,
            Some(name) if held => name,
            Some(name) => format!("{size}*{name}"),
        });
    }
    match out.is_empty() {
        true => "0".to_owned(),
        false => out,
    }
}

/// One line for each equation.
impl fmt::Display for ImplicitIdentification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for equation in &self.equations {
            fmt::Display::fmt(equation, f)?;
            f.write_str("\n")?;
        }
        Ok(())
    }
}
