//! Errors of the link.

use std::path::PathBuf;

use touchdown_flight::SettingsError;

use crate::camera::settings::CameraError;

/// What stops a flight before it begins, or a replay.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A setting that cannot be flown.
    #[error("{0}")]
    Settings(#[from] SettingsError),
    /// A setting of the camera that cannot be used.
    #[error("{0}")]
    Camera(#[from] CameraError),
    /// An address that names no link.
    #[error("`{address}` is no address: {reason}")]
    Address {
        /// The address.
        address: String,
        /// Why it is not usable.
        reason: String,
    },
    /// A link that cannot be opened or used.
    #[error("{address}: {source}")]
    Link {
        /// The address.
        address: String,
        /// Why.
        source: std::io::Error,
    },
    /// A recording that cannot be written or read.
    #[error("{path}: {reason}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}
