//! A deck, noise and the vertical tests' controller.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test file uses its own part"
)]

pub mod deck;
#[path = "../../../flight/tests/common/mod.rs"]
pub mod flight;
pub mod noise;
