//! Where the files of a campaign are: in a folder, or in object storage.

use std::fmt;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use touchdown_log::{LogError, ParquetFile};

use crate::error::{Error, Result};
use crate::files::{self, RESULTS};

/// Files below an address such as `s3://bucket/campaign`. A name has `/` between its folder and its file.
pub trait ObjectStorage: fmt::Debug + Send + Sync {
    /// The address, without `/` at its end.
    fn address(&self) -> &str;

    /// Names of the files in a folder, without it and without those in folders below.
    ///
    /// # Errors
    /// Storage that cannot be read. A folder without files is empty.
    fn names(&self, folder: &str) -> io::Result<Vec<String>>;

    /// The content of a file.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] for a file that is not there; storage that cannot be read.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;

    /// Writes a file; it appears whole or not at all.
    ///
    /// # Errors
    /// Storage that cannot be written.
    fn write(&self, name: &str, bytes: Vec<u8>) -> io::Result<()>;

    /// Removes a file, where it is there.
    ///
    /// # Errors
    /// Storage that cannot be written.
    fn remove(&self, name: &str) -> io::Result<()>;
}

/// Where the files of a campaign are.
#[derive(Clone, Debug)]
pub enum Place {
    /// In a folder.
    Folder(PathBuf),
    /// In object storage.
    Storage(Arc<dyn ObjectStorage>),
}

impl Place {
    /// The path or the address of a file.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        match self {
            Self::Folder(folder) => folder.join(name),
            Self::Storage(storage) => format!("{}/{name}", storage.address()).into(),
        }
    }

    /// Names of the files in a folder. A folder that is not there has none.
    pub(crate) fn names(&self, folder: &str) -> Result<Vec<String>> {
        let names = match self {
            Self::Folder(out) => match std::fs::read_dir(out.join(folder)) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
                Err(e) => Err(e),
                Ok(entries) => entries
                    .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
                    .collect(),
            },
            Self::Storage(storage) => storage.names(folder),
        };
        names.map_err(|e| Error::file(&self.path(folder), e))
    }

    /// The content of a file.
    pub(crate) fn read(&self, name: &str) -> Result<Vec<u8>> {
        let bytes = match self {
            Self::Folder(folder) => std::fs::read(folder.join(name)),
            Self::Storage(storage) => storage.read(name),
        };
        bytes.map_err(|e| Error::file(&self.path(name), e))
    }

    /// The content of a file, or nothing where it is not there.
    pub(crate) fn read_if_there(&self, name: &str) -> Result<Option<Vec<u8>>> {
        match self.read(name) {
            Err(Error::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(None),
            read => read.map(Some),
        }
    }

    /// Opens a Parquet file with this content.
    pub(crate) fn parquet(
        &self,
        name: &str,
        bytes: &[u8],
    ) -> std::result::Result<ParquetFile, LogError> {
        if let Self::Folder(folder) = self {
            return ParquetFile::open(folder.join(name));
        }
        let path = self.path(name).display().to_string();
        let copy = tempfile::tempfile().and_then(|mut file| file.write_all(bytes).map(|()| file));
        match copy {
            Ok(file) => ParquetFile::of(file, path),
            Err(source) => Err(LogError::Read { path, source }),
        }
    }

    /// Writes a file, whole or not at all.
    pub(crate) fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        match self {
            Self::Folder(folder) => files::write(&folder.join(name), &bytes),
            Self::Storage(storage) => storage
                .write(name, bytes)
                .map_err(|e| Error::file(&self.path(name), e)),
        }
    }

    /// Whether a file is there.
    ///
    /// # Errors
    /// Storage that cannot be read.
    pub fn has(&self, name: &str) -> Result<bool> {
        match self {
            Self::Folder(folder) => Ok(folder.join(name).exists()),
            Self::Storage(_) => Ok(self.read_if_there(name)?.is_some()),
        }
    }

    /// Begins to write results: the [`RESULTS`] of an earlier run are removed, because they belong to the files beside them.
    ///
    /// # Errors
    /// A folder that cannot be made, or storage that cannot be written.
    pub fn begin_results(&self) -> Result<()> {
        match self {
            Self::Folder(folder) => files::begin_results(folder),
            Self::Storage(storage) => storage
                .remove(RESULTS)
                .map_err(|e| Error::file(&self.path(RESULTS), e)),
        }
    }

    /// Lets `write` write files into a folder: this one, or one whose files then go to the storage, [`RESULTS`] last.
    ///
    /// # Errors
    /// Those of `write`, and storage that cannot be written.
    pub fn publish<T, E: From<Error>>(
        &self,
        write: impl FnOnce(&Path) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        if let Self::Folder(folder) = self {
            return write(folder);
        }
        let local = tempfile::tempdir().map_err(|e| Error::file(&std::env::temp_dir(), e))?;
        let written = write(local.path())?;
        let mut names = Vec::new();
        files_below(local.path(), "", &mut names)?;
        names.sort_by_key(|name| (name == RESULTS, name.clone()));
        for name in names {
            let path = local.path().join(&name);
            let bytes = std::fs::read(&path).map_err(|e| Error::file(&path, e))?;
            self.write(&name, bytes)?;
        }
        Ok(written)
    }
}

/// Names of all files in a folder and those below, with `/` between.
fn files_below(folder: &Path, before: &str, names: &mut Vec<String>) -> Result<()> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::file(folder, e))?;
    for entry in entries {
        let path = entry.map_err(|e| Error::file(folder, e))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = format!("{before}{name}");
        match path.is_dir() {
            true => files_below(&path, &format!("{name}/"), names)?,
            false => names.push(name),
        }
    }
    Ok(())
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(folder) => folder.display().fmt(f),
            Self::Storage(storage) => f.write_str(storage.address()),
        }
    }
}

impl From<&Path> for Place {
    fn from(folder: &Path) -> Self {
        Self::Folder(folder.to_owned())
    }
}
