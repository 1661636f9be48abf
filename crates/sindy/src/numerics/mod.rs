//! Small numerical methods that several stages need.

mod bfgs;
mod cubic;
mod golden_section;
mod prime;
mod quantile;

pub(crate) use bfgs::bfgs;
pub(crate) use cubic::{hermite, spline_slopes};
pub use golden_section::golden_section;
pub(crate) use golden_section::minimum_on_grid;
pub(crate) use prime::prime;
pub use quantile::quantile;
pub(crate) use quantile::{nearest_quantile, upper_median};
