//! From a file to a trial in one step.

use crate::apply::apply;
use crate::{Findings, LogError, Map, read_csv};
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
/// Those of [`read_csv`], [`Map::identity_for`] and [`apply`].
pub fn read_trial(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<(Trial, Findings), LogError> {
    #[cfg(feature = "flight-logs")]
    if let Some(log) = crate::Log::open(path.as_ref())? {
        return log.trial(map);
    }
    let (table, read) = read_csv(path)?;
    let (trial, applied) = match map {
        Some(map) => apply(&table, map)?,
        None => apply(&table, &Map::identity_for(&table)?)?,
    };
    Ok((trial, read.then(applied)))
}
