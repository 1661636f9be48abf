//! Vertical landings, as the paper has them: one axis, one controller by the name of its method.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`settings`] | the landing and its controllers |
//! | [`controllers`] | controllers of the methods by name, with the models of cards |
//! | [`scenario`] | the scenario file |
//! | [`vehicle`] | the vehicle of model cards as the simulated one |
//! | [`landings`] | repeated landings of one controller, and their figures |

pub mod controllers;
pub mod landings;
pub mod scenario;
pub mod settings;
pub mod vehicle;
