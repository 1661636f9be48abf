use crate::limits::Excess;
use sindy_expr::ParseError;
use std::fmt;
use std::io;
use thiserror::Error;
use touchdown_trial::TrialError;

/// Error of reading, mapping or writing.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file is missing or cannot be read.
    #[error("{path}: cannot be read: {source}{}", next_step(.source))]
    Read {
        /// The file.
        path: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The file could not be written; no part of it remains.
    #[error("{path}: cannot be written: {source}")]
    Write {
        /// The file.
        path: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is empty.
    #[error(
        "{path}: expected a header and rows, found an empty file; copy or export the log again, or leave it out"
    )]
    Empty {
        /// The file.
        path: String,
    },
    /// The file is not a text table.
    #[error("{path}: expected a text table in UTF-8, found {found}")]
    NotText {
        /// The file.
        path: String,
        /// What it looks like.
        found: &'static str,
    },
    /// The file has no usable row.
    #[error("{path}: no usable rows: {reason}")]
    NoUsableRows {
        /// The file.
        path: String,
        /// Why no row is usable.
        reason: String,
    },
    /// The file is not a complete log of its format.
    #[error("{path}: no usable log: {found}")]
    NotALog {
        /// The file.
        path: String,
        /// What it looks like.
        found: String,
    },
    /// The file asks for more than a reader takes; the crate's documentation has the table of limits.
    #[error("{path}: refused: expected at most {most}, found {found}")]
    Excess {
        /// The file.
        path: String,
        /// The limit.
        most: String,
        /// What the file asks for.
        found: String,
    },
    /// The file of a map is missing or cannot be read.
    #[error(
        "{path}: cannot be read as a map: {source}; expected a TOML file or one of the built-in maps px4, ardupilot, ros and fly"
    )]
    Map {
        /// The file.
        path: String,
        /// The system's reason.
        source: io::Error,
    },
    /// A map is not TOML, or has an unknown or missing key or a wrong type.
    #[error("{at}: {message}")]
    MapToml {
        /// Where.
        at: Box<Place>,
        /// The expected and the found content.
        message: String,
    },
    /// A value in a map is out of range.
    #[error("{at}: expected {expected}, found {found}")]
    MapValue {
        /// Where.
        at: Box<Place>,
        /// The allowed values.
        expected: String,
        /// The offending value.
        found: String,
    },
    /// An expression in a map cannot be parsed.
    #[error("{at}: {source}")]
    MapExpression {
        /// Where.
        at: Box<Place>,
        /// What is wrong with it.
        source: Box<ParseError>,
    },
    /// An expression in a map names a column that the table lacks.
    #[error("{at}: {table} has no column {found:?}{}; it has {}", hint(.nearest), list(.available))]
    UnknownColumn {
        /// Where.
        at: Box<Place>,
        /// The file with the table.
        table: String,
        /// The unknown name.
        found: String,
        /// The column with the most similar name.
        nearest: Option<String>,
        /// The columns of the table.
        available: Vec<String>,
    },
    /// An expression in a map uses a column of text.
    #[error("{at}: column {found:?} of {table} holds text, such as {example:?}, not numbers")]
    TextColumn {
        /// Where.
        at: Box<Place>,
        /// The file with the table.
        table: String,
        /// The column.
        found: String,
        /// One of its cells.
        example: String,
    },
    /// A column with the name of a channel has no numbers.
    #[error(
        "{path}: expected numbers in the column {found:?}, found text such as {example:?}{why}"
    )]
    TextChannel {
        /// The file with the table.
        path: String,
        /// The column.
        found: String,
        /// One of its cells.
        example: String,
        /// What the reader says of the column, after a colon, or nothing.
        why: String,
    },
    /// A foreign table without a map.
    #[error(
        "{path}: expected a column time_s or a map, found the columns {}; a map to start from:\n{}",
        list(.columns), head(.suggested)
    )]
    NeedsMap {
        /// The file.
        path: String,
        /// The columns of the table.
        columns: Vec<String>,
        /// The text of a map to start from.
        suggested: String,
    },
    /// The mapped channels do not form a valid trial.
    #[error("{path}: {source}")]
    Trial {
        /// The file.
        path: String,
        /// What is wrong with it.
        source: TrialError,
    },
}

/// A place in a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The map's file.
    pub map: String,
    /// Line number from 1.
    pub line: usize,
    /// The key, with its table: `channels.thrust_n`. Empty where it is unknown.
    pub key: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}", self.map, self.line)?;
        if self.key.is_empty() {
            Ok(())
        } else {
            write!(f, ", {}", self.key)
        }
    }
}

/// The classes of [`LogError`] that a program may report by different exit statuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file is missing or unreadable, or holds no usable rows.
    Unreadable,
    /// A map is wrong, or asks for a column that does not exist.
    BadInput,
    /// The result cannot be written.
    Unwritable,
}

impl LogError {
    /// The refusal of a file beyond a limit.
    pub(crate) fn excess(path: &str, excess: Excess) -> Self {
        Self::Excess {
            path: path.to_owned(),
            most: excess.most,
            found: excess.found,
        }
    }

    /// The class of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Read { .. }
            | Self::Empty { .. }
            | Self::NotText { .. }
            | Self::NotALog { .. }
            | Self::Excess { .. }
            | Self::NoUsableRows { .. } => ErrorKind::Unreadable,
            Self::Write { .. } => ErrorKind::Unwritable,
            Self::Map { .. }
            | Self::MapToml { .. }
            | Self::MapValue { .. }
            | Self::MapExpression { .. }
            | Self::UnknownColumn { .. }
            | Self::TextColumn { .. }
            | Self::TextChannel { .. }
            | Self::NeedsMap { .. }
            | Self::Trial { .. } => ErrorKind::BadInput,
        }
    }
}

/// What to do about a file that cannot be read.
fn next_step(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::NotFound => {
            "; check the path, which is relative to the folder in which the command runs"
        }
        io::ErrorKind::PermissionDenied => "; check who may read the file",
        io::ErrorKind::IsADirectory => "; name the logs in the folder, such as FOLDER/*.csv",
        _ => "",
    }
}

/// Columns that a sentence names at most, and lines of a map in it: more are not read.
const MOST_NAMES: usize = 20;
const MOST_LINES: usize = 60;

fn list(names: &[String]) -> String {
    let quoted = names.iter().take(MOST_NAMES);
    let quoted: Vec<String> = quoted.map(|name| format!("{name:?}")).collect();
    match names.len().saturating_sub(MOST_NAMES) {
        0 => quoted.join(", "),
        more => format!("{} and {more} more", quoted.join(", ")),
    }
}

/// The first lines of a text, and how many follow.
fn head(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    match lines.len().saturating_sub(MOST_LINES) {
        0 => text.to_string(),
        more => format!(
            "{}\n# … {more} more lines, which `touchdown inspect FILE` prints\n",
            lines[..MOST_LINES].join("\n")
        ),
    }
}

fn hint(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map_or_else(String::new, |name| format!(" (did you mean {name:?}?)"))
}
