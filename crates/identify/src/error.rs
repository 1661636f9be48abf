//! Why a fit or a prediction cannot be made, and the exit status of a command that ends with it.

use std::fmt;

use thiserror::Error;

/// Why a fit or a prediction cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// A trial that lacks a channel or breaks its rules.
    #[error(transparent)]
    Trial(#[from] touchdown_trial::TrialError),
    /// A model card that cannot be read, written or flown.
    #[error(transparent)]
    Card(#[from] touchdown_model::CardError),
    /// Identification that cannot start.
    #[error(transparent)]
    Identification(#[from] sindy::SindyError),
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
    /// A number of the vehicle that neither map nor settings state.
    #[error("{0}")]
    Unstated(VehicleNumber),
    /// Arguments that do not fit together.
    #[error("{0}")]
    Arguments(String),
}

/// A number of the vehicle that an identification from flights needs. It prints as a sentence with its keys in map and settings.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum VehicleNumber {
    /// Mass (kg).
    Mass,
    /// Radius of a rotor (m).
    RotorRadius,
}

impl fmt::Display for VehicleNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mass => {
                "thrust from flight needs the mass: expected `mass_kg` in the table [vehicle] of --map or in [flight] of \
                 --settings, found neither"
            }
            Self::RotorRadius => {
                "the ground effect scales with the rotor radius: expected `rotor_radius_m` in the table [flight] of \
                 --settings, found none"
            }
        })
    }
}

impl Error {
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

    /// A form that is not fitted to forces.
    pub(crate) fn not_fitted(form: touchdown_model::Form) -> Self {
        let names = touchdown_model::Form::GROUND_EFFECT.map(touchdown_model::Form::name);
        Self::Arguments(format!(
            "expected one of the forms {}, found `{}`",
            names.join(", "),
            form.name()
        ))
    }

    /// The exit status: 1 for what cannot be read or written or holds no usable data, 2 for arguments,
    /// maps, settings and cards that are wrong.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            // A channel that is missing is the map's to give.
            Self::Trial(touchdown_trial::TrialError::Missing { .. }) => 2,
            Self::Identification(_) | Self::Data { .. } | Self::Trial(_) => 1,
            Self::Card(touchdown_model::CardError::Write { .. }) => 1,
            _ => 2,
        }
    }
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;
