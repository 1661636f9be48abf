//! Small numerical kernels shared by the models.

mod cubic;
mod delay;
mod linear;
mod sum;

pub(crate) use cubic::first_rise;
pub(crate) use delay::Delay;
pub(crate) use linear::{lag_share, lag_step, linear_rest, linear_step, usable_dt};
pub(crate) use sum::Sum;
