//! Errors of model cards.

use std::path::PathBuf;

use thiserror::Error;

/// What is wrong with a card.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CardError {
    /// The file is missing or cannot be read.
    #[error("{path}: cannot be read as a model card: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file cannot be written; nothing is left of it.
    #[error("{path}: cannot be written: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not a card: bad TOML, an unknown key, a wrong type.
    #[error("{file}: {message}")]
    Text {
        /// The file's name.
        file: String,
        /// Line, key, expected and found.
        message: String,
    },
    /// A card of another schema.
    #[error("{file}: key `schema`: expected {expected}, found {found}")]
    Schema {
        /// The file's name.
        file: String,
        /// The schema that this version reads.
        expected: u32,
        /// What the file says.
        found: String,
    },
    /// A value that makes no sense.
    #[error("{card}: key `{key}`: expected {expected}, found {found}")]
    Value {
        /// The card's name or file.
        card: String,
        /// The key.
        key: String,
        /// What is allowed.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A model that no flight family can hold.
    #[error("card `{card}`: {reason}")]
    NotForFlight {
        /// The card's name.
        card: String,
        /// What does not fit.
        reason: String,
    },
}
