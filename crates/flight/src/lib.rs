//! Thrust and ground-effect models, references, estimators and controllers
//! for the vertical landing of a multirotor, for a flight computer.
#![no_std]
#![forbid(unsafe_code)]

pub mod error;
pub mod real;
pub mod types;

pub use error::SettingsError;
pub use real::Real;
pub use types::{Command, Limits, Measurement};
