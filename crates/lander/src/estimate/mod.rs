//! Estimators that a landing needs.
//!
//! | module | what it estimates | from |
//! | --- | --- | --- |
//! | [`relative`] | position and velocity of the vehicle relative to the deck, the deck's vertical motion, accelerometer biases | IMU, range finder, tag, GNSS, barometer, each with its latency |
//! | [`latency`] | the unknown latency of the camera | the vehicle's oscillation, as IMU and tag measure it |
//! | [`deck`] | the deck's heave as harmonics of unknown frequency, and its prediction | displacement or velocity of the deck |
//!
//! An estimate is a mean with standard deviations. [`relative::Health`] reports
//! separately whether the estimate can be trusted.

pub mod deck;
mod gaussian;
pub mod latency;
pub mod relative;
