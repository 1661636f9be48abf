//! Whole files or none.

use std::path::Path;

use crate::{Error, Result};

/// Writes `bytes` to `path`, replacing what was there only when all of it is on disk.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    touchdown_files::write_whole(path, bytes).map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}
