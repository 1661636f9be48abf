//! Files: written whole or not at all; what is wrong with a TOML file, in one sentence.

mod toml_error;

pub use toml_error::TomlError;

use std::io::{self, Write as _};
use std::path::Path;
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};

/// Names of temporary files begin with this: whoever finds one after a crash may delete it.
pub const TEMPORARY_PREFIX: &str = ".touchdown-";

/// Writers share it; whoever ends the process takes it alone, see [`pause`].
static WRITERS: RwLock<()> = RwLock::new(());

/// Writes to a temporary file in the same folder, which must exist, then renames it: the file appears whole or not at
/// all, with the rights that a new file usually gets.
///
/// # Errors
/// A file that cannot be written; what was at `path` before is then still there.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let _writing = WRITERS.read().unwrap_or_else(PoisonError::into_inner);
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY_PREFIX);
    // A temporary file is private to its owner; a result is for everyone who may read the folder.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder_of(path))?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// As [`write_whole`], and creates the folders above the file.
///
/// # Errors
/// A file or a folder that cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    std::fs::create_dir_all(folder_of(path))?;
    write_whole(path, bytes)
}

/// The folder that a file is in.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Waits until every file that is being written is whole, and lets no other begin while the guard lives. A process that
/// exits with it leaves no temporary file behind.
pub fn pause() -> RwLockWriteGuard<'static, ()> {
    WRITERS.write().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_file_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.txt");
        assert!(write_whole(&path, b"one").is_err());
        write(&path, b"one").unwrap();
        write_whole(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        // A folder in its place cannot be replaced, and nothing temporary stays.
        assert!(write(&folder.path().join("a"), b"three").is_err());
        let left = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
        assert_eq!(
            (left(folder.path()), left(&folder.path().join("a"))),
            (1, 1)
        );
    }

    #[test]
    fn prop_nothing_is_written_during_a_pause() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let pause = pause();
        let writer = std::thread::spawn({
            let path = path.clone();
            move || write_whole(&path, b"one")
        });
        std::thread::yield_now();
        assert!(!path.exists());
        drop(pause);
        writer.join().unwrap().unwrap();
        assert!(path.exists());
    }
}
