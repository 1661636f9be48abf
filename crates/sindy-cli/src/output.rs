//! Files: written whole or not at all.

use std::io::Write as _;
use std::path::Path;

use crate::error::{Error, Result};

/// Writes to a temporary file in the same folder, then renames it.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let above = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let fail = |e| Error::file(path, e);
    std::fs::create_dir_all(above).map_err(fail)?;
    let mut file = tempfile::Builder::new()
        .prefix(".sindy-")
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

/// Refuses a path that cannot become a file, before any work is done for it.
pub(crate) fn check(path: &Path) -> Result<()> {
    if path.is_dir() {
        let path = path.display();
        return Err(Error::Arguments(format!(
            "{path}: expected a file to write, found a folder"
        )));
    }
    Ok(())
}
