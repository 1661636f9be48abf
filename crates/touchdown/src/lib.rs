//! From a thrust log to a soft touchdown on a moving deck.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`identify`] | trials to model cards |
//! | [`predict`] | free-run prediction from a card |
//! | [`pilot`] | cards to controllers, by the methods' names |
//! | [`campaign`] | many landings of one controller |
//! | [`experiments`] | the paper's four experiments, and landings at sea |
//! | [`results`] | what `reproduce` writes as `results.json` |
//! | [`settings`], [`scenario`] | settings of whole runs, and scenario files |
//! | [`pages`] | reports: figures and HTML |
//! | [`sweep`] | campaigns: landings in space over grids and draws of any setting |
//! | [`recording`] | landings as MCAP and ULog files |
//! | [`eye`] | rendered images and the detector in them, for landings |
//! | [`files`] | files, written whole or not at all |
//! | [`vehicle`] | the vehicle of model cards as the simulated one |
//! | [`score`], [`statistics`] | errors, and figures over trials |

pub mod campaign;
pub mod csv;
pub mod defaults;
pub mod error;
pub mod experiments;
pub mod eye;
pub mod files;
pub mod identify;
pub mod pages;
pub mod pilot;
pub mod predict;
pub mod progress;
pub mod recording;
pub mod results;
pub mod scenario;
pub mod score;
pub mod settings;
pub mod statistics;
pub mod sweep;
pub mod vehicle;

pub use error::{Error, Result};
