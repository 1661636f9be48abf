//! Control laws in space: the horizontal law, the allocation of a force to thrust and
//! attitude, the disturbance observer and the adaptation of the ground-effect model.

mod adaptation;
pub(crate) mod allocation;
pub(crate) mod cushion;
pub(crate) mod horizontal;
pub(crate) mod observer;

/// Slope of the trim from which on a vehicle leans into the wind: that of 6 m/s on the default airframe. Halved, gusts in
/// calm air count; doubled, 10 m/s does not.
pub(crate) const WINDY_SLOPE: f64 = 0.2;

pub use adaptation::{Adaptation, AdaptationState};
pub use horizontal::{Horizontal, HorizontalState};
pub use observer::{Delays, Observer};
