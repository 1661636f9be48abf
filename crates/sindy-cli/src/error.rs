//! The errors of the command, and their exit status.

use std::path::{Path, PathBuf};

use sindy::SindyError;
use thiserror::Error;
use touchdown_terminal::status::{BAD_INPUT, FAILED};

/// Anything that stops a command.
#[derive(Debug, Error)]
pub(crate) enum Error {
    /// A text table that cannot be read.
    #[error(transparent)]
    Log(#[from] touchdown_log::LogError),
    /// Data, terms or settings that the library refuses.
    #[error("{what}: {source}")]
    Refused { what: String, source: SindyError },
    /// A figure that cannot be drawn.
    #[error("figure: {0}")]
    Figure(touchdown_report::Error),
    /// A table that does not hold what was asked for.
    #[error("{at}: expected {expected}, found {found}")]
    Data {
        /// File, and row and column where they are known.
        at: String,
        expected: String,
        found: String,
    },
    /// A file of settings, terms or a model that is missing or cannot be understood.
    #[error("{file}: {message}")]
    Settings { file: String, message: String },
    /// Arguments that do not fit together.
    #[error("{0}")]
    Arguments(String),
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A file without a usable row.
    #[error("{at}: no usable rows: {reason}")]
    NoRows { at: String, reason: String },
}

impl Error {
    /// An input or output error at `path`.
    pub(crate) fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }

    /// A file of settings, terms or a model that is missing or cannot be read.
    pub(crate) fn unread(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        |source| Self::Settings {
            file: path.display().to_string(),
            message: format!("cannot be read: {source}"),
        }
    }

    /// Data that are not what they should be.
    pub(crate) fn data(
        at: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Data {
            at: at.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }

    /// The library's error about `what`.
    pub(crate) fn refused(what: impl Into<String>) -> impl FnOnce(SindyError) -> Self {
        let what = what.into();
        |source| Self::Refused { what, source }
    }

    /// The library's error about data: about the option, where the setting is that of one.
    pub(crate) fn refused_data(files: impl Into<String>) -> impl FnOnce(SindyError) -> Self {
        let files = files.into();
        |source| match source {
            SindyError::Setting {
                key,
                expected,
                found,
            } if option_of(key).is_some() => Self::Data {
                at: option_of(key).unwrap_or_default().to_owned(),
                expected,
                found,
            },
            source => Self::Refused {
                what: files,
                source,
            },
        }
    }

    /// The exit status by the table of [`touchdown_terminal::status`].
    pub(crate) fn exit_status(&self) -> u8 {
        use touchdown_log::ErrorKind;
        match self {
            Self::File { .. } | Self::NoRows { .. } | Self::Figure(_) => FAILED,
            Self::Log(e) => match e.kind() {
                ErrorKind::Unreadable | ErrorKind::Unwritable => FAILED,
                _ => BAD_INPUT,
            },
            _ => BAD_INPUT,
        }
    }
}

/// The command's result.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// The option of a setting that is read with the data.
fn option_of(key: &str) -> Option<&'static str> {
    Some(match key {
        "signs" => "--sign",
        "known" => "--known",
        "conserve" => "--conserve",
        "constraints" => "--constraint",
        "second_order" => "--second-order",
        "stable" => "--stable",
        "diffusion" => "--diffusion",
        _ => return None,
    })
}
