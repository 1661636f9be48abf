//! Small numerical kernels shared by the models.

mod cubic;
mod delay;
mod linear;
mod sum;

pub use cubic::first_rise;
pub use delay::Delay;
pub use linear::{lag_by, lag_share, lag_step, linear_rest, linear_step, usable_dt};
pub use sum::Sum;
