//! The air: ground effect of rotors over a deck, turbulence, wind.

pub mod airwake;
pub mod exponential;
pub mod ground;
pub(crate) mod height_table;
pub mod turbulence;
pub mod wind;
