//! Landings as logs: MCAP for Foxglove and PlotJuggler, ULog as PX4 writes it.
//!
//! Both contain the truth, and the readings of the sensors as an autopilot would have logged them: `touchdown inspect` and
//! `touchdown identify` read them as they do any flight's, and what they find can be held against the truth.

mod mcap;
mod ulog;

pub use mcap::mcap;
pub use ulog::ulog;
