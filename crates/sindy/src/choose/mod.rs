//! Choosing one fit of many: settings by cross-validation, members of a family by a rule.
//!
//! [`cross_validate`] chooses λ and ν of SR3 over groups of rows; [`select`] chooses one fit of any family, by its
//! held-out error or a criterion.

mod cross_validation;
pub mod select;

pub use cross_validation::{Choice, Grid, Point, cross_validate, cross_validate_scaled};
