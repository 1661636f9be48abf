//! Checks of single settings, with the offending number in the error.

use crate::STEP_S;
use crate::error::SimError;

/// The error of a setting.
pub(crate) fn fail(key: &str, expected: &str, found: &dyn ToString) -> SimError {
    SimError::Setting {
        key: key.to_owned(),
        expected: expected.to_owned(),
        found: found.to_string(),
    }
}

/// `Ok` where `ok` holds, else an error with what was expected.
pub(crate) fn that(ok: bool, key: &str, expected: &str, found: f64) -> Result<(), SimError> {
    if ok {
        Ok(())
    } else {
        Err(fail(key, expected, &found))
    }
}

/// A finite number above zero.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), SimError> {
    that(
        value.is_finite() && value > 0.0,
        key,
        "a finite number above 0",
        value,
    )
}

/// A finite number that is not negative.
pub(crate) fn not_negative(key: &str, value: f64) -> Result<(), SimError> {
    that(
        value.is_finite() && value >= 0.0,
        key,
        "a finite number of at least 0",
        value,
    )
}

/// A finite number in [low, high].
pub(crate) fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), SimError> {
    that(
        value >= low && value <= high,
        key,
        &format!("a number from {low} to {high}"),
        value,
    )
}

/// A finite number of any sign.
pub(crate) fn finite(key: &str, value: f64) -> Result<(), SimError> {
    that(value.is_finite(), key, "a finite number", value)
}

/// A period from one step of the plant to `most`, in whole steps.
pub(crate) fn period(key: &str, value: f64, most: f64) -> Result<(), SimError> {
    within(key, value, STEP_S, most)?;
    let steps = value / STEP_S;
    that(
        (steps - steps.round()).abs() < 1e-6,
        key,
        "a multiple of 0.001 s",
        value,
    )
}
