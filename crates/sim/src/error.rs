//! What can be wrong with settings and trials.

/// Bad input to the simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
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
    /// A rig trial asks for something that the rig cannot do.
    #[error("rig trial `{trial}`, `{key}`: expected {expected}, found {found}")]
    RigTrial {
        /// Name of the trial.
        trial: String,
        /// What is wrong in it.
        key: String,
        /// What it has to be.
        expected: String,
        /// The offending value.
        found: String,
    },
    /// A measured series cannot be used.
    #[error("series, row {row}, `{key}`: expected {expected}, found {found}")]
    Series {
        /// What is wrong in it: a column or a coordinate.
        key: String,
        /// Row of data, from 1; 0 is the header.
        row: usize,
        /// What it has to be.
        expected: String,
        /// The offending value.
        found: String,
    },
    /// The recorded values do not make a trial.
    #[error("recording of `{name}`: {source}")]
    Recording {
        /// Name of the trial.
        name: String,
        /// What is wrong with them.
        source: touchdown_trial::TrialError,
    },
}

impl SimError {
    /// The same error with its key below `section`, for nested settings.
    #[must_use]
    pub fn in_section(self, section: &str) -> Self {
        match self {
            Self::Setting {
                key,
                expected,
                found,
            } => Self::Setting {
                key: format!("{section}.{key}"),
                expected,
                found,
            },
            other => other,
        }
    }

    /// The same error as one of the rig trial `trial`.
    #[must_use]
    pub(crate) fn of_trial(self, trial: &str) -> Self {
        match self {
            Self::Setting {
                key,
                expected,
                found,
            } => Self::RigTrial {
                trial: trial.to_owned(),
                key,
                expected,
                found,
            },
            other => other,
        }
    }
}
