//! Why a report cannot be made.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a report cannot be made.
#[derive(Debug, Error)]
pub enum Error {
    /// A figure or report that cannot be drawn or written.
    #[error(transparent)]
    Report(#[from] touchdown_report::Error),
    /// A card that does not run on the logs that it is shown with.
    #[error(transparent)]
    Identification(#[from] touchdown_identify::Error),
    /// A log that lacks a channel.
    #[error(transparent)]
    Trial(#[from] touchdown_trial::TrialError),
    /// Settings or landings that cannot be written down.
    #[error(transparent)]
    Campaign(#[from] touchdown_campaign::Error),
    /// A landing that cannot be written as JSON.
    #[error("the record of a landing: {0}")]
    Landing(#[from] serde_json::Error),
    /// A folder that cannot be made.
    #[error("{path}: {source}")]
    File {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl Error {
    /// An input or output error at `path`.
    pub(crate) fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;
