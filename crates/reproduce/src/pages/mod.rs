//! Reports of `land` and `reproduce`; those of other commands stand in `touchdown-pages`.

pub mod land;
mod landings;
pub mod reproduce;

pub use land::land;
pub use reproduce::reproduce;
