//! What needs a trajectory in its order of time: delays, past states, and fits that follow it.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`delay`] | the delay between two channels |
//! | [`shift`] | past states as columns, and the next sample for discrete time |
//! | [`shooting`] | refinement by multiple shooting |
//! | [`output_error`] | terms judged by trajectories instead of slopes |

pub mod delay;
pub mod output_error;
pub mod shift;
pub mod shooting;

pub use shooting::OdeModel;
