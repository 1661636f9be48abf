//! The relative estimator against truth.

#[path = "../common/mod.rs"]
mod common;

mod accuracy;
mod delays;
mod promises;
mod sensors;
mod truth;
