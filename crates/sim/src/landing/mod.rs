//! Landings: of the vertical vehicle, and in six degrees of freedom.

mod measured_deck;
mod refused;
pub mod space;
pub mod vertical;

pub use refused::refused_setting;
