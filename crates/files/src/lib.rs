//! Files: written whole or not at all, and opened only where they can be read more than once; what is wrong with a
//! TOML file, in one sentence.

mod toml_error;

pub use toml_error::TomlError;

use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};

/// Names of temporary files begin with this: whoever finds one after a crash may delete it.
pub const TEMPORARY_PREFIX: &str = ".touchdown-";

/// Writers share it; whoever ends the process takes it alone, see [`pause`].
static WRITERS: RwLock<()> = RwLock::new(());

/// Opens a regular file for reading. A pipe would wait for its writer, ends after one reading and has no size; a
/// device may never end. Neither is opened.
///
/// # Errors
/// A file that is not there or cannot be read, a folder, a pipe and a device.
pub fn open(path: &Path) -> io::Result<File> {
    refuse_address(path)?;
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let found = if kind.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    } else if is_pipe(kind) {
        "a pipe, which can be read only once; save its content to a file first"
    } else {
        "a device"
    };
    let text = format!("expected a file, found {found}");
    Err(io::Error::new(io::ErrorKind::InvalidInput, text))
}

/// Whether a path is an address such as `s3://bucket/name`; also as `s3:/bucket/name`, which is what becomes of it where paths
/// are put in order.
#[must_use]
pub fn is_address(path: &Path) -> bool {
    let text = path.to_string_lossy();
    let Some((scheme, rest)) = text.trim_start().split_once(':') else {
        return false;
    };
    let is_scheme = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    let of_storage = ["s3", "gs", "az"].contains(&scheme.to_ascii_lowercase().as_str());
    is_scheme && (of_storage || rest.starts_with("//"))
}

/// Refuses an address in place of a file: it would become a folder of that name.
fn refuse_address(path: &Path) -> io::Result<()> {
    match is_address(path) {
        false => Ok(()),
        true => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "expected a file, found an address",
        )),
    }
}

/// Longest text that is read whole (bytes): settings, maps and cards have some thousands. A device that never ends would fill
/// the memory; twice or half of this refuses no file that anyone writes.
const LONGEST_TEXT: u64 = 16 << 20;

/// Reads a text that is short by its nature (settings, a map, a card), from a file or a pipe.
///
/// # Errors
/// A file that cannot be read, one of more than 16 MiB (or without an end), and one that is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    refuse_address(path)?;
    // The length is counted before the text is judged: a limit can lie within a character.
    let mut bytes = Vec::new();
    File::open(path)?
        .take(LONGEST_TEXT + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST_TEXT {
        let text = format!("expected a text of at most {LONGEST_TEXT} bytes, found more");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    bytes.as_slice().read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(unix)]
fn is_pipe(kind: std::fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    kind.is_fifo() || kind.is_socket()
}

#[cfg(not(unix))]
fn is_pipe(_: std::fs::FileType) -> bool {
    true
}

/// Writes to a temporary file in the same folder, which must exist, then renames it: the file appears whole or not at
/// all, with the rights that a new file usually gets.
///
/// # Errors
/// A file that cannot be written; what was at `path` before is then still there.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    refuse_address(path)?;
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
    refuse_address(path)?;
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
    fn regress_a_text_without_end_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long.toml");
        let file = File::create(&path).unwrap();
        file.set_len(LONGEST_TEXT).unwrap();
        assert_eq!(read_text(&path).unwrap().len() as u64, LONGEST_TEXT);
        file.set_len(LONGEST_TEXT + 1).unwrap();
        let error = read_text(&path).unwrap_err().to_string();
        assert!(error.contains("at most 16777216 bytes"), "{error}");
        std::fs::write(&path, b"\xff").unwrap();
        assert!(read_text(&path).is_err(), "not UTF-8");
        #[cfg(unix)]
        assert!(read_text(Path::new("/dev/zero")).is_err());
    }

    #[test]
    fn prop_an_address_is_no_file() {
        for address in [
            "s3://b/x",
            "S3://b",
            "https://h/x",
            "az:/c/x",
            " gs://b",
            "s3:b",
        ] {
            let path = Path::new(address);
            assert!(is_address(path), "{address}");
            for error in [
                write(path, b"one").unwrap_err(),
                read_text(path).unwrap_err(),
            ] {
                assert!(error.to_string().contains("found an address"), "{error}");
            }
        }
        for path in [
            "a:b", "c/d", "e:/f", "://g", "a/s3://b", "C:\\x", "s3", "a b://c",
        ] {
            assert!(!is_address(Path::new(path)), "{path}");
        }
        assert!(!Path::new("s3:").exists());
    }

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
    #[cfg(unix)]
    fn prop_only_regular_files_are_opened() {
        use std::os::unix::net::UnixListener;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_whole(&file, b"one").unwrap();
        assert!(open(&file).is_ok());
        let reason = |path: &Path| open(path).unwrap_err().to_string();
        let socket = folder.path().join("socket");
        let _listener = UnixListener::bind(&socket).unwrap();
        assert!(reason(&socket).contains("found a pipe"));
        assert!(reason(Path::new("/dev/null")).contains("found a device"));
        assert_eq!(
            open(folder.path()).unwrap_err().kind(),
            io::ErrorKind::IsADirectory
        );
        assert_eq!(
            open(&folder.path().join("none")).unwrap_err().kind(),
            io::ErrorKind::NotFound
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
