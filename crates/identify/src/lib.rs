//! From trials to model cards.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`thrust`] | throttle to thrust from stands: static maps, lags, eq. (7), eq. (8) |
//! | [`rig`] | ground effect from force rigs: eq. (2), static map, eq. (9), ratio form, lag form |
//! | [`flights`] | thrust and ground effect from flight logs, without a force sensor |
//! | [`forms`] | the forms that a fit was chosen from |
//! | [`front`] | the best subset of every size, with its proof |
//! | [`prediction`] | free-run prediction from a card |
//! | [`scores`] | errors of a prediction |
//! | [`validation`] | a card on a trial that it has not seen: free run, errors, validity |
//! | [`refusal`] | what flights do not identify, and what to record |
//! | [`warning`] | what a user should know of a fit |
//! | [`settings`] | the settings of all of them |

mod delayed;
pub mod error;
pub mod estimate;
pub mod fitted;
pub mod flights;
pub mod forms;
pub mod front;
mod held;
mod map_line;
pub mod prediction;
pub mod refusal;
pub mod rig;
pub mod scores;
pub mod settings;
mod sparse_fit;
pub mod thrust;
mod thrust_scale;
pub mod validation;
pub mod warning;

pub use error::{Error, Result, VehicleNumber};
pub use estimate::Estimate;
pub use fitted::{FittedCard, Origin};
pub use settings::IdentificationSettings;
