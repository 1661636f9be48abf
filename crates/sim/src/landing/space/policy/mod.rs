//! Learned policies: networks from an observation to an action, as `touchdown.gym` trains them.
//!
//! ```text
//! place, velocities, attitude, rates, deck's normal ─> scale, limit ─> layers ─> action in [-1, 1] ─> thrust, and attitude or rates
//! ```
//!
//! In an environment for learning the observation is the true state. In a landing with sensors
//! ([`SpaceLander::with_policy`](super::SpaceLander::with_policy)) it is what the landing computer estimates. The policy
//! then flies the descents; everything else remains the computer's: approach, hover, the decision to descend, go-arounds,
//! touchdown and disarming.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `action` | from an action to a command |
//! | `network` | the settings of a policy, and its action for an observation |
//! | `observation` | the numbers of an observation, in their order |
//! | `pilot` | a policy in the place of the landing computer's controller |

mod action;
mod network;
mod observation;
mod pilot;

pub use action::{ActionKind, ActionSettings, CommandKind};
pub use network::{Activation, InputSettings, LayerSettings, Policy, PolicySettings};
pub use observation::Observation;
pub(super) use pilot::Pilot;
