//! Thrust and ground effect from ordinary flight logs, without a force sensor.
//!
//! ```text
//! trial ──Flight──> one clock ──Phases──> armed intervals ──cut──> segments ──fit, selection, resampling──> model, intervals, refusals
//! ```
//!
//! The specific force of the accelerometer is thrust over mass. The throttle predicts it through the lag of the motors, a
//! scale and a height error of each armed interval, and the drift of thrust after the motors start. The residual near the
//! ground is the ground effect. No step needs the mass: everything is relative to hover out of ground effect.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `record`, `channels`, `smooth`, `motion` | one log with its channels on one clock |
//! | [`phases`], `marking`, `stand`, [`segments`] | motors on and off, contact, impacts; the segments of a log to fit, and why others were dropped |
//! | [`model`], [`curve`], [`fit`], [`coloured_noise`] | the model of a flight, the laws of its ground effect, its least squares, and correlated disturbances |
//! | [`trajectory`], `height_noise` | model, motion and noise together, by a Kalman filter's likelihood: the final numbers of a ground effect; else the bias by noise of heights |
//! | [`selection`], [`resampling`] | models judged on held-out flights; intervals by the bootstrap over flights |
//! | [`hover`] | logs without specific force: hovers at rest, and the thrust of each |
//! | [`routes`] | the ground effect by each sensor that gives a thrust, compared |
//! | [`judge`] | cards judged on flights that they have not seen |
//! | [`ground`], `coverage`, [`numbers`], [`armed_interval_result`], [`result`] | the whole identification: ground effect, each armed interval, refusals |

pub mod armed_interval;
pub mod armed_interval_result;
mod card;
mod channels;
pub mod coloured_noise;
mod coverage;
pub mod curve;
mod differences;
pub mod drift;
pub mod fit;
pub mod ground;
mod height_noise;
pub mod hover;
pub mod judge;
mod lag;
mod likeliest;
#[cfg(test)]
mod made;
mod marking;
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
pub mod routes;
pub mod segments;
pub mod selection;
mod shape;
mod smooth;
mod stand;
mod thrust;
pub mod trajectory;

pub use crate::refusal::{NoForce, Refusal};
pub use crate::settings::FlightSettings;
pub use ground::{Basis, GroundEffect, ground_effect, ground_effect_with};
pub use record::{Flight, ForceFrom};
pub use routes::{Route, Routed, ground_effect_by_routes};
pub use thrust::{thrust_alone, thrust_of_flights, with_thrust};
