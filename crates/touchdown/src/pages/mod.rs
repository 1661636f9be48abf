//! Reports: figures and one self-contained HTML file for every command.

pub mod campaign;
mod colors;
mod front;
mod glossary;
pub mod identify;
pub mod inspect;
pub mod land;
mod landings;
mod page;
pub mod reproduce;
mod track;
pub mod validate;
mod watch;

pub use campaign::campaign;
pub use land::land;
pub use reproduce::reproduce;
