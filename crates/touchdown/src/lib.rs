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

// Former paths, until all callers use the crates.
pub use settings::defaults;
pub use touchdown_campaign::vertical::vehicle;
pub use touchdown_campaign::{csv, files, progress, recording, statistics, sweep};
pub use touchdown_identify::{prediction as predict, scores as score};
/// Former path.
pub mod campaign {
    pub use touchdown_campaign::vertical::landings::*;
}
/// Former path.
pub mod identify {
    pub use touchdown_identify::{flights as flight, rig as ground_effect, *};
}
/// Former path.
pub mod scenario {
    pub use crate::settings::rig::*;
    pub use touchdown_campaign::cards::CardPaths;
    pub use touchdown_campaign::vertical::scenario::LandScenario;
}
/// Former path.
pub mod results {
    pub use crate::experiments::results::*;
}
