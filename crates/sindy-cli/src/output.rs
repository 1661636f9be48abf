//! Files: written whole or not at all.

use std::path::{Path, PathBuf};

use touchdown_files::folder_of;

use crate::error::{Error, Result};

/// Writes to a temporary file in the same folder, then renames it.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    touchdown_files::write(path, bytes).map_err(|e| Error::file(path, e))
}

/// Refuses, before any work is done, outputs that cannot become files, that would overwrite an input, or that are
/// one and the same file.
pub(crate) fn check<'a>(
    outputs: impl Iterator<Item = &'a PathBuf>,
    inputs: impl Iterator<Item = &'a PathBuf>,
) -> Result<()> {
    let inputs: Vec<PathBuf> = inputs.map(|p| resolved(p)).collect();
    let mut taken: Vec<PathBuf> = Vec::new();
    // A dash is standard output.
    for path in outputs.filter(|p| p.as_os_str() != "-") {
        let shown = path.display();
        if path.is_dir() {
            return Err(Error::Arguments(format!(
                "{shown}: expected a file to write, found a folder"
            )));
        }
        let whole = resolved(path);
        if inputs.contains(&whole) {
            return Err(Error::Arguments(format!(
                "{shown}: expected a file that is not read as well, found one of the inputs"
            )));
        }
        if taken.contains(&whole) {
            return Err(Error::Arguments(format!(
                "{shown}: expected a file for each output, found two outputs that go there"
            )));
        }
        taken.push(whole);
    }
    Ok(())
}

/// The path without detours, as far as it is there already.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    let name = path.file_name().unwrap_or_default();
    let above = folder_of(path);
    above
        .canonicalize()
        .unwrap_or_else(|_| above.to_owned())
        .join(name)
}
