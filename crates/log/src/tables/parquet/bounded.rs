//! A file for the Parquet reader that rejects lengths beyond its end.

use bytes::Bytes;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

/// A file of known length. Its readers share one open file, because WASI cannot duplicate its descriptor.
#[derive(Clone)]
pub(super) struct Bounded {
    file: Arc<Mutex<File>>,
    length: u64,
}

impl Bounded {
    pub(super) fn new(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        let file = Arc::new(Mutex::new(file));
        Ok(Self { file, length })
    }

    fn from(&self, start: u64) -> Ending {
        let file = Arc::clone(&self.file);
        Ending { file, at: start }
    }
}

impl Length for Bounded {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for Bounded {
    type T = BufReader<Ending>;

    fn get_read(&self, start: u64) -> Result<Self::T> {
        Ok(BufReader::new(self.from(start)))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        let end = start.checked_add(length as u64);
        if end.is_none_or(|end| end > self.length) {
            return Err(ParquetError::EOF(format!(
                "{length} bytes from {start} on, of a file of {}",
                self.length
            )));
        }
        let mut bytes = vec![0; length];
        self.from(start).read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}

/// A reader with its own position. Reading at the end is an error, so that a decoder that skips values there stops.
pub(super) struct Ending {
    file: Arc<Mutex<File>>,
    at: u64,
}

impl Read for Ending {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(self.at))?;
        match file.read(into)? {
            0 if !into.is_empty() => Err(io::ErrorKind::UnexpectedEof.into()),
            read => {
                self.at += read as u64;
                Ok(read)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_readers_of_a_file_keep_their_positions() {
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, b"abcdef").unwrap();
        let bounded = Bounded::new(file).unwrap();
        let [mut first, mut second] = [0, 3].map(|start| bounded.from(start));
        let read = |reader: &mut Ending| {
            let mut byte = [0];
            reader.read_exact(&mut byte).map(|()| byte[0])
        };
        let bytes = [(); 3].map(|()| (read(&mut first).unwrap(), read(&mut second).unwrap()));
        assert_eq!(bytes, [(b'a', b'd'), (b'b', b'e'), (b'c', b'f')]);
        assert!(read(&mut second).is_err(), "the end of the file");
    }
}
