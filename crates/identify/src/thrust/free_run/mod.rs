//! Output error: lag, dead time and static curve of a thrust record, judged together by free run (simulation from initial
//! conditions).
//!
//! ```text
//! z(t) = Σ_k a_k L[b_k](t),    τ L' = b(t - d) - L,    T = z |z| or T = z
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`signal`] | a command between its samples; its exact lag with a dead time of any size |
//! | [`record`] | unbroken rows of trials |
//! | [`shape`] | the static curve and where the lag stands |
//! | [`solve`] | least squares over lag, dead time and curve |
//! | [`interval`] | errors from the profile of the likelihood, and what the data do not resolve |
//! | [`early`] | thrust that answers before its command |
//! | [`misfit`] | whether the answer to steps is that of one lag |
//! | [`judge`] | errors on parts of the data that are held out |

mod early;
mod interval;
mod judge;
mod misfit;
mod record;
mod shape;
pub(super) mod signal;
mod solve;

pub(super) use interval::{Certainty, Resolved};
pub(super) use judge::{FOLDS, HeldOut};
pub(super) use record::{CommandRecord, filled, has_one_rate, period_s};
pub(super) use shape::{Output, Shape, acting_voltage};
pub(super) use solve::{Free, Problem, Solution};
