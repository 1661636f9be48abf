//! MAVLink frames: from bytes to messages and back, signed or not.

mod decoder;
mod encoder;
pub mod signing;
#[cfg(test)]
mod tests;

pub use decoder::{Decoder, WireCounts};
pub use encoder::Encoder;

use mavlink::dialects::common::MavMessage;

/// Flag of a signed frame; no other flag is understood.
const SIGNED: u8 = 1;
/// Bytes of a signature: link id, time, and the first six bytes of a hash.
const SIGNATURE: usize = 13;
const CHECKSUM: usize = 2;

/// A message and its sender.
#[derive(Clone, Debug)]
pub struct Frame {
    /// System id of the sender.
    pub system: u8,
    /// Component id of the sender.
    pub component: u8,
    /// Number of the frame, which the sender counts modulo 256.
    pub sequence: u8,
    /// The message.
    pub message: MavMessage,
}
