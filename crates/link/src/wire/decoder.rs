//! From bytes to messages.

use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message, calculate_crc};
use serde::Serialize;

use super::signing::Verifier;
use super::{CHECKSUM, Frame, SIGNATURE, SIGNED};

/// Bytes that a decoder keeps room for, so that it does not allocate: a frame has at most 280, a datagram 64 KiB.
const ROOM: usize = 1 << 17;

/// Counts of frames and of bytes that belong to none.
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
    /// Frames without a signature, with a wrong one, or signed at an older time than the one before: only on signed links.
    pub unsigned: u64,
    /// Bytes outside of any frame.
    pub stray_bytes: u64,
}

/// Splits bytes into frames, whatever pieces they arrive in.
#[derive(Clone, Debug)]
pub struct Decoder {
    buffer: Vec<u8>,
    start: usize,
    verifier: Option<Box<Verifier>>,
    /// Counts so far.
    pub counts: WireCounts,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new(None)
    }
}

/// A frame's place in the buffer.
struct Layout {
    version: MavlinkVersion,
    header: usize,
    payload: usize,
    whole: usize,
    id: u32,
    sequence: u8,
    system: u8,
    component: u8,
}

impl Decoder {
    /// A decoder. With a verifier, frames that are not signed by its key are skipped and counted.
    #[must_use]
    pub fn new(verifier: Option<Verifier>) -> Self {
        Self {
            buffer: Vec::with_capacity(ROOM),
            start: 0,
            verifier: verifier.map(Box::new),
            counts: WireCounts::default(),
        }
    }

    /// Adds bytes that have arrived.
    pub fn push(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.start);
        self.start = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// Drops the bytes that wait for the rest of their frame.
    pub fn forget(&mut self) {
        self.buffer.clear();
        self.start = 0;
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
            if let Some(verifier) = &mut self.verifier
                && !verifier.accepts(frame, end + CHECKSUM)
            {
                self.counts.unsigned += 1;
                self.start += layout.whole;
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
                        sequence: layout.sequence,
                        message,
                    });
                }
                Err(_) => self.counts.malformed += 1,
            }
        }
    }

    /// Bytes that wait for the rest of their frame.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.buffer.len() - self.start
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
        let (signature, [sequence, system, component], id) = match version {
            MavlinkVersion::V1 => (0, [bytes[2], bytes[3], bytes[4]], u32::from(bytes[5])),
            MavlinkVersion::V2 => {
                if bytes[2] & !SIGNED != 0 {
                    return Err(());
                }
                let signature = if bytes[2] == SIGNED { SIGNATURE } else { 0 };
                let id = u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]);
                (signature, [bytes[4], bytes[5], bytes[6]], id)
            }
        };
        let whole = header + payload + CHECKSUM + signature;
        Ok((bytes.len() >= whole).then_some(Self {
            version,
            header,
            payload,
            whole,
            id,
            sequence,
            system,
            component,
        }))
    }
}
