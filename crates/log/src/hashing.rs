//! SHA-256 of a file, computed while a reader uses its bytes.

use sha2::{Digest, Sha256};
use std::io::{self, Read};

/// Bytes that are read at once if no reader needs them. The value affects only speed.
const BLOCK: usize = 1 << 18;

/// A reader that passes bytes on and hashes them on request.
pub(crate) struct Hashing<R> {
    input: R,
    hash: Option<Sha256>,
}

impl<R: Read> Hashing<R> {
    pub(crate) fn new(input: R, wanted: bool) -> Self {
        let hash = wanted.then(Sha256::new);
        Self { input, hash }
    }

    /// Reads the remaining bytes. Returns the hash in lower-case hexadecimal, or an empty text
    /// if none was requested.
    pub(crate) fn finish(mut self) -> io::Result<String> {
        if self.hash.is_some() {
            let mut block = vec![0; BLOCK];
            loop {
                match self.read(&mut block) {
                    Ok(0) => break,
                    Ok(_) => {}
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        let digest = self.hash.map(Sha256::finalize);
        Ok(digest.map_or_else(String::new, |digest| hex(&digest)))
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(into)?;
        if let Some(hash) = &mut self.hash {
            hash.update(&into[..read]);
        }
        Ok(read)
    }
}

/// SHA-256 of a whole input.
#[cfg(feature = "parquet")]
pub(crate) fn sha256_of(input: impl Read) -> io::Result<String> {
    Hashing::new(input, true).finish()
}

/// SHA-256 in lower-case hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
