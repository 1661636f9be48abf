//! MAVLink frames: from bytes to messages and back.

use mavlink::dialects::common::MavMessage;
use mavlink::{
    MAV_STX, MAV_STX_V2, MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message, calculate_crc,
};
use serde::Serialize;

/// Flag of a signed frame; no other flag is understood.
const SIGNED: u8 = 1;
const SIGNATURE: usize = 13;
const CHECKSUM: usize = 2;

/// A message and who sent it.
#[derive(Clone, Debug)]
pub struct Frame {
    /// System id of the sender.
    pub system: u8,
    /// Component id of the sender.
    pub component: u8,
    /// The message.
    pub message: MavMessage,
}

/// What was found among the bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WireCounts {
    /// Frames that became messages.
    pub messages: u64,
    /// Frames of a message that the dialect does not have.
    pub unknown: u64,
    /// Frames with a wrong checksum, or with flags that are not understood.
    pub corrupt: u64,
    /// Frames with a right checksum whose content makes no sense, such as an unknown value of an enumeration.
    pub malformed: u64,
    /// Bytes outside of any frame.
    pub stray_bytes: u64,
}

/// Splits bytes into frames, whatever pieces they arrive in.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    buffer: Vec<u8>,
    start: usize,
    /// What was found so far.
    pub counts: WireCounts,
}

/// A frame's place in the buffer.
struct Layout {
    version: MavlinkVersion,
    header: usize,
    payload: usize,
    whole: usize,
    id: u32,
    system: u8,
    component: u8,
}

impl Decoder {
    /// Adds bytes that have arrived.
    pub fn push(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.start);
        self.start = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// The next message, if a whole one is there.
    pub fn next_frame(&mut self) -> Option<Frame> {
        loop {
            self.seek_marker()?;
            let candidate = &self.buffer[self.start..];
            let layout = match Layout::of(candidate) {
                Ok(Some(layout)) => layout,
                // The rest has not arrived.
                Ok(None) => return None,
                Err(()) => {
                    self.reject();
                    continue;
                }
            };
            let frame = &candidate[..layout.whole];
            let extra = MavMessage::extra_crc(layout.id);
            if extra == 0 && MavMessage::default_message_from_id(layout.id).is_none() {
                // Its checksum cannot be checked. A true frame ends where another begins.
                let followed = candidate.get(layout.whole);
                if followed.is_none_or(|byte| [MAV_STX, MAV_STX_V2].contains(byte)) {
                    self.counts.unknown += 1;
                    self.start += layout.whole;
                } else {
                    self.reject();
                }
                continue;
            }
            let end = layout.header + layout.payload;
            let expected = u16::from_le_bytes([frame[end], frame[end + 1]]);
            if calculate_crc(&frame[1..end], extra) != expected {
                self.reject();
                continue;
            }
            let parsed = MavMessage::parse(layout.version, layout.id, &frame[layout.header..end]);
            self.start += layout.whole;
            match parsed {
                Ok(message) => {
                    self.counts.messages += 1;
                    return Some(Frame {
                        system: layout.system,
                        component: layout.component,
                        message,
                    });
                }
                Err(_) => self.counts.malformed += 1,
            }
        }
    }

    fn seek_marker(&mut self) -> Option<()> {
        let rest = &self.buffer[self.start..];
        let marker = rest
            .iter()
            .position(|byte| [MAV_STX, MAV_STX_V2].contains(byte));
        let stray = marker.unwrap_or(rest.len());
        self.counts.stray_bytes += stray as u64;
        self.start += stray;
        marker.map(|_| ())
    }

    /// A marker that begins no frame: the search goes on at the next byte.
    fn reject(&mut self) {
        self.counts.corrupt += 1;
        self.start += 1;
    }
}

impl Layout {
    /// The layout of the frame that begins here; none if its end has not arrived.
    fn of(bytes: &[u8]) -> Result<Option<Self>, ()> {
        let version = match bytes[0] {
            MAV_STX => MavlinkVersion::V1,
            _ => MavlinkVersion::V2,
        };
        let header = match version {
            MavlinkVersion::V1 => 6,
            MavlinkVersion::V2 => 10,
        };
        if bytes.len() < header {
            return Ok(None);
        }
        let payload = usize::from(bytes[1]);
        let (signature, system, component, id) = match version {
            MavlinkVersion::V1 => (0, bytes[3], bytes[4], u32::from(bytes[5])),
            MavlinkVersion::V2 => {
                if bytes[2] & !SIGNED != 0 {
                    return Err(());
                }
                let signature = if bytes[2] == SIGNED { SIGNATURE } else { 0 };
                let id = u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]);
                (signature, bytes[5], bytes[6], id)
            }
        };
        let whole = header + payload + CHECKSUM + signature;
        Ok((bytes.len() >= whole).then_some(Self {
            version,
            header,
            payload,
            whole,
            id,
            system,
            component,
        }))
    }
}

/// Writes messages as frames of MAVLink 2.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    /// System id of the sender.
    pub system: u8,
    /// Component id of the sender.
    pub component: u8,
    sequence: u8,
}

impl Encoder {
    /// A sender.
    #[must_use]
    pub fn new(system: u8, component: u8) -> Self {
        Self {
            system,
            component,
            sequence: 0,
        }
    }

    /// Appends the frame of a message.
    pub fn write(&mut self, message: &MavMessage, out: &mut Vec<u8>) {
        let header = MavHeader {
            system_id: u32::from(self.system),
            component_id: self.component,
            sequence: self.sequence,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message(header, message);
        out.extend_from_slice(raw.raw_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, HEARTBEAT_DATA};
    use proptest::prelude::*;

    fn two() -> Vec<u8> {
        let mut encoder = Encoder::new(7, 1);
        let mut bytes = Vec::new();
        let heartbeat = HEARTBEAT_DATA {
            custom_mode: 0x0006_0000,
            ..HEARTBEAT_DATA::default()
        };
        encoder.write(&MavMessage::HEARTBEAT(heartbeat), &mut bytes);
        let attitude = ATTITUDE_QUATERNION_DATA {
            time_boot_ms: 1,
            q1: 1.0,
            ..ATTITUDE_QUATERNION_DATA::default()
        };
        encoder.write(&MavMessage::ATTITUDE_QUATERNION(attitude), &mut bytes);
        bytes
    }

    fn all(decoder: &mut Decoder) -> Vec<u32> {
        std::iter::from_fn(|| decoder.next_frame())
            .map(|frame| frame.message.message_id())
            .collect()
    }

    #[test]
    fn prop_frames_come_back_in_any_pieces() {
        let bytes = two();
        for piece in 1..bytes.len() {
            let mut decoder = Decoder::default();
            let mut ids = Vec::new();
            for chunk in bytes.chunks(piece) {
                decoder.push(chunk);
                ids.extend(all(&mut decoder));
            }
            assert_eq!(ids, [0, 31], "pieces of {piece}");
            assert_eq!(decoder.counts.corrupt, 0);
        }
    }

    #[test]
    fn prop_a_flipped_bit_never_becomes_a_message() {
        let bytes = two();
        for bit in 0..bytes.len() * 8 {
            let mut wrong = bytes.clone();
            wrong[bit / 8] ^= 1 << (bit % 8);
            let mut decoder = Decoder::default();
            decoder.push(&wrong);
            // One of the two is hurt; a frame that seems longer may wait for more.
            assert!(all(&mut decoder).len() <= 1, "bit {bit}");
        }
    }

    #[test]
    fn prop_unknown_messages_are_skipped_and_counted() {
        let bytes = two();
        let mut unknown = vec![
            MAV_STX_V2, 3, 0, 0, 0, 1, 1, 0xb8, 0x01, 0x7f, 1, 2, 3, 9, 9,
        ];
        unknown.extend_from_slice(&bytes);
        let mut decoder = Decoder::default();
        decoder.push(&unknown);
        assert_eq!(all(&mut decoder), [0, 31]);
        assert_eq!(decoder.counts.unknown, 1);
    }

    proptest! {
        #[test]
        fn prop_any_bytes_are_read_without_panic(chunks in proptest::collection::vec(
            proptest::collection::vec(prop_oneof![Just(MAV_STX), Just(MAV_STX_V2), any::<u8>()], 0..300), 0..6)) {
            let mut decoder = Decoder::default();
            for chunk in &chunks {
                decoder.push(chunk);
                let _ = all(&mut decoder);
            }
            // A frame has at most 280 bytes: more never waits.
            prop_assert!(decoder.buffer.len() - decoder.start < 280);
        }
    }
}
