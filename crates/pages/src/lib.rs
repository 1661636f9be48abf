//! What the reports of Touchdown show: figures, tables and words, for the command line, the landing lab and Python alike.
//!
//! | module | report |
//! | --- | --- |
//! | [`identify`] | thrust and ground-effect models from logs |
//! | [`validate`] | models on logs that they have not seen |
//! | [`inspect`] | what is in a log |
//! | [`campaign()`] | landings over swept and random settings |
//!
//! | module | what all of them share |
//! | --- | --- |
//! | [`page`] | a report in the making, and marks of numbers |
//! | [`logs`] | logs and commands in words |
//! | [`colors`] | the same thing has the same colour everywhere |
//! | [`front`] | the error over the number of terms |
//! | [`track`] | a landing over time |
//! | [`watch`] | a landing to watch |

mod campaign;
pub mod colors;
mod error;
pub mod front;
mod glossary;
pub mod identify;
pub mod inspect;
pub mod logs;
pub mod page;
pub mod track;
pub mod validate;
pub mod watch;

pub use campaign::campaign;
pub use error::{Error, Result};
