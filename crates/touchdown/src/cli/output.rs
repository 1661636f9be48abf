//! Files: written whole or not at all.

use std::io::Write as _;
use std::path::Path;

use serde::Serialize;
use touchdown::{Error, Result};

/// Pretty JSON with a newline at its end.
pub(crate) fn json<T: Serialize>(object: &T) -> Result<String> {
    let mut text = serde_json::to_string_pretty(object)
        .map_err(|e| Error::Arguments(format!("the result cannot be written as JSON: {e}")))?;
    text.push('\n');
    Ok(text)
}

/// Creates a folder and those above it.
pub(crate) fn folder(path: &Path) -> Result<()> {
    if path.is_file() {
        let path = path.display();
        return Err(Error::Arguments(format!(
            "{path}: expected a folder, found a file"
        )));
    }
    std::fs::create_dir_all(path).map_err(|e| Error::file(path, e))
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

/// Writes to a temporary file in the same folder, then renames it.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let above = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    folder(above)?;
    let fail = |e| Error::file(path, e);
    let mut file = tempfile::Builder::new()
        .prefix(".touchdown-")
        .tempfile_in(above)
        .map_err(fail)?;
    file.write_all(bytes).map_err(fail)?;
    public(file.as_file()).map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// A temporary file is private to its owner; a result is for everyone who may read the folder.
#[cfg(unix)]
fn public(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn public(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}
