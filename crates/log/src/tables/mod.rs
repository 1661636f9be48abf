//! Tables: named columns of numbers from a file, without conversion.

pub(crate) mod csv;
mod gather;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
pub(crate) mod stamps;
mod table;

use crate::{Findings, LogError};
use std::path::Path;

pub(crate) use csv::TablePart;
pub(crate) use gather::{GatheredColumns, SPARE};

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

/// Approximate size of a part of a text table, bytes.
const PART: usize = 4 << 20;

/// Passes the rows of a table on part by part, in memory that does not grow with the file: 4 MB of a text table, a row group of
/// Parquet. Of Parquet, columns that are not wanted are not read. Returns the file's SHA-256.
pub(crate) fn each_part(
    path: &Path,
    wanted: Option<&dyn Fn(&str) -> bool>,
    visit: &mut dyn FnMut(TablePart),
) -> Result<(String, Findings), LogError> {
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(path) {
        return parquet::each_group(path, wanted, None, &mut |columns, rows| {
            visit(TablePart {
                row_numbers: rows.collect(),
                columns,
            });
        });
    }
    #[cfg(not(feature = "parquet"))]
    let _ = wanted;
    let name = path.display().to_string();
    let file = touchdown_files::open(path).map_err(|source| LogError::Read {
        path: name.clone(),
        source,
    })?;
    csv::each_part(&name, file, PART, visit)
}

/// The size of a file, and how many parts of a text table it is.
pub(crate) fn size_in_parts(path: &Path) -> (u64, f64) {
    let bytes = std::fs::metadata(path).map_or(0, |file| file.len());
    (bytes, bytes as f64 / PART as f64)
}

/// As [`read_table`] for some of the columns. The others are never in memory as a whole.
///
/// The type of a column in a text table is that of the first 4 MB in which it has values.
pub(crate) fn read_columns(
    path: &Path,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<(Table, Findings), LogError> {
    #[cfg(feature = "parquet")]
    if parquet::is_parquet(path) {
        return read_parquet(path, Some(wanted));
    }
    let (bytes, parts) = size_in_parts(path);
    let mut gathered = GatheredColumns::new(wanted, parts);
    let (sha256, findings) = each_part(path, None, &mut |part| {
        gathered.add(part.columns, &part.row_numbers);
    })?;
    Ok((
        gathered.table(&path.display().to_string(), sha256, bytes),
        findings,
    ))
}
