//! Thrust and ground effect from ordinary flight logs, without a force sensor.
//!
//! ```text
//! trial ──Flight──> one clock ──Phases──> runs in flight ──cut──> pieces ──fit, choose, spread──> model, intervals, refusals
//! ```
//!
//! The specific force of the accelerometer is thrust over mass. Throttle predicts it through the motors' lag, a scale and
//! an error of height of each run, and the drift of thrust after the motors start; what is left near the ground is the
//! ground effect. Nothing needs the mass: all is relative to hover out of ground effect.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`phases`], `stand`, [`pieces`] | motors on and off, contact, impacts; what is left of a log to fit, and what was left out and why |
//! | [`model`], [`curve`], [`fit`], [`colour`] | the model of a flight, the laws of its ground effect, its least squares, and disturbances that last |
//! | [`choose`], [`spread`] | models judged on flights left out; intervals from flights drawn anew |
//! | [`hover`] | logs without specific force: hovers at rest, and the thrust that each takes |
//! | [`ground`], [`numbers`], [`runs`], [`result`] | all of it: the ground effect, each run of the motors, and what the logs do not carry |

mod armed_interval;
pub mod armed_intervals;
mod card;
pub mod coloured_noise;
pub mod curve;
pub mod drift;
pub mod fit;
pub mod ground;
pub mod hover;
mod lag;
pub mod model;
mod motion;
mod normal;
pub mod numbers;
pub mod phases;
pub mod profile;
mod record;
pub mod resampling;
mod resolve;
mod rest;
pub mod result;
pub mod segments;
pub mod selection;
mod shape;
mod smooth;
mod stand;
mod thrust;

pub use crate::settings::FlightSettings;
pub use ground::{Basis, GroundEffect, Refusal, ground_effect, ground_effect_with};
pub use record::{Flight, ForceFrom};
pub use thrust::{thrust_alone, with_thrust};
