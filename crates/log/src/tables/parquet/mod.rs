//! Parquet files.

mod bounded;
mod pages;
mod read;

pub use read::read_parquet;
pub(crate) use read::{each_group, is_parquet};
