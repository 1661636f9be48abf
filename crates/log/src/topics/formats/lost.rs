//! Messages lost in damaged chunks of an MCAP recording, as far as their heads and the indexes after
//! them state it.

use super::clocks::Clocks;
use super::cursor::Cursor;
use crate::topics::sink::Loss;

/// Largest number of damaged chunks that are reported one by one.
const MOST: usize = 16;
/// The longest credible time span of a chunk, in ns: a day. A longer one is part of the damage.
const LONGEST_NS: u64 = 86_400_000_000_000;
/// Bytes of an index for each message.
const ENTRY: usize = 16;

#[derive(Default)]
pub(super) struct LostChunks {
    chunks: Vec<Chunk>,
    /// Whether the following indexes belong to the last of them.
    is_open: bool,
}

struct Chunk {
    bytes: usize,
    /// The recorder's time of its first message and of its last, in ns.
    span_ns: Option<(u64, u64)>,
    /// Number of messages that were read from it.
    found: usize,
    /// Number of messages that its indexes list.
    told: usize,
}

impl LostChunks {
    /// Adds a chunk of this length and body, from which some messages were read.
    pub(super) fn push(&mut self, bytes: usize, body: &[u8], found: usize) {
        self.is_open = self.chunks.len() < MOST;
        if self.is_open {
            self.chunks.push(Chunk {
                bytes,
                span_ns: span(&mut Cursor::new(body)),
                found,
                told: 0,
            });
        }
    }

    /// The indexes of the last chunk have ended.
    pub(super) fn close(&mut self) {
        self.is_open = false;
    }

    /// Adds an index of the messages of a channel. Damage of the index itself is not a loss.
    pub(super) fn index(&mut self, cursor: &mut Cursor<'_>) {
        let entries = cursor.take(2).and_then(|_| cursor.sized());
        if let (Some(chunk), Some(entries)) = (self.chunks.last_mut(), entries)
            && self.is_open
        {
            chunk.told += entries.len() / ENTRY;
        }
    }

    /// One sentence for each damaged chunk.
    pub(super) fn tell(&self, clocks: &mut Clocks, loss: &mut Loss) {
        for chunk in &self.chunks {
            let count = match chunk.told.saturating_sub(chunk.found) {
                0 => "an unknown number of messages".to_owned(),
                1 => "1 message".to_owned(),
                lost => format!("{lost} messages"),
            };
            let span = chunk.span_ns.map_or_else(String::new, |(first, last)| {
                let [from_s, to_s] = [first, last].map(|ns| clocks.recorded(ns) as f64 * 1e-9);
                format!(" of {from_s:.3} s to {to_s:.3} s")
            });
            loss.note(format!(
                "a damaged chunk of {} bytes was skipped, with {count}{span}",
                chunk.bytes
            ));
        }
    }
}

/// The times in a chunk's head, if they are plausible.
fn span(cursor: &mut Cursor<'_>) -> Option<(u64, u64)> {
    let (first, last) = (cursor.u64()?, cursor.u64()?);
    let is_short = last.checked_sub(first)? < LONGEST_NS;
    (first > 0 && is_short).then_some((first, last))
}
