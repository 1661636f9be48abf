//! Reads PX4's ULog.
//!
//! A file is a header of 16 bytes, then messages, each with a length, a type and that number of bytes.
//! A message of unknown type, or of another size than its format, means damage. Reading continues at
//! the next three complete messages in succession.

mod format;
mod write;

use super::stream::Stream;
use super::{LogFormat, Reader};
use crate::limits::NameBudget;
use crate::topics::sink::{Layout, Loss, ReadError, Sink, Wanted};
use format::{Formats, Places};
use std::io::{self, Read};
pub use write::{UlogTopic, UlogWriter};

/// First bytes of a file.
const MAGIC: [u8; 7] = [0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35];
/// Content of synchronisation messages, at which reading can continue after damage.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
const HEADER: usize = 16;
/// Number of complete messages in succession after which reading continues behind damage. ULog has no
/// mark at the start of a message, so it needs more than DataFlash.
const WHOLE_IN_A_ROW: usize = 3;
/// Most topics of one log.
const MOST_TOPICS: usize = 4096;
/// Longest message with its head.
const LONGEST: usize = 3 + u16::MAX as usize;

struct Subscription {
    id: usize,
    places: Places,
    wanted: Wanted,
}

pub(super) struct Ulog<'s> {
    sink: &'s mut dyn Sink,
    formats: Formats,
    subscriptions: Vec<Option<Subscription>>,
    topics: usize,
    /// Number of topics that were omitted. It is limited, because each of them takes time to check.
    refused: usize,
    budget: NameBudget,
    /// Messages of any type.
    taken: usize,
    start_us: u64,
    /// Offsets at which data were appended, the next one last.
    appended: Vec<u64>,
    values: Vec<f64>,
    loss: Loss,
    dropouts: usize,
    dropouts_ms: u64,
}

pub(super) const READER: Reader = Reader {
    format: LogFormat::Ulog,
    name: "PX4 ULog",
    magic: &MAGIC,
    stamps_since: "the start of the log",
    maps: &["px4"],
    read,
};

/// Reads a whole log.
fn read(input: &mut dyn Read, sink: &mut dyn Sink) -> Result<Loss, ReadError> {
    let mut stream = Stream::new(input);
    let Some(header) = stream.peek(HEADER)? else {
        return Err(ReadError::broken(
            LogFormat::Ulog,
            "that ends in its header",
        ));
    };
    if header[..7] != MAGIC {
        return Err(ReadError::broken(
            LogFormat::Ulog,
            "without its first bytes",
        ));
    }
    let start_us = header[8..16]
        .iter()
        .rev()
        .fold(0, |sum, &b| sum << 8 | u64::from(b));
    stream.advance(HEADER);
    let mut reader = Ulog {
        sink,
        formats: Formats::default(),
        subscriptions: Vec::new(),
        topics: 0,
        refused: 0,
        budget: NameBudget::default(),
        taken: 0,
        start_us,
        appended: Vec::new(),
        values: Vec::new(),
        loss: Loss::default(),
        dropouts: 0,
        dropouts_ms: 0,
    };
    reader.run(&mut stream)?;
    if reader.dropouts > 0 {
        reader.loss.notes.push(format!(
            "the logger itself dropped data {} times, {} s in all",
            reader.dropouts,
            reader.dropouts_ms as f64 / 1e3
        ));
    }
    Ok(reader.loss)
}

impl Ulog<'_> {
    fn run(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        loop {
            let position = stream.position();
            let appended = self.appended.last().copied();
            let length = match stream.peek(3)? {
                Some(head) => 3 + usize::from(u16::from_le_bytes([head[0], head[1]])),
                None => 3,
            };
            // Data appended after a crash follow a message that may be truncated.
            if let Some(at) = appended.filter(|&at| position + length as u64 > at) {
                stream.skip(at.saturating_sub(position))?;
                self.appended.pop();
                continue;
            }
            let Some(message) = stream.peek(length)? else {
                let left = stream.window();
                // A damaged length may reach beyond the end.
                if (1..left.len()).any(|at| self.goes_on(&left[at..], false)) {
                    self.resynchronise(stream)?;
                    continue;
                }
                if !left.is_empty() {
                    self.loss.truncated = true;
                    self.loss.skipped_bytes += left.len() as u64;
                }
                return Ok(());
            };
            if self.is_whole(message) {
                let (kind, body) = (message[2], &message[3..]);
                self.take(kind, body)?;
                self.budget.check()?;
                stream.advance(length);
            } else {
                self.resynchronise(stream)?;
            }
        }
    }

    /// Skips damage.
    fn resynchronise(&mut self, stream: &mut Stream<'_>) -> io::Result<()> {
        self.loss.corrupt += 1;
        loop {
            stream.advance(1);
            self.loss.skipped_bytes += 1;
            // Enough for the longest messages, if the file has them.
            let there = stream.fill((WHOLE_IN_A_ROW + 1) * LONGEST)?;
            let window = &stream.window()[..there];
            if window.is_empty() || self.goes_on(window, true) {
                return Ok(());
            }
        }
    }

    /// Whether complete messages follow. If `cut`, the file's end may truncate the last of them.
    fn goes_on(&self, window: &[u8], cut: bool) -> bool {
        let mut rest = window;
        for row in 0..WHOLE_IN_A_ROW {
            if rest.len() < 3 {
                return row > 0 && rest.is_empty();
            }
            let length = 3 + usize::from(u16::from_le_bytes([rest[0], rest[1]]));
            let Some(message) = rest.get(..length) else {
                return cut && row > 0 && is_known(rest[2]);
            };
            if !self.is_whole(message) {
                return false;
            }
            if message[2] == b'S' {
                return true;
            }
            rest = &rest[length..];
        }
        true
    }

    /// Whether type and size of a message agree with the known formats.
    fn is_whole(&self, message: &[u8]) -> bool {
        let body = &message[3..];
        match message[2] {
            b'D' => {
                let [low, high, data @ ..] = body else {
                    return false;
                };
                let number = usize::from(u16::from_le_bytes([*low, *high]));
                matches!(
                    self.subscriptions.get(number),
                    Some(Some(s)) if (s.places.shortest..=s.places.longest).contains(&data.len())
                )
            }
            b'S' => body == SYNC,
            b'O' | b'R' => body.len() == 2,
            // A look at the start is enough, and bounds the search.
            b'F' | b'A' => {
                body.len() > 3 && body[3..].iter().take(64).all(|b| (b' '..=b'~').contains(b))
            }
            // These flags state how to read the rest, and precede it.
            b'B' => body.len() >= 40 && self.taken == 0,
            b'P' | b'Q' => body.len() > 6,
            b'L' | b'C' => body.len() >= 9,
            b'I' | b'M' => body.len() >= 2,
            _ => false,
        }
    }

    fn take(&mut self, kind: u8, body: &[u8]) -> Result<(), ReadError> {
        self.taken += 1;
        match kind {
            b'D' => self.data(body),
            b'F' => {
                if let Err(what) = self.formats.define(body) {
                    self.loss.corrupt += 1;
                    self.loss.note(format!("{what} was skipped"));
                }
            }
            b'A' => self.subscribe(body),
            b'P' => self.parameter(body),
            b'O' => {
                self.dropouts += 1;
                self.dropouts_ms += u64::from(u16::from_le_bytes([body[0], body[1]]));
            }
            b'B' => {
                let unknown = body[8] & !1 != 0 || body[9..16].iter().any(|&b| b != 0);
                if unknown {
                    let what =
                        "with an unknown incompatibility flag, so its data cannot be decoded";
                    return Err(ReadError::broken(LogFormat::Ulog, what));
                }
                let offset = |k: usize| {
                    body[k..k + 8]
                        .iter()
                        .rev()
                        .fold(0, |s, &b| s << 8 | u64::from(b))
                };
                if body[8] & 1 != 0 {
                    self.appended = [32, 24, 16]
                        .map(offset)
                        .into_iter()
                        .filter(|&at| at > 0)
                        .collect();
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn subscribe(&mut self, body: &[u8]) {
        let number = usize::from(u16::from_le_bytes([body[1], body[2]]));
        let name = String::from_utf8_lossy(&body[3..]).into_owned();
        let places = match (self.topics, self.refused) {
            (..MOST_TOPICS, ..MOST_TOPICS) => self.formats.flatten(&name, &mut self.budget),
            _ => None,
        };
        let Some(places) = places else {
            self.refused += 1;
            self.loss.corrupt += 1;
            self.loss.note(format!(
                "topic {name:?} has no usable format and was left out"
            ));
            // Its messages are no damage, whatever their length.
            let places = Places {
                longest: usize::MAX,
                ..Places::default()
            };
            self.subscribed(number, places, Wanted::Nothing);
            return;
        };
        let layout = Layout {
            name,
            kind: String::new(),
            instance: body[0].into(),
            fields: places.names.clone(),
            texts: Vec::new(),
        };
        let wanted = self.sink.topic(self.topics, &layout);
        self.subscribed(number, places, wanted);
        self.topics += 1;
    }

    fn subscribed(&mut self, number: usize, places: Places, wanted: Wanted) {
        if self.subscriptions.len() <= number {
            self.subscriptions.resize_with(number + 1, || None);
        }
        let id = self.topics;
        self.subscriptions[number] = Some(Subscription { id, places, wanted });
    }

    #[inline]
    fn data(&mut self, body: &[u8]) {
        let number = usize::from(u16::from_le_bytes([body[0], body[1]]));
        let Some(Some(subscription)) = self.subscriptions.get(number) else {
            return;
        };
        if subscription.wanted == Wanted::Nothing {
            return;
        }
        let data = &body[2..];
        let places = &subscription.places;
        let stamp_us = places
            .stamp
            .and_then(|at| data.get(at..at + 8)?.try_into().ok())
            .map_or(0, u64::from_le_bytes);
        // A message without a stamp has 0. A message may be older than the log.
        let since_us = stamp_us.wrapping_sub(self.start_us).cast_signed();
        let stamp_ns = (stamp_us != 0).then(|| since_us.saturating_mul(1000));
        self.values.clear();
        if let Wanted::Fields(fields) = &subscription.wanted {
            let values = fields.iter().map(|&field| {
                let (scalar, at) = places.places[field];
                scalar.read(data, at)
            });
            self.values.extend(values);
        }
        self.sink.message(subscription.id, stamp_ns, &self.values);
    }

    /// The first value counts; a later change is reported once.
    fn parameter(&mut self, body: &[u8]) {
        let length = usize::from(body[0]);
        let (Some(key), Some(Ok(value))) = (
            body.get(1..1 + length)
                .and_then(|key| std::str::from_utf8(key).ok()),
            body.get(1 + length..).map(<[u8; 4]>::try_from),
        ) else {
            self.loss.undecodable += 1;
            return;
        };
        let value = match key.split_once(' ') {
            Some(("float", name)) => Some((name, f64::from(f32::from_le_bytes(value)))),
            Some(("int32_t", name)) => Some((name, f64::from(i32::from_le_bytes(value)))),
            _ => None,
        };
        match value {
            Some((name, value)) => self.sink.parameter(name, value),
            None => self.loss.undecodable += 1,
        }
    }
}

fn is_known(kind: u8) -> bool {
    b"DFASORBPQLCIM".contains(&kind)
}
