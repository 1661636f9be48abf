//! Files: written whole or not at all.

use std::io::Write as _;
use std::path::Path;

use crate::error::{Error, Result};

/// Temporary files begin so; what a killed process leaves of them can be taken away.
pub(crate) const TEMPORARY: &str = ".touchdown-";

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
    let above = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    folder(above)?;
    let fail = |e| Error::file(path, e);
    let mut file = tempfile::Builder::new()
        .prefix(TEMPORARY)
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
