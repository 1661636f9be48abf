//! A recorded flight, run again by the same code.

use serde::Serialize;

use crate::companion::{Companion, Event, Summary};
use crate::error::LinkError;
use crate::recording::{Entry, Recording};
use crate::wire::Decoder;
use crate::wire::signing::SigningKey;
use mavlink::Message as _;

/// The first event upon which the replay sends other bytes than the flight did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Time of the event, s.
    pub time_s: f64,
    /// The event.
    pub event: &'static str,
    /// Its number, from zero.
    pub index: usize,
    /// Messages that the flight sent.
    pub recorded: Vec<String>,
    /// Messages that the replay sent.
    pub replayed: Vec<String>,
}

/// A replay.
#[derive(Clone, Debug, Serialize)]
pub struct Replay {
    /// Events that were run.
    pub events: usize,
    /// Bytes that were sent.
    pub sent_bytes: usize,
    /// Whether the recording has no end, as after a kill.
    pub cut_off: bool,
    /// The first difference, if there is one.
    pub difference: Option<Difference>,
    /// Summary of the flight, up to the difference.
    pub flight: Summary,
}

/// Runs a recording through the companion and compares the bytes that it sends, bit for bit. A signed flight needs its key.
///
/// # Errors
/// Settings that cannot be flown, or a key that is missing.
pub fn replay(recording: &Recording, key: Option<SigningKey>) -> Result<Replay, LinkError> {
    let session = recording.session(key)?;
    let mut companion = Companion::new(&recording.settings, &session)?;
    let (mut events, mut sent_bytes, mut difference) = (0, 0, None);
    let mut out = Vec::new();
    let mut entries = recording.entries.iter().peekable();
    while let Some((at_us, entry)) = entries.next() {
        let (event, name) = match entry {
            Entry::Received(bytes) => (Event::Received(bytes), "received"),
            Entry::Camera(report) => (Event::Camera(report), "camera"),
            Entry::Tick => (Event::Tick, "tick"),
            Entry::Stop => (Event::Stop, "stop"),
            // Bytes without an event are a difference: the replay sent none.
            Entry::Sent(_) => (Event::Received(&[]), "none"),
        };
        out.clear();
        companion.handle(*at_us, event, &mut out);
        let recorded = match (entry, entries.peek()) {
            (Entry::Sent(bytes), _) => bytes.as_slice(),
            (_, Some((_, Entry::Sent(bytes)))) => {
                entries.next();
                bytes.as_slice()
            }
            // The kill may have come between the event and the bytes sent upon it.
            (_, None) if recording.cut_off => out.as_slice(),
            _ => &[],
        };
        if recorded != out {
            difference = Some(Difference {
                time_s: *at_us as f64 * 1e-6,
                event: name,
                index: events,
                recorded: messages(recorded),
                replayed: messages(&out),
            });
            break;
        }
        events += 1;
        sent_bytes += out.len();
    }
    Ok(Replay {
        events,
        sent_bytes,
        cut_off: recording.cut_off,
        difference,
        flight: companion.summary(),
    })
}

/// The messages in bytes, as text.
fn messages(bytes: &[u8]) -> Vec<String> {
    let mut decoder = Decoder::default();
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next_frame())
        .map(|frame| {
            let name = frame.message.message_name();
            format!("{name} {:?}", frame.message)
        })
        .collect()
}
