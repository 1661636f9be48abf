//! Whole files or none: written under a temporary name, then renamed.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Writes `bytes` to `path`, replacing what was there only when all of it is on disk.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    let temporary = temporary_name(path);
    let outcome = write_and_rename(&temporary, path, bytes);
    if outcome.is_err() {
        // The reason worth telling is the first one, not that the rest could not be removed.
        let _ = fs::remove_file(&temporary);
    }
    outcome.map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}

fn write_and_rename(temporary: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = fs::File::create(temporary)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    drop(file);
    fs::rename(temporary, path)
}

/// Beside the target, so that the rename stays within one file system; the process id keeps two writers apart.
fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
