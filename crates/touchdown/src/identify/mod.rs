//! From trials to model cards.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`thrust`] | throttle to thrust: static maps, lags, eq. (7), eq. (8) |
//! | [`ground_effect`] | eq. (2), static map, eq. (9), ratio form, lag form |
//! | [`flight`] | thrust and ground effect from flight logs, without a force sensor |
//! | [`front`] | the best subset of every size, with its proof |
//! | [`settings`] | the settings of all of them |

mod choose;
pub mod flight;
pub mod front;
pub mod ground_effect;
pub(crate) mod making;
pub mod settings;
pub mod thrust;
mod unit;

pub use making::{Made, Origin, sha256};
pub use settings::IdentificationSettings;
