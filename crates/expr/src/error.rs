//! Errors of parsing and compiling.

use thiserror::Error;

/// Why and where a text is not an expression.
///
/// The message shows the place:
/// ```text
/// column 5: expected a value, found `*`
///   x + * y
///       ^
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("column {column}: expected {expected}, found {found}\n  {excerpt}\n  {:>width$}", "^", width = .caret + 1)]
#[non_exhaustive]
pub struct ParseError {
    /// Byte offset of the place in the text.
    pub position: usize,
    /// Character number of the place, from 1.
    pub column: usize,
    /// What was expected there.
    pub expected: String,
    /// What was found there.
    pub found: String,
    /// The text around the place, on one line.
    pub excerpt: String,
    /// How many characters of the excerpt come before the place.
    pub caret: usize,
}

impl ParseError {
    /// Builds the error and its excerpt; `position` is a character boundary of `text`.
    pub(crate) fn new(
        text: &str,
        position: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Box<Self> {
        const AROUND: usize = 32;
        let visible = |c: char| if c.is_control() { ' ' } else { c };
        let before: Vec<char> = text[..position].chars().rev().take(AROUND).collect();
        let excerpt = before
            .iter()
            .rev()
            .copied()
            .chain(text[position..].chars().take(AROUND))
            .map(visible)
            .collect();
        Box::new(Self {
            position,
            column: text[..position].chars().count() + 1,
            expected: expected.into(),
            found: found.into(),
            excerpt,
            caret: before.len(),
        })
    }
}

/// Why expressions cannot be compiled against a list of inputs.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CompileError {
    /// An expression names a variable that is not among the inputs.
    #[error("in `{expression}`: unknown name `{name}`{}; expected one of: {}", suggestion(nearest.as_ref()), listing(known))]
    UnknownName {
        /// The name found.
        name: String,
        /// The expression that uses it, shortened if long.
        expression: String,
        /// The names expected.
        known: Vec<String>,
        /// The known name that looks most like it, if any does.
        nearest: Option<String>,
    },
    /// Two inputs have the same name.
    #[error(
        "input `{name}` is listed twice, at places {first} and {second}; expected distinct names"
    )]
    DuplicateInput {
        /// The repeated name.
        name: String,
        /// Its first place, from 0.
        first: usize,
        /// Its second place, from 0.
        second: usize,
    },
}

fn suggestion(nearest: Option<&String>) -> String {
    nearest.map_or_else(String::new, |name| format!(" (did you mean `{name}`?)"))
}

fn listing(known: &[String]) -> String {
    if known.is_empty() {
        "(no inputs)".to_owned()
    } else {
        known.join(", ")
    }
}
