//! Readers of logs with topics, behind one interface.
//!
//! A reader walks a file once, in the order of its bytes, and tells a [`sink::Sink`] what it
//! finds: topics, messages, parameters, and at the end what was lost. Two sinks serve all formats:
//! the [`survey`] of what there is, and the [`extract`]ion of the columns that a map names, which
//! are then [`join`]ed to one clock.

mod bag;
mod bounded;
mod built_in;
mod channel;
mod clocks;
mod cursor;
mod dataflash;
mod extract;
mod fields;
mod hashing;
mod join;
mod joined;
mod log;
mod lost;
mod mcap;
mod pages;
mod parquet;
mod resets;
mod ros;
mod sink;
mod steps;
mod stream;
mod survey;
mod trial;
mod ulog;

pub(crate) use self::parquet::inspect_parquet;
pub use self::parquet::read_parquet;
pub use log::{Log, LogFormat};
pub use survey::{Field, Survey, Topic};
pub use ulog::{UlogTopic, UlogWriter};

pub(crate) use self::parquet::MAGIC as PARQUET;
