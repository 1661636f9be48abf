//! Files: written whole or not at all.

use std::path::Path;

use serde::Serialize;

use crate::error::{Error, Result};

/// Creates a folder and those above it.
///
/// # Errors
/// An address such as `s3://bucket`, a file of that name, or a folder that cannot be made.
pub fn folder(path: &Path) -> Result<()> {
    if touchdown_files::is_address(path) {
        let path = path.display();
        return Err(Error::Arguments(format!(
            "{path}: expected a folder, found an address: only campaigns are in object storage"
        )));
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_addresses_are_refused_and_folders_are_not() {
        for address in [
            "s3://bucket/x",
            "gs://b",
            "az://c/d",
            "https://host/x",
            "file:///tmp/x",
            "s3:/bucket/x",
            " s3://bucket/x",
            "gs:bucket",
        ] {
            let error = folder(Path::new(address)).unwrap_err().to_string();
            assert!(error.contains("found an address"), "{error}");
        }
        let here = tempfile::tempdir().unwrap();
        for name in ["a:b", "c/d", "e:/f", "://g"] {
            folder(&here.path().join(name)).unwrap();
        }
    }
}
