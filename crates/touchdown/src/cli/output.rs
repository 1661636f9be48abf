//! What commands write.

use std::path::Path;

use serde::Serialize;
use touchdown::{Error, Result};

pub(crate) use touchdown::files::{folder, write};

/// Pretty JSON with a newline at its end.
pub(crate) fn json<T: Serialize>(object: &T) -> Result<String> {
    let mut text = serde_json::to_string_pretty(object)
        .map_err(|e| Error::Arguments(format!("the result cannot be written as JSON: {e}")))?;
    text.push('\n');
    Ok(text)
}

/// A folder for results: created, and the `results.json` of an earlier run taken away, so that one which is there
/// belongs to the files beside it.
pub(crate) fn results_folder(path: &Path) -> Result<()> {
    folder(path)?;
    let old = path.join("results.json");
    match std::fs::remove_file(&old) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::file(&old, e)),
        _ => Ok(()),
    }
}
