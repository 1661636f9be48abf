//! Reads a file into a trial in one step.

use crate::inspection::Inspector;
use crate::map::by_parts::MappedParts;
use crate::tables;
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
/// Of a table with a map only the channels are held in memory. The types of its columns are those of the first 4 MB of a text table in
/// which they have values.
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
        let path = path.as_ref();
        let names = map.names();
        let wanted = |name: &str| names.contains(name);
        let mut mapped = mapped_parts(path, map);
        let (sha256, read) = tables::each_part(path, Some(&wanted), &mut |part| mapped.add(part))?;
        return match mapped.trial(&sha256) {
            Some(Ok((trial, applied))) => Ok((trial, read.then(applied))),
            // An error names all columns that there are, and of Parquet only those that are wanted were read.
            _ => whole(path, map),
        };
    }
    let (table, read) = read_table(path)?;
    let map = Map::identity_for(&table).map_err(|error| explained(error, &read))?;
    let (trial, applied) = apply(&table, &map)?;
    Ok((trial, read.then(applied)))
}

/// The refusal of a column of text with what the reader says of it.
fn explained(mut error: LogError, read: &Findings) -> LogError {
    if let LogError::TextChannel { found, why, .. } = &mut error {
        let said = read
            .warnings
            .iter()
            .find(|w| w.contains(&format!("{found:?}")));
        *why = said.map_or_else(String::new, |said| format!(": {said}"));
    }
    error
}

/// What is in a table's file, and its trial by a map, in one pass: only the channels are held.
///
/// # Errors
/// Those of [`inspect_file`](crate::inspect_file) and [`apply`].
pub fn inspect_mapped(
    path: impl AsRef<Path>,
    map: &Map,
) -> Result<(Inspection, Trial, Findings), LogError> {
    let path = path.as_ref();
    let mut looking = Inspector::new(None);
    let mut mapped = mapped_parts(path, map);
    let (sha256, read) = tables::each_part(path, None, &mut |part| {
        looking.part(&part.columns, &part.row_numbers);
        mapped.add(part);
    })?;
    let (trial, findings) = match mapped.trial(&sha256) {
        Some(made) => made.map(|(trial, applied)| (trial, read.then(applied)))?,
        None => whole(path, map)?,
    };
    let name = path.display().to_string();
    Ok((looking.finish(&name, Some(sha256)), trial, findings))
}

fn mapped_parts<'a>(path: &Path, map: &'a Map) -> MappedParts<'a> {
    let (bytes, parts) = tables::size_in_parts(path);
    MappedParts::new(map, &path.display().to_string(), bytes, parts)
}

/// Applies a map to the columns that it names, which are held as a whole.
fn whole(path: &Path, map: &Map) -> Result<(Trial, Findings), LogError> {
    let names = map.names();
    let (table, read) = tables::read_columns(path, &|name| names.contains(name))?;
    let (trial, applied) = apply(&table, map)?;
    Ok((trial, read.then(applied)))
}
