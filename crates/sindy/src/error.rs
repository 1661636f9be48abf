//! Errors of this crate: bad input and bad settings. A solver that did not converge is not among them.

use thiserror::Error;

/// A fault of the input or the settings.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SindyError {
    /// A setting outside its range.
    #[error("setting `{key}`: expected {expected}, found {found}")]
    Setting {
        /// The setting's name.
        key: &'static str,
        /// The allowed values.
        expected: String,
        /// The given value.
        found: String,
    },
    /// Lengths or counts that do not fit together.
    #[error("{what}: expected {expected}, found {found}")]
    Shape {
        /// The compared sizes.
        what: &'static str,
        /// The count that the rest of the input asks for.
        expected: usize,
        /// The count that was given.
        found: usize,
    },
    /// Not enough samples.
    #[error("too few samples: expected at least {needed}, found {found}")]
    TooShort {
        /// Samples that are needed.
        needed: usize,
        /// Samples that there are.
        found: usize,
    },
    /// A value that is not a finite number.
    #[error("{what}: sample {index} is not a finite number")]
    NotFinite {
        /// The column or signal.
        what: String,
        /// Index of the first such sample.
        index: usize,
    },
    /// Values whose squares are beyond the range of numbers.
    #[error(
        "{what}: the sum of its squares is {found:e}, beyond what numbers hold with all their digits (1e-290 to 1e308): \
         give the data another unit"
    )]
    Range {
        /// The term or the column.
        what: String,
        /// The sum of squares as it came out.
        found: f64,
    },
    /// Values that are too large or too small to be reckoned with.
    #[error("{what}: expected {expected}, found {found:e}: give the data another unit")]
    Magnitude {
        /// The column, and where in it.
        what: String,
        /// The allowed values.
        expected: String,
        /// The given value.
        found: f64,
    },
    /// Time that stands still or runs backwards.
    #[error("time does not increase at sample {index}")]
    TimeNotIncreasing {
        /// Index of the first such sample.
        index: usize,
    },
    /// A name that no column bears.
    #[error("no column named `{name}`; the columns are: {known}")]
    UnknownColumn {
        /// The name that was asked for.
        name: String,
        /// The columns that there are.
        known: String,
    },
    /// A term that occurs twice.
    #[error("term `{name}` occurs twice in the library")]
    DuplicateTerm {
        /// The term.
        name: String,
    },
    /// An expression that does not parse or compile.
    #[error("expression `{text}`: {reason}")]
    Expression {
        /// The text as given.
        text: String,
        /// The fault.
        reason: String,
    },
    /// A text that is not a library.
    #[error(
        "library `{text}`, column {column}: expected {expected}, found {found} (a library is made of \
         poly(degree), fourier(frequencies), exp(rate, …), rational(scale, …) and expressions, joined by + and *)"
    )]
    Specification {
        /// The text as given, its beginning if long.
        text: String,
        /// Character number of the place, from 1.
        column: usize,
        /// What was expected there.
        expected: String,
        /// What was found there.
        found: String,
    },
    /// A linear system without a unique solution.
    #[error("{what}: the equations are singular")]
    Singular {
        /// Which system.
        what: &'static str,
    },
    /// A source of rows that failed.
    #[error("source of rows: {reason}")]
    Source {
        /// What went wrong, and where.
        reason: String,
    },
    /// Partial sums that are damaged, or do not belong to each other.
    #[error("partial sums: {reason}")]
    PartialSums {
        /// What was expected, and what was found.
        reason: String,
    },
    /// A text that is not a model in JSON.
    #[error("model in JSON: {reason}")]
    Json {
        /// The fault, with line and column.
        reason: String,
    },
}

impl SindyError {
    pub(crate) fn shape(what: &'static str, expected: usize, found: usize) -> Self {
        Self::Shape {
            what,
            expected,
            found,
        }
    }

    pub(crate) fn too_short(needed: usize, found: usize) -> Self {
        Self::TooShort { needed, found }
    }

    pub(crate) fn setting(
        key: &'static str,
        expected: impl Into<String>,
        found: impl std::fmt::Display,
    ) -> Self {
        Self::Setting {
            key,
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}

/// Refuses a setting that is not `allowed`.
pub(crate) fn require(
    allowed: bool,
    key: &'static str,
    expected: impl Into<String>,
    found: impl std::fmt::Display,
) -> Result<(), SindyError> {
    if allowed {
        Ok(())
    } else {
        Err(SindyError::setting(key, expected, found))
    }
}

/// Refuses a setting that is negative or not finite.
pub(crate) fn at_least_zero(key: &'static str, value: f64) -> Result<f64, SindyError> {
    let allowed = value.is_finite() && value >= 0.0;
    require(allowed, key, "a finite number, at least 0", value).map(|()| value)
}

/// Refuses a setting that is not positive and finite.
pub(crate) fn above_zero(key: &'static str, value: f64) -> Result<f64, SindyError> {
    let allowed = value.is_finite() && value > 0.0;
    require(allowed, key, "a finite number above 0", value).map(|()| value)
}

/// Checks that a size is the expected one.
pub(crate) fn same_size(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), SindyError> {
    if expected == found {
        Ok(())
    } else {
        Err(SindyError::shape(what, expected, found))
    }
}

/// Refuses values that are not finite; `what` names the list.
pub(crate) fn finite(what: &str, values: &[f64]) -> Result<(), SindyError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(SindyError::NotFinite {
            what: what.to_owned(),
            index,
        }),
    }
}
