//! Simulated landings: many of them, their figures, and their recordings.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`sweep`] | campaigns: landings in space over grids and random draws of any setting, stored in blocks |
//! | [`vertical`] | vertical landings of the paper's methods |
//! | [`measured_deck`] | a measured motion of the deck, read, smoothed and checked |
//! | [`vehicle`] | rotors, mass and motors of the simulated vehicle, by `[vehicle]` and thrust card |
//! | [`recording`] | landings as MCAP and ULog files |
//! | [`scene`] | a landing as it can be watched |
//! | [`camera`] | rendered images and the tag detector, for landings that see |
//! | [`cards`] | the model cards that are flown, by their paths |
//! | [`statistics`] | means, shares and percentiles over landings |
//! | [`settings_file`] | settings as TOML files |
//! | [`policy`] | a learned policy, from its file |
//! | [`place`] | where a campaign's files are: a folder, or object storage |
//! | [`files`], [`csv`] | files that are written whole, lines of tables |
//! | [`progress`] | progress of long work |

pub mod camera;
pub mod cards;
pub mod csv;
pub mod error;
pub mod files;
pub mod measured_deck;
pub mod place;
pub mod policy;
pub mod progress;
pub mod recording;
pub mod scene;
pub mod settings_file;
pub mod statistics;
pub mod sweep;
pub mod vehicle;
pub mod vertical;

pub use error::{Error, Result};
pub use place::{ObjectStorage, Place};
