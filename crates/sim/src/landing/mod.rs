//! Landings: of the vertical vehicle, and in six degrees of freedom.

pub mod space;
pub mod vertical;
