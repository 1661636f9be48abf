//! Why a run cannot be made or written.

use thiserror::Error;

/// Why a run cannot be made or written.
#[derive(Debug, Error)]
pub enum Error {
    /// Settings that make no sense, landings that cannot be flown, or a file that cannot be written.
    #[error(transparent)]
    Campaign(#[from] touchdown_campaign::Error),
    /// A fit or prediction that cannot be made.
    #[error(transparent)]
    Identification(#[from] touchdown_identify::Error),
    /// A simulation whose settings make no sense.
    #[error(transparent)]
    Simulation(#[from] touchdown_sim::SimError),
    /// A model card that cannot be read, written or flown.
    #[error(transparent)]
    Card(#[from] touchdown_model::CardError),
    /// A trial that lacks a channel.
    #[error(transparent)]
    Trial(#[from] touchdown_trial::TrialError),
    /// A trial that cannot be written.
    #[error(transparent)]
    Log(#[from] touchdown_log::LogError),
    /// A report that cannot be made.
    #[error(transparent)]
    Page(#[from] touchdown_pages::Error),
}

impl Error {
    /// A setting out of range; `file` names the settings.
    pub(crate) fn setting(file: &str, key: &str, message: &str) -> Self {
        Self::Campaign(touchdown_campaign::Error::Settings {
            file: file.to_owned(),
            message: format!("key `{key}`: {message}"),
        })
    }

    /// A trial that does not fit.
    pub(crate) fn data(
        trial: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Campaign(touchdown_campaign::Error::data(trial, expected, found))
    }
}

impl From<touchdown_report::Error> for Error {
    fn from(error: touchdown_report::Error) -> Self {
        Self::Page(error.into())
    }
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;
