//! Files: written whole or not at all.

use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};

/// Creates a folder and those above it.
///
/// # Errors
/// A file of that name, or a folder that cannot be made.
pub fn folder(path: &Path) -> Result<()> {
    if path.is_file() {
        let path = path.display();
        return Err(Error::Arguments(format!(
            "{path}: expected a folder, found a file"
        )));
    }
    std::fs::create_dir_all(path).map_err(|e| Error::file(path, e))
}

/// Writes to a temporary file in the same folder, then renames it.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    folder(touchdown_files::folder_of(path))?;
    touchdown_files::write_whole(path, bytes).map_err(|e| Error::file(path, e))
}

/// The file of results. It is written last, so its presence means that all files are complete.
pub const RESULTS: &str = "results.json";

/// Creates a folder for results and removes the [`RESULTS`] of an earlier run: one that is there belongs to the files
/// beside it.
///
/// # Errors
/// A folder that cannot be made, or a file that cannot be removed.
pub fn begin_results(path: &Path) -> Result<()> {
    folder(path)?;
    let old = path.join(RESULTS);
    match std::fs::remove_file(&old) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::file(&old, e)),
        _ => Ok(()),
    }
}

/// Writes the results into their folder, as pretty JSON with a newline at its end.
///
/// # Errors
/// Results that JSON cannot hold, or a file that cannot be written.
pub fn results<T: Serialize>(folder: &Path, results: &T) -> Result<()> {
    let mut text = serde_json::to_string_pretty(results)
        .map_err(|e| Error::Arguments(format!("the result cannot be written as JSON: {e}")))?;
    text.push('\n');
    write(&folder.join(RESULTS), text.as_bytes())
}
