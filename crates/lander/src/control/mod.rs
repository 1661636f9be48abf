//! Control laws in space: the horizontal law, the allocation of a force to thrust and
//! attitude, the disturbance observer and the adaptation of the ground-effect model.

mod adaptation;
pub(crate) mod allocation;
pub(crate) mod horizontal;
pub(crate) mod observer;

pub use adaptation::{Adaptation, AdaptationState};
pub use horizontal::{Horizontal, HorizontalState};
pub use observer::{Delays, Observer};
