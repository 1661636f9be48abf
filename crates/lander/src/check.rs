//! Checks of settings, as calls. Inlined, as those of [`touchdown_flight::error`], they take 2 kB more of a microcontroller's flash.

use touchdown_flight::error::{self, SettingsError};
use touchdown_flight::real::Real;

/// [`error::positive`].
#[inline(never)]
pub(crate) fn positive<R: Real>(key: &'static str, value: R) -> Result<(), SettingsError> {
    error::positive(key, value)
}

/// [`error::not_negative`].
#[inline(never)]
pub(crate) fn not_negative<R: Real>(key: &'static str, value: R) -> Result<(), SettingsError> {
    error::not_negative(key, value)
}
