//! Reads a file into a trial in one step.

use crate::{Findings, LogError, Map, apply, read_table};
use std::path::Path;
use touchdown_trial::Trial;

/// Reads a file and makes its trial, by the map or directly if the columns have our channel names.
#[cfg_attr(
    feature = "flight-logs",
    doc = "",
    doc = "The content decides the format. A log with topics and without a map is read by the",
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
    #[cfg(feature = "parquet")]
    if let (Some(map), true) = (map, crate::tables::parquet::is_parquet(path.as_ref())) {
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
