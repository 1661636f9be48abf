//! From a thrust log to a soft touchdown on a moving deck.

pub mod error;
pub mod identify;
pub mod predict;
pub mod score;

pub use error::{Error, Result};
