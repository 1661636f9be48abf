//! Parquet files: tables of any size, read by column and written whole.
//!
//! * [`read_parquet`] makes a [`Table`](crate::Table); it skips damaged row groups and counts them.
//! * [`ParquetFile`] reads single columns, also text, and rows block by block; damage is an error.
//! * [`to_parquet`] gives the bytes of a file.

mod bounded;
mod decode;
mod file;
#[cfg(any(target_family = "wasm", test))]
mod packed;
mod pages;
mod read;
mod rows;
mod sizes;
mod write;

use std::io::Read;
use std::path::Path;

pub use file::{ParquetColumn, ParquetFile};
pub(crate) use read::each_group;
pub use read::read_parquet;
pub use rows::{ParquetRows, ParquetValues};
pub use write::to_parquet;

/// How a file starts and ends.
const MAGIC: [u8; 4] = *b"PAR1";

/// Whether the first bytes are those of a Parquet file. A file that cannot be opened is not; its
/// reader reports the error.
pub(crate) fn is_parquet(path: &Path) -> bool {
    let mut start = [0; 4];
    let read = touchdown_files::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == MAGIC
}
