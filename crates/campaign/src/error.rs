//! Why landings cannot be flown, stored or read, and the exit status of a command that ends with it.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why landings cannot be flown, stored or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// A model card that cannot be read, written or flown.
    #[error(transparent)]
    Card(#[from] touchdown_model::CardError),
    /// A simulation whose settings make no sense.
    #[error(transparent)]
    Simulation(#[from] touchdown_sim::SimError),
    /// Flight settings out of range.
    #[error("{0}")]
    Flight(touchdown_flight::SettingsError),
    /// A settings or scenario file that cannot be understood.
    #[error("{file}: {message}")]
    Settings {
        /// The file.
        file: String,
        /// Line, key, expected and found.
        message: String,
    },
    /// A stored block of landings that does not fit its campaign.
    #[error("{trial}: expected {expected}, found {found}")]
    Data {
        /// The file.
        trial: String,
        /// What is needed.
        expected: String,
        /// What is there.
        found: String,
    },
    /// Arguments that do not fit together.
    #[error("{0}")]
    Arguments(String),
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl Error {
    /// An input or output error at `path`.
    #[must_use]
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }

    /// A file that does not fit its campaign.
    pub fn data(
        trial: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Data {
            trial: trial.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// The exit status: 1 for what cannot be read or written or holds no usable data, 2 for arguments,
    /// maps, settings and cards that are wrong.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::File { .. } | Self::Data { .. } => 1,
            Self::Card(touchdown_model::CardError::Write { .. }) => 1,
            _ => 2,
        }
    }
}

impl From<touchdown_flight::SettingsError> for Error {
    fn from(e: touchdown_flight::SettingsError) -> Self {
        Self::Flight(e)
    }
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;
