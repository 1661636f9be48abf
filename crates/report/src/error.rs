//! What can be wrong with a figure, a table or a file.

use std::path::PathBuf;

/// A figure or table that does not make sense, or a file that could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The figure's id cannot be a file name.
    #[error("figure id {found:?}: expected letters, digits, '-' and '_', at least one")]
    Id {
        /// The id as given.
        found: String,
    },
    /// A figure without panels.
    #[error("figure {figure:?}: expected at least one panel, found none")]
    NoPanels {
        /// Figure id.
        figure: String,
    },
    /// Two columns of one series differ in length.
    #[error(
        "figure {figure:?}, series {series:?}: {column} has {found} values, expected {expected} as in x"
    )]
    Length {
        /// Figure id.
        figure: String,
        /// Series name.
        series: String,
        /// Column at fault: `y`, `lower`, `upper` or `plus_minus`.
        column: &'static str,
        /// Length of x.
        expected: usize,
        /// Length of the column.
        found: usize,
    },
    /// A setting outside what is allowed.
    #[error("figure {figure:?}: {key} is {found}, expected {expected}")]
    Setting {
        /// Figure id.
        figure: String,
        /// Which setting.
        key: &'static str,
        /// What is allowed.
        expected: &'static str,
        /// What was given.
        found: String,
    },
    /// A table row whose number of cells is not the number of columns.
    #[error("table {table:?}, row {row}: {found} cells, expected {expected}, one for each column")]
    Row {
        /// Caption of the table.
        table: String,
        /// Row number, from 1.
        row: usize,
        /// Number of columns.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// The picture could not be encoded as PNG.
    #[error("figure {figure:?}: PNG not encoded: {reason}")]
    Png {
        /// Figure id.
        figure: String,
        /// What the encoder said.
        reason: String,
    },
    /// A file could not be written. Nothing half-written is left behind.
    #[error("{}: not written: {source}", path.display())]
    Write {
        /// The file wanted.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}
