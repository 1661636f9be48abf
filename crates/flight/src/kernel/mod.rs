//! Small numerical kernels shared by the models.

mod cubic;
mod linear;
mod sum;

pub(crate) use cubic::first_rise;
pub(crate) use linear::{lag_step, linear_rest, linear_step, usable_dt};
pub(crate) use sum::Sum;
