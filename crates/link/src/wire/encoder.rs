//! From messages to bytes.

use mavlink::dialects::common::MavMessage;
use mavlink::{MAVLinkV2MessageRaw, MavHeader, Message, calculate_crc};

use super::signing::Signer;
use super::{CHECKSUM, SIGNED};

/// Place of the incompatibility flags in a frame.
const FLAGS: usize = 2;

/// Writes messages as frames of MAVLink 2.
#[derive(Clone, Debug)]
pub struct Encoder {
    /// System id of the sender.
    pub system: u8,
    /// Component id of the sender.
    pub component: u8,
    sequence: u8,
    signer: Option<Box<Signer>>,
}

impl Encoder {
    /// A sender that signs nothing.
    #[must_use]
    pub fn new(system: u8, component: u8) -> Self {
        Self {
            system,
            component,
            sequence: 0,
            signer: None,
        }
    }

    /// The same sender, which signs every frame.
    #[must_use]
    pub fn signed(self, signer: Option<Signer>) -> Self {
        Self {
            signer: signer.map(Box::new),
            ..self
        }
    }

    /// Appends the frame of a message.
    pub fn write(&mut self, message: &MavMessage, out: &mut Vec<u8>) {
        self.write_at(message, 0, out);
    }

    /// Appends the frame of a message that is sent at `now_us`, our time; only signatures hold it.
    pub fn write_at(&mut self, message: &MavMessage, now_us: i64, out: &mut Vec<u8>) {
        let header = MavHeader {
            system_id: u32::from(self.system),
            component_id: self.component,
            sequence: self.sequence,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message(header, message);
        let begin = out.len();
        out.extend_from_slice(raw.raw_bytes());
        if let Some(signer) = &mut self.signer {
            // The checksum covers the flag.
            out[begin + FLAGS] |= SIGNED;
            let end = out.len() - CHECKSUM;
            let extra = MavMessage::extra_crc(message.message_id());
            let checksum = calculate_crc(&out[begin + 1..end], extra);
            out[end..].copy_from_slice(&checksum.to_le_bytes());
            signer.append(begin, now_us, out);
        }
    }
}
