//! The error of a settings check.

use core::fmt;

use crate::real::Real;

/// An invalid setting, with its key and value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// A number is NaN or infinite.
    NotFinite {
        /// The setting.
        key: &'static str,
        /// The value found.
        found: f64,
    },
    /// A number lies outside its range.
    OutOfRange {
        /// The setting.
        key: &'static str,
        /// The range, in words.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// Two numbers are in the wrong order.
    Order {
        /// The setting that must be the smaller one.
        lower_key: &'static str,
        /// The value of that setting.
        lower: f64,
        /// The setting that must be the larger one.
        upper_key: &'static str,
        /// The value of that setting.
        upper: f64,
    },
}

/// A number as an error shows it: by a power of ten where its digits would fill the line.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = if self.0 < 0.0 { -self.0 } else { self.0 };
        if (1e15..f64::INFINITY).contains(&magnitude) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite { key, found } => {
                write!(
                    f,
                    "{key}: expected a finite number, found {}",
                    Number(found)
                )
            }
            Self::OutOfRange {
                key,
                expected,
                found,
            } => write!(f, "{key}: expected {expected}, found {}", Number(found)),
            Self::Order {
                lower_key,
                lower,
                upper_key,
                upper,
            } => write!(
                f,
                "{lower_key}: expected less than {upper_key} = {}, found {}",
                Number(upper),
                Number(lower)
            ),
        }
    }
}

impl core::error::Error for SettingsError {}

/// Accepts a finite `value`.
///
/// # Errors
/// Names `key` and the value.
pub fn finite<R: Real>(key: &'static str, value: R) -> Result<(), SettingsError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(SettingsError::NotFinite {
            key,
            found: value.to_f64(),
        })
    }
}

/// Accepts a finite `value` greater than 0.
///
/// # Errors
/// Names `key` and the value.
pub fn positive<R: Real>(key: &'static str, value: R) -> Result<(), SettingsError> {
    within(
        key,
        value,
        value > R::ZERO,
        "a finite number greater than 0",
    )
}

/// Accepts a finite `value` not below 0.
///
/// # Errors
/// Names `key` and the value.
pub fn not_negative<R: Real>(key: &'static str, value: R) -> Result<(), SettingsError> {
    within(key, value, value >= R::ZERO, "a finite number not below 0")
}

/// Accepts a finite `value` if the caller's condition `accepted` holds.
///
/// # Errors
/// Names `key`, the range that was `expected` and the value.
pub fn within<R: Real>(
    key: &'static str,
    value: R,
    accepted: bool,
    expected: &'static str,
) -> Result<(), SettingsError> {
    if value.is_finite() && accepted {
        Ok(())
    } else {
        Err(SettingsError::OutOfRange {
            key,
            expected,
            found: value.to_f64(),
        })
    }
}

/// Accepts two finite values in rising order.
///
/// # Errors
/// Names both keys and values.
pub fn ordered<R: Real>(
    lower_key: &'static str,
    lower: R,
    upper_key: &'static str,
    upper: R,
) -> Result<(), SettingsError> {
    finite(lower_key, lower)?;
    finite(upper_key, upper)?;
    if lower < upper {
        Ok(())
    } else {
        Err(SettingsError::Order {
            lower_key,
            lower: lower.to_f64(),
            upper_key,
            upper: upper.to_f64(),
        })
    }
}
