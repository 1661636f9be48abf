//! What commands write.

use std::path::Path;

use serde::Serialize;
use touchdown::{Error, Result};

use super::context::Context;

pub(crate) use touchdown_campaign::files::{folder, write};

/// The file of results. Commands write it last, so its presence means that all files are complete.
pub(super) const RESULTS: &str = "results.json";

/// Writes the results into their folder, as pretty JSON with a newline at its end.
pub(crate) fn results<T: Serialize>(folder: &Path, results: &T) -> Result<()> {
    let mut text = serde_json::to_string_pretty(results)
        .map_err(|e| Error::Arguments(format!("the result cannot be written as JSON: {e}")))?;
    text.push('\n');
    Ok(write(&folder.join(RESULTS), text.as_bytes())?)
}

/// Refuses an `--out` that is a file, before any work is done.
pub(crate) fn must_not_be_a_file(out: Option<&Path>) -> Result<()> {
    match out.filter(|out| out.is_file()) {
        None => Ok(()),
        Some(out) => Err(Error::Arguments(format!(
            "--out {}: expected a folder, found a file",
            out.display()
        ))),
    }
}

/// Creates a folder for results and removes the `results.json` of an earlier run: one that is there belongs to the files
/// beside it.
pub(crate) fn results_folder(context: &Context, path: &Path) -> Result<()> {
    folder(path)?;
    let old = path.join(RESULTS);
    match std::fs::remove_file(&old) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::file(&old, e)),
        _ => {}
    }
    let folder = path.display().to_string();
    context.if_interrupted(move || match old.exists() {
        true => format!("all files are in {folder}"),
        false => missing(&folder),
    });
    Ok(())
}

/// Report of an interrupted command about an incomplete folder.
pub(crate) fn missing(folder: &str) -> String {
    format!(
        "the files in {folder} are complete, but some are missing ({RESULTS} is written last); run the same command again"
    )
}
