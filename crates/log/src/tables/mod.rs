//! Tables: named columns of numbers from a file, without conversion.

pub(crate) mod csv;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
pub(crate) mod stamps;
mod table;

use crate::{Findings, LogError};
use std::path::Path;

pub use csv::{parse_csv, read_csv, to_csv, write_csv};
#[cfg(feature = "parquet")]
pub use parquet::{
    ParquetColumn, ParquetFile, ParquetRows, ParquetValues, read_parquet, to_parquet,
};
pub use table::{Column, ColumnKind, Table};

/// Reads a table. The content of the file decides its format, not its name; text is read by
/// [`read_csv`].
#[cfg_attr(
    feature = "parquet",
    doc = "",
    doc = "Or Parquet as [`read_parquet`](crate::read_parquet) does."
)]
///
/// # Errors
/// Those of [`read_csv`].
pub fn read_table(path: impl AsRef<Path>) -> Result<(Table, Findings), LogError> {
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(path.as_ref()) {
        return read_parquet(path, None);
    }
    read_csv(path)
}
