//! Sparse solvers: from the statistics of one target to a fit with few terms.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`fit`] | what every sparse solver takes and returns |
//! | [`outcome`] | why a solver stopped, one type for all |
//! | [`sr3`] | SR3 with ℓ0, solved at its fixed point |
//! | [`relaxed`] | SR3 with ℓ1, weights, linear constraints; trimming |
//! | [`stlsq`] | sequentially thresholded least squares |
//! | [`stepwise`] | one term more or less at a time, by a criterion |
//! | [`exact`] | the best subset of every size, proven |
//! | [`sign`] | signs that coefficients must have |

pub mod exact;
pub mod fit;
pub mod outcome;
pub mod relaxed;
pub mod sign;
pub mod sr3;
pub mod stepwise;
pub mod stlsq;

pub use exact::BestSubset;
pub use fit::{Fit, Solver};
pub use outcome::Outcome;
pub use sign::Sign;
pub use sr3::Sr3;
pub use stepwise::Stepwise;
pub use stlsq::Stlsq;
