//! The toolkit's error and its exit status.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Anything that stops a command.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// A log or table that cannot be read or mapped.
    #[error(transparent)]
    Log(#[from] touchdown_log::LogError),
    /// A trial that lacks a channel or breaks its rules.
    #[error(transparent)]
    Trial(#[from] touchdown_trial::TrialError),
    /// A model card that cannot be read, written or flown.
    #[error(transparent)]
    Card(#[from] touchdown_model::CardError),
    /// A fit or prediction that cannot be made.
    #[error(transparent)]
    Identification(#[from] touchdown_identify::Error),
    /// Landings that cannot be flown, stored or read.
    #[error(transparent)]
    Campaign(#[from] touchdown_campaign::Error),
    /// A flight that cannot begin, or a replay that cannot be run.
    #[error(transparent)]
    Link(#[from] touchdown_link::LinkError),
    /// A simulation whose settings make no sense.
    #[error(transparent)]
    Simulation(#[from] touchdown_sim::SimError),
    /// A figure or report that cannot be drawn or written.
    #[error(transparent)]
    Report(#[from] touchdown_report::Error),
    /// A settings or scenario file that cannot be understood.
    #[error("{file}: {message}")]
    Settings {
        /// The file.
        file: String,
        /// Line, key, expected and found.
        message: String,
    },
    /// A trial that does not fit what was asked.
    #[error("{trial}: expected {expected}, found {found}")]
    Data {
        /// The trial or file.
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

    /// A trial that does not fit.
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
        use touchdown_log::ErrorKind;
        match self {
            // A channel that is missing is the map's to give.
            Self::Trial(touchdown_trial::TrialError::Missing { .. }) => 2,
            Self::Identification(e) => e.exit_status(),
            Self::Campaign(e) => e.exit_status(),
            Self::File { .. } | Self::Data { .. } | Self::Trial(_) => 1,
            Self::Card(touchdown_model::CardError::Write { .. }) | Self::Report(_) => 1,
            Self::Link(
                touchdown_link::LinkError::Link { .. }
                | touchdown_link::LinkError::Recording { .. },
            ) => 1,
            Self::Log(e) => match e.kind() {
                ErrorKind::Unreadable | ErrorKind::Unwritable => 1,
                _ => 2,
            },
            _ => 2,
        }
    }
}

impl From<touchdown_reproduce::Error> for Error {
    fn from(error: touchdown_reproduce::Error) -> Self {
        use touchdown_reproduce::Error as Reproduction;
        match error {
            Reproduction::Campaign(e) => e.into(),
            Reproduction::Identification(e) => e.into(),
            Reproduction::Simulation(e) => e.into(),
            Reproduction::Card(e) => e.into(),
            Reproduction::Trial(e) => e.into(),
            Reproduction::Log(e) => e.into(),
            Reproduction::Page(e) => e.into(),
        }
    }
}

impl From<touchdown_pages::Error> for Error {
    fn from(error: touchdown_pages::Error) -> Self {
        use touchdown_pages::Error as Page;
        match error {
            Page::Report(e) => e.into(),
            Page::Identification(e) => e.into(),
            Page::Trial(e) => e.into(),
            Page::Campaign(e) => e.into(),
            Page::Landing(e) => Self::Arguments(format!("the record of a landing: {e}")),
            Page::File { path, source } => Self::File { path, source },
        }
    }
}

/// The toolkit's result.
pub type Result<T> = std::result::Result<T, Error>;
