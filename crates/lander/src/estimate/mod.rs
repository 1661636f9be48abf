//! Estimators of a landing.
//!
//! | module | what it estimates | from |
//! | --- | --- | --- |
//! | [`relative`] | place and velocity of the vehicle relative to the deck, the deck's vertical motion, accelerometer biases | IMU, range finder, tag, GNSS, barometer, each with its delay |
//! | [`latency`] | how much later readings come than their ages say | the swing of the vehicle, as IMU and tag tell it |
//! | [`deck`] | the deck's heave as harmonics of unknown frequency, and its future | displacement or velocity of the deck |
//!
//! An estimate is a mean with standard deviations. How far it can be trusted is
//! said apart from it, by [`relative::Health`].

pub mod deck;
mod gaussian;
pub mod latency;
pub mod relative;
