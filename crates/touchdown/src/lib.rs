//! From a thrust log to a soft touchdown on a moving deck: the experiments, the settings and the reports of the command
//! `touchdown`.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`experiments`] | the paper's four experiments, and landings at sea |
//! | [`settings`] | settings of whole runs, scenario files, and their defaults |
//! | [`pages`] | reports: figures and HTML |
//!
//! What can be used without a command line stands in crates of its own: `touchdown-identify` and `touchdown-campaign`.

pub mod error;
pub mod experiments;
pub mod pages;
pub mod settings;

pub use error::{Error, Result};
