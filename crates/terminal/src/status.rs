//! The table of exit statuses.

use std::process::ExitCode;

/// A file cannot be read or written, or holds no usable rows.
pub const FAILED: u8 = 1;
/// An argument, a map, a settings file or a model is wrong or missing.
pub const BAD_INPUT: u8 = 2;
/// The command is done, but input was lost.
pub const INPUT_LOST: u8 = 3;
/// Ctrl-C ended the command: 128 plus the number of the signal, as shells count.
pub const INTERRUPTED: u8 = 130;

/// The same table for people; every command shows it below its help.
pub const EXIT_STATUS: &str = "\
Exit status:
  0    Done. A vehicle that does not land and a fit that does not converge are results, not failures.
  1    Failed: a log is missing, cannot be read or has no usable rows, or a result cannot be written.
  2    An argument, a map, a settings file or a model is wrong or missing.
  3    Done, but input was lost. Warnings name the lost rows.
  130  Ctrl-C, SIGTERM or SIGHUP ended the command. The last line says what was written.";

/// How a command ends that does not fail.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Done {
    /// All input was used.
    Whole,
    /// Input was lost.
    WithLoss,
}

impl Done {
    /// With or without loss.
    #[must_use]
    pub fn with_loss(loss: bool) -> Self {
        if loss { Self::WithLoss } else { Self::Whole }
    }
}

impl From<Done> for ExitCode {
    fn from(done: Done) -> Self {
        match done {
            Done::Whole => Self::SUCCESS,
            Done::WithLoss => Self::from(INPUT_LOST),
        }
    }
}
