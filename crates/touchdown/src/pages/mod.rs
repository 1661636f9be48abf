//! Reports: figures and one self-contained HTML file for every command.

pub mod identify;
pub mod inspect;
pub mod land;
pub mod reproduce;
pub mod validate;
