//! Landings: of the vertical vehicle, and in six degrees of freedom.

mod measured_deck;
pub mod space;
pub mod vertical;
