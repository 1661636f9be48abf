//! The tests in one program: what they share is compiled once.

mod common;
mod control;
mod ground_effect;
mod reference;
mod serde;
mod space;
mod thrust;
mod vertical_controller;
