//! Files: written whole or not at all.

use std::path::Path;

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
