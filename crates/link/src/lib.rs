//! The landing computer beside an autopilot: PX4 or ArduPilot, over MAVLink.
//!
//! | module | content |
//! | --- | --- |
//! | [`settings`] | settings of a flight, as they stand in `FLIGHT.toml` |
//! | [`companion`] | the control state machine: bytes and clock ticks in, bytes out |
//! | [`camera`] | the camera of a companion: frames to the position of the deck |
//! | [`checklist`] | the checklist before control |
//! | [`replay`] | a recorded flight, run again and compared bit for bit |
//! | [`recording`] | the MCAP file of a flight |
//! | [`simulator`] | the simulator's side of an autopilot |
//! | [`transport`] | serial, UDP and TCP |
//! | [`axes`], [`thrust_curve`], [`clock`], [`readings`], [`wire`] | conversions of axes, thrust, time, readings and frames |
//!
//! The companion reads no clock and opens no socket. Its caller gives it every chunk of bytes with its arrival time, and
//! a tick a hundred times a second. So a recorded flight runs the same code as the flight itself.
#![forbid(unsafe_code)]

pub mod address;
mod autopilot;
pub mod axes;
pub mod camera;
pub mod checklist;
pub mod clock;
pub mod companion;
mod decoded;
mod error;
mod parameters;
pub mod readings;
pub mod recording;
pub mod replay;
pub mod settings;
pub mod simulator;
pub mod thrust_curve;
pub mod timing;
pub mod transport;
pub mod wire;

pub use autopilot::{Autopilot, Firmware};
pub use error::LinkError;
pub use parameters::Change;
