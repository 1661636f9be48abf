//! How far a model can be trusted: intervals, bands, inclusion, and what the data cannot identify.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`bootstrap`] | intervals of coefficients by a bootstrap over blocks of rows |
//! | [`ensemble`] | bagging of data and library, inclusion probabilities |
//! | [`horseshoe`] | sparse Bayesian regression by Markov chains |
//! | [`resample`] | draws with replacement, the same for any number of threads |
//! | [`identifiability`] | which terms the data identify, and which they confound |
//!
//! [`Band`] holds what the models of an ensemble predict; [`block_length`] chooses the blocks.

mod band;
mod block_length;
pub mod bootstrap;
pub mod ensemble;
pub mod horseshoe;
pub mod identifiability;
pub mod resample;
#[cfg(test)]
mod tests;

pub use band::Band;
pub use block_length::block_length;
pub use bootstrap::{Bootstrap, Intervals, Resampling, models, on_support};
pub use ensemble::Ensemble;
pub use horseshoe::Horseshoe;
