//! Why a landing under an autopilot has no result.

use std::io::ErrorKind;

use touchdown::Error;
use touchdown_link::LinkError;
use touchdown_sim::SimError;
use touchdown_sim::landing::space::SpaceOutcome;

use super::process::AutopilotProcess;

/// Why a landing has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The vehicle crashed before the deck was released.
    TakeOffCrashed,
    /// The vehicle tipped over before the deck was released.
    TakeOffTippedOver,
    /// The vehicle did not come to hold above the deck in time.
    NeverHeld,
    /// The autopilot's process ended, or closed its link.
    AutopilotEnded,
    /// The autopilot did not answer in time.
    AutopilotSilent,
}

impl Cause {
    /// Its name in results.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::TakeOffCrashed => "take_off_crashed",
            Self::TakeOffTippedOver => "take_off_tipped_over",
            Self::NeverHeld => "never_held",
            Self::AutopilotEnded => "autopilot_ended",
            Self::AutopilotSilent => "autopilot_silent",
        }
    }
}

/// A landing without a result.
pub(crate) enum Failure {
    /// The vehicle did not come to hold above the deck, so that no landing began.
    NotFlown(Cause),
    /// The autopilot failed.
    Autopilot {
        /// How.
        cause: Cause,
        /// Whether the deck was released, so that a landing was under way.
        flying: bool,
        /// What was found, with the end of what the autopilot printed.
        error: Error,
    },
    /// This command failed, for example at writing a file.
    Command(Error),
}

impl Failure {
    /// The failure of a vehicle whose flight ended while the deck stood.
    pub(super) fn at_take_off(outcome: &SpaceOutcome) -> Self {
        Self::NotFlown(match outcome {
            SpaceOutcome::TippedOver => Cause::TakeOffTippedOver,
            SpaceOutcome::Crashed { .. } => Cause::TakeOffCrashed,
            SpaceOutcome::Landed { .. } | SpaceOutcome::GivenUp { .. } | SpaceOutcome::TimedOut => {
                Cause::NeverHeld
            }
        })
    }

    /// The failure of an autopilot, from the error of its link.
    pub(super) fn of_autopilot(
        process: Option<&AutopilotProcess>,
        flying: bool,
        error: LinkError,
    ) -> Self {
        let silent = matches!(&error, LinkError::Link { source, .. } if source.kind() == ErrorKind::TimedOut);
        let ended = process.and_then(match silent {
            true => AutopilotProcess::ended,
            false => AutopilotProcess::ends,
        });
        // Silence is what the end of the process looks like from the link; another error of the link may be its cause.
        let found = match &ended {
            Some(how) if silent => format!("its process ended ({how})"),
            Some(how) => format!("{error}; its process ended ({how})"),
            None => error.to_string(),
        };
        Self::Autopilot {
            cause: if silent && ended.is_none() {
                Cause::AutopilotSilent
            } else {
                Cause::AutopilotEnded
            },
            flying,
            error: match process {
                Some(process) => Error::data(
                    "the autopilot",
                    "an autopilot that flies",
                    format!("{found}; it printed last:\n{}", process.last_words()),
                ),
                None => error.into(),
            },
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Command(error)
    }
}

impl From<LinkError> for Failure {
    fn from(error: LinkError) -> Self {
        Self::Command(error.into())
    }
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        Self::Command(error.into())
    }
}

impl From<touchdown_campaign::error::Error> for Failure {
    fn from(error: touchdown_campaign::error::Error) -> Self {
        Self::Command(error.into())
    }
}

/// The outcome of what may fail.
pub(crate) type Attempt<T> = std::result::Result<T, Failure>;
