//! The model card: one fitted or published model, in one TOML file.
//!
//! A card says what is modelled and in which form, the terms with their coefficients, standard errors
//! and units, where the model is valid and what happens outside, for which vehicle, how well it did on
//! training and on unseen trials, and what made it (tool, settings, seed, SHA-256 of every input). It is
//! what identification writes, what validation and flight read, and what is exported.
//!
//! ```
//! use touchdown_model::{Card, published};
//!
//! let card = Card::parse(published::EQ_11, "paper-eq11.toml")?;
//! let thrust = card.thrust_model()?;
//! let hover = thrust.throttle_for(1.37 * 9.81);
//! assert!((hover - 0.4869).abs() < 1e-4);
//! # Ok::<(), touchdown_model::CardError>(())
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`card`] | the schema |
//! | [`catalogue`] | the forms: equation, parts, state, rate, output, flight kernel |
//! | [`equations`] | a card as expressions, for prediction |
//! | [`export`] | a card as source code, C or Rust |
//! | [`file`](mod@file) | reading and writing, with errors that name file, line and key |
//! | [`flight`] | card to flight model |
//! | [`published`] | the published models that ship with the toolkit |
//! | [`unit`](mod@unit) | units of coefficients |

pub mod card;
pub mod catalogue;
pub mod equations;
mod error;
pub mod export;
pub mod file;
pub mod flight;
pub mod published;
pub mod unit;

pub use card::{Card, Form, Kind, Mark, Status, Term};
pub use error::CardError;
