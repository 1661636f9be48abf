//! Text tables: a header, then rows of cells.

mod cell;
mod column;
mod layout;
mod parts;
mod preamble;
mod read;
mod write;

pub(crate) use parts::each_part;
pub(crate) use read::TablePart;
pub use read::{parse_csv, read_csv};
pub use write::{to_csv, write_csv};
