//! Partial differential equations that were found.

use std::fmt;

use serde::Serialize;

use super::term::{FieldLibrary, FieldTerm};
use crate::model::Number;

/// A term of an equation, as it is printed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundTerm {
    /// The term: `u_xx`, `(u^2)_x`.
    pub term: String,
    /// Its coefficient, in the units of fields and axes.
    pub coefficient: f64,
    /// Standard error of the coefficient.
    pub std_error: f64,
    /// The odds that the term belongs to the equation, as a probability.
    pub inclusion: f64,
    /// The 95 % interval of the coefficient.
    pub interval: [f64; 2],
    #[serde(skip)]
    pub(super) of: FieldTerm,
}

/// The equation of a field: its derivative in time as a sum of terms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldEquation {
    /// The left side: `u_t`, or `u_tt` of a second order in time.
    pub left: String,
    /// The field.
    pub field: String,
    /// The terms of the right side.
    pub terms: Vec<FoundTerm>,
}

/// One line for each equation, as `u_t = 0.1*u_xx - 0.5*(u^2)_x`. `{model:.4}` prints coefficients with 4 significant digits.
impl fmt::Display for FieldEquation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} =", self.left)?;
        if self.terms.is_empty() {
            f.write_str(" 0")?;
        }
        for (i, term) in self.terms.iter().enumerate() {
            f.write_str(match (i, term.coefficient.is_sign_negative()) {
                (0, false) => " ",
                (0, true) => " -",
                (_, false) => " + ",
                (_, true) => " - ",
            })?;
            let size = Number::new(term.coefficient.abs(), f.precision()).text();
            match term.term.as_str() {
                "1" => f.write_str(&size)?,
                name => write!(f, "{size}*{name}")?,
            }
        }
        Ok(())
    }
}

/// The left side of a field's equation.
pub(super) fn left(field: &str, time: &str, time_order: u8) -> String {
    let mut powers = FieldLibrary {
        fields: vec![field.to_owned()],
        space: vec![time.to_owned()],
        terms: Vec::new(),
    };
    powers.terms.push(FieldTerm {
        powers: vec![1],
        orders: vec![time_order],
    });
    powers.names().remove(0)
}
