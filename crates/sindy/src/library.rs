//! The candidate library: terms as data.
//!
//! A term is a text expression over named columns (`x^2*y`, `exp(-x)*s`, `1/(1+(z/0.2)^2)`), so that a
//! library can stand in a settings file, be printed, differentiated and read back.

use sindy_expr::{Expr, Program};

use crate::error::SindyError;

/// An ordered list of distinct candidate terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    names: Vec<String>,
    terms: Vec<Expr>,
}

impl Library {
    /// Parses the terms; each keeps its text as its name.
    ///
    /// # Errors
    /// No terms, a term that does not parse, or one that occurs twice.
    pub fn parse<S: AsRef<str>>(terms: &[S]) -> Result<Self, SindyError> {
        if terms.is_empty() {
            return Err(SindyError::setting("library", "at least one term", "none"));
        }
        let mut library = Self {
            names: Vec::new(),
            terms: Vec::new(),
        };
        for text in terms {
            let text = text.as_ref().trim();
            let expr = parse(text)?;
            if library.terms.contains(&expr) {
                return Err(SindyError::DuplicateTerm {
                    name: text.to_string(),
                });
            }
            library.names.push(text.to_string());
            library.terms.push(expr);
        }
        Ok(library)
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
