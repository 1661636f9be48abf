//! Why an initialisation failed, and its report to the caller.

use touchdown_flight::SettingsError;

use crate::error::{td_error, td_setting};
use crate::memory::write;

/// Why an initialisation failed.
pub(crate) struct Refusal {
    pub(crate) error: td_error,
    /// The setting, if one is to blame.
    pub(crate) setting: &'static str,
}

impl Refusal {
    /// The code of a result; writes the setting's name where the caller wants it.
    ///
    /// # Safety
    /// `setting` is null or points to memory of a `td_setting`.
    pub(crate) unsafe fn report(result: Result<(), Self>, setting: *mut td_setting) -> td_error {
        let refusal = result.err().unwrap_or(td_error::None.into());
        if setting.is_null() {
            return refusal.error;
        }
        // SAFETY: the caller's promise.
        match unsafe { write(setting, td_setting::of(refusal.setting)) } {
            Ok(()) => refusal.error,
            Err(error) => error,
        }
    }

    /// Of a setting by its name.
    pub(crate) fn setting(setting: &'static str) -> Self {
        Self {
            error: td_error::Setting,
            setting,
        }
    }
}

impl From<td_error> for Refusal {
    fn from(error: td_error) -> Self {
        Self { error, setting: "" }
    }
}

impl From<SettingsError> for Refusal {
    fn from(error: SettingsError) -> Self {
        Self::setting(match error {
            SettingsError::NotFinite { key, .. } | SettingsError::OutOfRange { key, .. } => key,
            SettingsError::Order { lower_key, .. } => lower_key,
            _ => "",
        })
    }
}
