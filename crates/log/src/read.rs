//! Reads a file into a trial in one step.

use crate::inspection::Inspector;
use crate::tables::{self, GatheredColumns};
use crate::{Findings, Inspection, LogError, Map, apply, read_table};
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
/// Of a table with a map only the columns that the map names are held in memory. Their types are those of the first 4 MB of a
/// text table in which they have values.
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
    if let Some(map) = map {
        let names = map.names();
        let (table, read) = tables::read_columns(path.as_ref(), &|name| names.contains(name))?;
        let (trial, applied) = apply(&table, map)?;
        return Ok((trial, read.then(applied)));
    }
    let (table, read) = read_table(path)?;
    let (trial, applied) = apply(&table, &Map::identity_for(&table)?)?;
    Ok((trial, read.then(applied)))
}

/// What is in a table's file, and its trial by a map, in one pass: of the columns only those that the map names are held.
///
/// # Errors
/// Those of [`inspect_file`](crate::inspect_file) and [`apply`].
pub fn inspect_mapped(
    path: impl AsRef<Path>,
    map: &Map,
) -> Result<(Inspection, Trial, Findings), LogError> {
    let path = path.as_ref();
    let names = map.names();
    let wanted = |name: &str| names.contains(name);
    let (bytes, parts) = tables::size_in_parts(path);
    let mut looking = Inspector::new(None);
    let mut gathered = GatheredColumns::new(&wanted, parts);
    let (sha256, read) = tables::each_part(path, &mut |part| {
        looking.part(&part.columns, &part.row_numbers);
        gathered.add(part.columns, &part.row_numbers);
    })?;
    let name = path.display().to_string();
    let (trial, applied) = apply(&gathered.table(&name, sha256.clone(), bytes), map)?;
    Ok((
        looking.finish(&name, Some(sha256)),
        trial,
        read.then(applied),
    ))
}
