//! The settings of the command `touchdown`, and the error that knows its exit status.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`settings`] | scenario files of the virtual rig, and the defaults that `touchdown settings` prints |
//! | [`error`] | anything that stops the command |
//!
//! What can be used without a command line stands in crates of its own: `touchdown-identify`, `touchdown-campaign` and
//! `touchdown-reproduce`.

pub mod error;
pub mod settings;

pub use error::{Error, Result};
