//! From a file to a trial in one step.

use crate::apply::apply;
use crate::csv_parts::inspect_csv;
use crate::{Findings, Inspection, LogError, Map, Table, read_csv};
use std::path::Path;
use touchdown_trial::Trial;

/// Reads a file and makes its trial: by the map, or as it is where the columns have our own names.
#[cfg_attr(
    feature = "flight-logs",
    doc = "",
    doc = "The format is told by the content. A log with topics and without a map is read by the",
    doc = "[built-in map](Map::built_in) that fits it."
)]
///
/// # Errors
/// Those of [`read_table`], [`Map::identity_for`] and [`apply`].
pub fn read_trial(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<(Trial, Findings), LogError> {
    #[cfg(feature = "flight-logs")]
    if let Some(log) = crate::Log::open(path.as_ref())? {
        return log.trial(map);
    }
    #[cfg(feature = "flight-logs")]
    if let (Some(map), true) = (map, is_parquet(path.as_ref())) {
        let names = map.names();
        let (table, read) = crate::read_parquet(path, Some(&|name| names.contains(name)))?;
        let (trial, applied) = apply(&table, map)?;
        return Ok((trial, read.then(applied)));
    }
    let (table, read) = read_table(path)?;
    let (trial, applied) = match map {
        Some(map) => apply(&table, map)?,
        None => apply(&table, &Map::identity_for(&table)?)?,
    };
    Ok((trial, read.then(applied)))
}

/// Reads a table, whatever the name of its file ends with: text as [`read_csv`] does.
#[cfg_attr(
    feature = "flight-logs",
    doc = "",
    doc = "Or Parquet as [`read_parquet`](crate::read_parquet) does."
)]
///
/// # Errors
/// Those of [`read_csv`].
pub fn read_table(path: impl AsRef<Path>) -> Result<(Table, Findings), LogError> {
    #[cfg(feature = "flight-logs")]
    if is_parquet(path.as_ref()) {
        return crate::read_parquet(path, None);
    }
    read_csv(path)
}

/// Tells what the table in a file holds, as [`inspect`](crate::inspect()) does of one in memory, in
/// memory that does not grow with the file.
///
/// What a column of a text table holds is settled by the first 4 MB in which it holds anything.
#[cfg_attr(
    feature = "flight-logs",
    doc = "",
    doc = "Of a Parquet file one row group is held at a time."
)]
///
/// # Errors
/// Those of [`read_table`], and [`LogError::NotText`] for a line of more than 64 MB.
pub fn inspect_file(path: impl AsRef<Path>) -> Result<(Inspection, Findings), LogError> {
    #[cfg(feature = "flight-logs")]
    if is_parquet(path.as_ref()) {
        return crate::flight::inspect_parquet(path.as_ref());
    }
    inspect_csv(path.as_ref())
}

/// By its first bytes; what cannot be opened is for others to tell.
#[cfg(feature = "flight-logs")]
fn is_parquet(path: &Path) -> bool {
    use std::io::Read;
    let mut start = [0; 4];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == crate::flight::PARQUET
}
