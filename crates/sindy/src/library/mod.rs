//! The candidate library: terms as data.
//!
//! A term is a text expression over named columns (`x^2*y`, `exp(-x)*s`, `1/(1+(z/0.2)^2)`), so that a
//! library can stand in a settings file, be printed, differentiated and read back. Libraries are written term
//! by term ([`Library::parse`]), made by a constructor ([`Library::polynomial`], [`Library::fourier`],
//! [`Library::exponentials`], [`Library::bounded_rationals`]), multiplied and joined ([`Library::product`],
//! [`Library::sum`]), or given as one text ([`Library::specification`]):
//!
//! ```
//! use sindy::Library;
//!
//! let library = Library::specification("poly(2) + poly(1)*fourier(1, x)", &["x", "y"])?;
//! assert_eq!(library.names()[..6], ["1", "x", "y", "x^2", "x*y", "y^2"]);
//! assert_eq!(library.names()[6..], ["sin(x)", "cos(x)", "x*sin(x)", "x*cos(x)", "y*sin(x)", "y*cos(x)"]);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! [`Libraries`] holds such texts for a whole system: one library for all equations, or one for each.
//!
//! Terms that constructors and products make have canonical names: powers collected (`x^2`, not `x*x`),
//! a number first, then variables in the order given, then the other factors by their text; equal terms occur
//! once. They are the texts of the expressions: reading a name gives the term again. Compiled together, terms
//! share their parts: each further product costs one operation per row.

mod algebra;
mod factored;
mod fourier;
mod functions;
mod libraries;
mod polynomial;
mod specification;
#[cfg(test)]
mod tests;

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use sindy_expr::{Expr, Program};

use crate::error::{SindyError, require};
use factored::Alphabet;
pub use libraries::Libraries;
pub use polynomial::{Interaction, Polynomial};

/// The most terms that a library which is made by constructors may have.
pub const MAX_TERMS: usize = 5000;

/// An ordered list of distinct candidate terms. Between processes it is the list of their names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<String>", into = "Vec<String>")]
pub struct Library {
    names: Vec<String>,
    terms: Vec<Expr>,
}

impl Library {
    /// Parses the terms; each keeps its text as its name.
    ///
    /// # Errors
    /// No terms, a term that does not parse, or one that occurs twice (`x*y` and `y*x` are the same).
    pub fn parse<S: AsRef<str>>(terms: &[S]) -> Result<Self, SindyError> {
        require(!terms.is_empty(), "library", "at least one term", "none")?;
        let names: Vec<String> = terms.iter().map(|t| t.as_ref().trim().into()).collect();
        let terms: Vec<Expr> = names.iter().map(|t| parse(t)).collect::<Result<_, _>>()?;
        let (_, factored) = Alphabet::new(&terms, &[]);
        let mut seen = HashSet::new();
        for (name, term) in names.iter().zip(factored) {
            if !seen.insert(term) {
                return Err(SindyError::DuplicateTerm { name: name.clone() });
            }
        }
        Ok(Self { names, terms })
    }

    /// Named by their own texts.
    pub(crate) fn of(terms: Vec<Expr>) -> Self {
        Self {
            names: terms.iter().map(ToString::to_string).collect(),
            terms,
        }
    }

    /// The library without the terms of these indices.
    #[must_use]
    pub fn without(&self, indices: &[usize]) -> Self {
        let kept = || (0..self.len()).filter(|j| !indices.contains(j));
        Self {
            names: kept().map(|j| self.names[j].clone()).collect(),
            terms: kept().map(|j| self.terms[j].clone()).collect(),
        }
    }

    /// The number of terms.
    #[must_use]
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether there are no terms (never true of a parsed library).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// The terms' names: their texts as given.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The terms.
    #[must_use]
    pub fn terms(&self) -> &[Expr] {
        &self.terms
    }

    /// LaTeX of each term, for mathematics mode: `x^{2}\,y`, `\sin\left(x\right)`.
    #[must_use]
    pub fn to_latex(&self) -> Vec<String> {
        self.terms.iter().map(Expr::to_latex).collect()
    }

    /// The names of all columns that the terms use.
    #[must_use]
    pub fn variables(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .terms
            .iter()
            .flat_map(|t| t.variables().into_iter().map(String::from))
            .collect();
        names.sort();
        names.dedup();
        names
    }

    /// Compiles the terms for columns in the given order.
    ///
    /// # Errors
    /// A term that uses a name which is not among the columns.
    pub fn compile(&self, columns: &[String]) -> Result<Program, SindyError> {
        compile(
            &self.terms,
            &columns.iter().map(String::as_str).collect::<Vec<_>>(),
        )
    }
}

impl From<Library> for Vec<String> {
    fn from(library: Library) -> Self {
        library.names
    }
}

impl TryFrom<Vec<String>> for Library {
    type Error = SindyError;

    fn try_from(names: Vec<String>) -> Result<Self, SindyError> {
        Self::parse(&names)
    }
}

pub(crate) fn parse(text: &str) -> Result<Expr, SindyError> {
    Expr::parse(text).map_err(|e| SindyError::Expression {
        text: text.to_string(),
        reason: e.to_string(),
    })
}

pub(crate) fn compile(exprs: &[Expr], inputs: &[&str]) -> Result<Program, SindyError> {
    Program::compile(exprs, inputs).map_err(|e| SindyError::Expression {
        text: exprs
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("; "),
        reason: e.to_string(),
    })
}

/// Refuses no variables, an empty name, and a name that occurs twice.
fn check_variables<S: AsRef<str>>(variables: &[S]) -> Result<(), SindyError> {
    require(
        !variables.is_empty(),
        "variables",
        "at least one variable",
        "none",
    )?;
    let mut seen = HashSet::new();
    for name in variables.iter().map(AsRef::as_ref) {
        if name.is_empty() || !seen.insert(name) {
            let expected = "distinct names that are not empty";
            return Err(SindyError::setting(
                "variables",
                expected,
                format!("`{name}`"),
            ));
        }
    }
    Ok(())
}

/// Refuses more than [`MAX_TERMS`].
fn check_terms(count: Option<usize>) -> Result<(), SindyError> {
    match count {
        Some(count) if count <= MAX_TERMS => Ok(()),
        _ => {
            let found = count.map_or_else(|| "far more".into(), |count| count.to_string());
            let expected = format!("at most {MAX_TERMS} terms");
            Err(SindyError::setting("library", expected, found))
        }
    }
}
