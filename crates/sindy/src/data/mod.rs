//! Data: trajectories and samples, whole or as streams, and their gaps.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`dataset`] | trajectories of states and inputs, split at gaps, counted |
//! | [`samples`] | named columns in groups, handed on in blocks |
//! | [`stream`] | samples from an iterator of blocks, in one pass |
//! | [`gaps`] | where a trajectory is split |

pub mod dataset;
pub mod gaps;
pub(crate) mod grid;
pub mod samples;
pub mod stream;

pub use dataset::Dataset;
pub use samples::{Block, BlockSource, Samples};
pub use stream::{OwnedBlock, Stream};
