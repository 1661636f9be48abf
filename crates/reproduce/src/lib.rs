//! The paper's experiments on a virtual rig and a virtual vehicle, and landings at sea: what `touchdown reproduce` runs and
//! writes, for the command and for Python.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`settings`] | everything that a run depends on |
//! | [`experiments`] | the paper's four experiments, and landings at sea |
//! | [`pages`] | the reports of `reproduce` and `land` |
//! | [`folder`] | all files of a run |

pub mod error;
pub mod experiments;
pub mod folder;
pub mod pages;
pub mod settings;

pub use error::{Error, Result};
