//! What can be wrong with settings and images.

/// Bad input to detection and location.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VisionError {
    /// A setting has a value that it cannot have.
    #[error("setting `{key}`: expected {expected}, found {found}")]
    Setting {
        /// Dotted name of the setting.
        key: String,
        /// What it has to be.
        expected: String,
        /// The offending value.
        found: String,
    },
    /// An image cannot be looked at.
    #[error("image, `{key}`: expected {expected}, found {found}")]
    Image {
        /// What is wrong in it.
        key: &'static str,
        /// What it has to be.
        expected: String,
        /// The offending value.
        found: String,
    },
    /// The detector refused the image.
    #[error("tag detector: {message}")]
    Detector {
        /// Its own words.
        message: String,
    },
}

/// The error of a setting.
pub(crate) fn setting(key: &str, expected: &str, found: &dyn ToString) -> VisionError {
    VisionError::Setting {
        key: key.to_owned(),
        expected: expected.to_owned(),
        found: found.to_string(),
    }
}

/// `Ok` when `ok` holds, else the error of a setting.
pub(crate) fn ensure(
    ok: bool,
    key: &str,
    expected: &str,
    found: &dyn ToString,
) -> Result<(), VisionError> {
    if ok {
        Ok(())
    } else {
        Err(setting(key, expected, found))
    }
}

/// A finite number above zero.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), VisionError> {
    let ok = value.is_finite() && value > 0.0;
    ensure(ok, key, "a finite number above 0", &value)
}

/// A finite number.
pub(crate) fn finite(key: &str, value: f64) -> Result<(), VisionError> {
    ensure(value.is_finite(), key, "a finite number", &value)
}
