//! Files: written whole or not at all.

use std::io::{self, Write};
use std::path::Path;

/// Temporary files begin so; what a killed process leaves of them can be taken away.
pub const TEMPORARY_PREFIX: &str = ".touchdown-";

/// Writes to a temporary file in the same folder, which must exist, then renames it: the file appears whole or not at
/// all, with the rights that a new file usually gets.
///
/// # Errors
/// A file that cannot be written; what was at `path` before is then still there.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY_PREFIX);
    // A temporary file is private to its owner; a result is for everyone who may read the folder.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}
