//! The controller in space: against the vertical one, against closed forms, and
//! in closed loop.

#[path = "../common/mod.rs"]
mod common;
mod flights;
mod landings;
mod law;
mod plant;
