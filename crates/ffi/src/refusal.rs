//! Why an initialisation failed, and its report to the caller.

use touchdown_flight::SettingsError;

use crate::error::{td_error, td_setting, text_of};
use crate::fields;
use crate::memory::write;

/// Why an initialisation failed.
pub(crate) struct Refusal {
    pub(crate) error: td_error,
    /// The field, if one is to blame.
    field: &'static str,
    /// Its index in the field, as in C.
    index: &'static str,
    /// What is expected there: a text, and the name of another field or nothing.
    expected: [&'static str; 2],
    found: f64,
}

impl Refusal {
    /// The code of a result; writes the refused setting where the caller wants it.
    ///
    /// # Safety
    /// `setting` is null or points to memory of a `td_setting`.
    pub(crate) unsafe fn report(result: Result<(), Self>, setting: *mut td_setting) -> td_error {
        let refusal = result.err().unwrap_or(td_error::None.into());
        if setting.is_null() {
            return refusal.error;
        }
        let refused = td_setting {
            name: text_of([refusal.field, refusal.index]),
            expected: text_of(refusal.expected),
            found: refusal.found,
        };
        // SAFETY: the caller's promise.
        match unsafe { write(setting, refused) } {
            Ok(()) => refusal.error,
            Err(error) => error,
        }
    }

    /// Of a field whose number is none of an enumeration's constants.
    pub(crate) fn unknown(field: &'static str, expected: &'static str, number: u32) -> Self {
        Self {
            field,
            expected: [expected, ""],
            found: number.into(),
            ..td_error::UnknownValue.into()
        }
    }

    /// Of one of a model's coefficients, or of another field where the error is not about them.
    pub(crate) fn coefficient(
        error: SettingsError,
        field: &'static str,
        coefficients: &[f32],
    ) -> Self {
        let refusal = Self::from(error);
        let (SettingsError::NotFinite { key, .. } | SettingsError::OutOfRange { key, .. }) = error
        else {
            return refusal;
        };
        let Some(index) = fields::coefficient(key, refusal.found, coefficients) else {
            return refusal;
        };
        Self {
            field,
            index,
            ..refusal
        }
    }
}

impl From<td_error> for Refusal {
    fn from(error: td_error) -> Self {
        Self {
            error,
            field: "",
            index: "",
            expected: [""; 2],
            found: 0.0,
        }
    }
}

impl From<SettingsError> for Refusal {
    fn from(error: SettingsError) -> Self {
        let (key, expected, found) = match error {
            SettingsError::NotFinite { key, found } => (key, ["a finite number", ""], found),
            SettingsError::OutOfRange {
                key,
                expected,
                found,
            } => (key, [expected, ""], found),
            SettingsError::Order {
                lower_key,
                lower,
                upper_key,
                ..
            } => (lower_key, ["less than ", fields::field(upper_key)], lower),
            _ => ("", [""; 2], 0.0),
        };
        Self {
            field: fields::field(key),
            expected,
            found,
            ..td_error::Setting.into()
        }
    }
}
