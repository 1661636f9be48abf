//! Checks of what models are built from and called with.

use std::fmt::Write as _;

use sindy_expr::{Expr, MAX_TEXT_BYTES};

use super::Term;
use crate::error::{SindyError, require};
use crate::library::parse;

pub(super) fn check_names(states: &[String], inputs: &[String]) -> Result<(), SindyError> {
    let mut seen = std::collections::HashSet::new();
    for (key, names) in [("states", states), ("inputs", inputs)] {
        for name in names {
            require(
                !name.is_empty(),
                key,
                "names of at least one character",
                "an empty name",
            )?;
            if !seen.insert(name) {
                let found = format!("`{name}` twice");
                return Err(SindyError::setting(
                    key,
                    "distinct names of states and inputs",
                    found,
                ));
            }
        }
    }
    Ok(())
}

pub(super) fn check_equation(terms: &[Term]) -> Result<(), SindyError> {
    let mut seen = std::collections::HashSet::new();
    for term in terms {
        let text = written(&term.expression)?;
        if !seen.insert(&term.expression) {
            return Err(SindyError::DuplicateTerm { name: text });
        }
        let range = |key, expected: &str, value: f64, fits: bool| {
            require(
                fits,
                key,
                expected,
                format!("{value} for the term `{text}`"),
            )
        };
        let c = term.coefficient;
        range("coefficient", "a finite number", c, c.is_finite())?;
        if let Some(s) = term.std_error {
            let fits = s >= 0.0 && s.is_finite();
            range("std_error", "finite, not negative", s, fits)?;
        }
        if let Some(p) = term.inclusion {
            let fits = (0.0..=1.0).contains(&p);
            range("inclusion", "a probability in [0, 1]", p, fits)?;
        }
    }
    Ok(())
}

/// The canonical text of an expression, provided that it reads back as the same expression. (The text
/// of an expression that shares its parts can be exponentially longer than the expression.)
pub(super) fn written(expression: &Expr) -> Result<String, SindyError> {
    struct Bounded(String);
    impl std::fmt::Write for Bounded {
        fn write_str(&mut self, piece: &str) -> std::fmt::Result {
            self.0.push_str(piece);
            if self.0.len() > MAX_TEXT_BYTES {
                Err(std::fmt::Error)
            } else {
                Ok(())
            }
        }
    }
    let mut text = Bounded(String::new());
    if write!(text, "{expression}").is_err() {
        return Err(SindyError::Expression {
            text: text.0.chars().take(60).chain(['…']).collect(),
            reason: format!("expected at most {MAX_TEXT_BYTES} bytes of text, found more"),
        });
    }
    let text = text.0;
    if parse(&text)? == *expression {
        return Ok(text);
    }
    let reason = "it does not read back as the same expression".to_owned();
    Err(SindyError::Expression { text, reason })
}
