//! Channels of recordings: messages of one type on one topic, decoded by the definition in the file.

use super::clocks::Clocks;
use super::ros::{Encoding, Message};
use crate::limits::{self, Excess, JSON_BYTES, NameBudget, RECORD_BYTES};
use crate::topics::sink::{Layout, Loss, Sink, Wanted, short_kind};
use crate::zstd;
use serde_json::Value;
use std::collections::HashMap;

/// Most fields of one topic of JSON.
const MOST_FIELDS: usize = 1024;
/// Longest array of JSON whose elements become fields.
const LONGEST_ARRAY: usize = 64;
/// Messages of these types begin with a stamp of the autopilot's own clock, in µs.
const OWN_CLOCK: &str = "px4_msgs/";

enum Decoder {
    Ros(Message),
    /// With the places of the numbers by name; texts have none.
    Json(HashMap<String, Option<usize>>),
    /// The file has no usable definition.
    Unknown,
}

/// Place of the time inside a message.
#[derive(Clone, Copy, PartialEq)]
enum Stamp {
    None,
    /// Places of seconds and nanoseconds in its header.
    Header(usize, usize),
    /// Place of the autopilot's time.
    Own(usize),
}

impl Stamp {
    fn of(layout: &Layout) -> Self {
        let place = |name: &str| layout.fields.iter().position(|field| field == name);
        let own = place("timestamp").filter(|_| layout.kind.starts_with(OWN_CLOCK));
        let parts = [
            ("header.stamp.sec", "header.stamp.nanosec"),
            ("header.stamp.sec", "header.stamp.nsec"),
            ("timestamp.sec", "timestamp.nsec"),
        ];
        let mut parts = parts.iter();
        let header = parts.find_map(|(sec, nsec)| place(sec).zip(place(nsec)));
        match (own, header) {
            (Some(own), _) => Self::Own(own),
            (None, Some((sec, nsec))) => Self::Header(sec, nsec),
            (None, None) => Self::None,
        }
    }
}

/// A topic of a recording.
pub(super) struct Channel {
    id: usize,
    layout: Layout,
    wanted: Wanted,
    decoder: Decoder,
    stamp: Stamp,
    all: Vec<f64>,
    values: Vec<f64>,
}

impl Channel {
    /// A channel, announced to the sink. `encoding` is that of the messages, as MCAP names them,
    /// and `schema` the definition's type, encoding and text.
    pub(super) fn new(
        id: usize,
        topic: &str,
        encoding: &str,
        schema: Option<(&str, &str, &[u8])>,
        sink: &mut dyn Sink,
        loss: &mut Loss,
        budget: &mut NameBudget,
    ) -> Self {
        let is_named = budget.name(topic).is_some();
        let mut ros = |encoding| {
            let (kind, _, text) = schema.filter(|_| is_named)?;
            let text = std::str::from_utf8(text).ok()?;
            Message::new(kind, text, encoding, budget).map(Decoder::Ros)
        };
        let of = schema.map_or("", |(_, encoding, _)| encoding);
        let decoder = match (encoding, of) {
            ("cdr", "ros2msg") => ros(Encoding::Cdr),
            ("ros1", "ros1msg") => ros(Encoding::Ros1),
            ("json", _) => Some(Decoder::Json(HashMap::new())),
            // Raw packets of a link, without a definition: nothing was there to be decoded.
            ("mavlink", "") => Some(Decoder::Unknown),
            _ => None,
        };
        let decoder = decoder.unwrap_or_else(|| {
            loss.note(format!(
                "{topic}: messages of {encoding:?} with a definition of {of:?} cannot be decoded; they are only counted"
            ));
            Decoder::Unknown
        });
        let mut layout = Layout {
            name: topic.to_owned(),
            kind: short_kind(schema.map_or("", |(kind, ..)| kind)),
            ..Layout::default()
        };
        if let Decoder::Ros(message) = &decoder {
            layout.fields = message.names().to_vec();
            layout.texts = message.texts().to_vec();
        }
        let stamp = Stamp::of(&layout);
        let wanted = sink.topic(id, &layout);
        Self {
            id,
            layout,
            wanted,
            decoder,
            stamp,
            all: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Decodes the requested part of a message, and passes it on.
    pub(super) fn message(
        &mut self,
        recorded_ns: u64,
        clocks: &mut Clocks,
        bytes: &[u8],
        sink: &mut dyn Sink,
        loss: &mut Loss,
        budget: &mut NameBudget,
    ) {
        if self.wanted == Wanted::Nothing {
            return;
        }
        let whole = match &mut self.decoder {
            Decoder::Unknown => Some(()),
            // No sink requested its values or its stamp.
            Decoder::Ros(_) if self.wanted == Wanted::Stamps && self.stamp == Stamp::None => {
                Some(())
            }
            Decoder::Ros(message) => message.decode(bytes, &mut self.all),
            Decoder::Json(_) => self.json(bytes, sink, budget),
        };
        if whole.is_none() {
            loss.undecodable += 1;
            return;
        }
        let stamp_ns = match self.stamp {
            Stamp::Header(seconds, nanoseconds) if self.all[seconds].is_finite() => {
                let seconds_ns = (self.all[seconds] as u64).saturating_mul(1_000_000_000);
                let own_ns = seconds_ns.saturating_add(self.all[nanoseconds] as u64);
                clocks.header(recorded_ns, own_ns)
            }
            Stamp::Own(place) => {
                let own_ns = (self.all[place] as u64).saturating_mul(1000);
                clocks.own(self.id, recorded_ns, own_ns, sink)
            }
            _ => clocks.recorded(recorded_ns),
        };
        self.values.clear();
        if let Wanted::Fields(fields) = &self.wanted {
            let all = &self.all;
            let values = fields
                .iter()
                .map(|&field| all.get(field).copied().unwrap_or(f64::NAN));
            self.values.extend(values);
        }
        sink.message(self.id, Some(stamp_ns), &self.values);
    }

    /// The numbers of a JSON object; fields that are new are announced.
    fn json(&mut self, bytes: &[u8], sink: &mut dyn Sink, budget: &mut NameBudget) -> Option<()> {
        let Decoder::Json(places) = &mut self.decoder else {
            return None;
        };
        if bytes.len() > JSON_BYTES {
            return None;
        }
        let object: Value = serde_json::from_slice(bytes).ok()?;
        self.all.clear();
        self.all.resize(self.layout.fields.len(), f64::NAN);
        let before = places.len();
        let (layout, all) = (&mut self.layout, &mut self.all);
        let mut next = 0;
        flatten(&object, &mut String::new(), &mut |name, value| {
            // Messages of one type usually have their fields in the same order.
            let is_next =
                value.is_some() && layout.fields.get(next).is_some_and(|field| field == name);
            let known = if is_next {
                Some(Some(next))
            } else {
                places.get(name).copied()
            };
            match (known, value) {
                (Some(Some(place)), Some(value)) => {
                    next = place + 1;
                    all[place] = value;
                }
                (Some(_), _) => {}
                (None, Some(value)) if layout.fields.len() < MOST_FIELDS => {
                    budget.name(name)?;
                    places.insert(name.to_owned(), Some(all.len()));
                    layout.fields.push(name.to_owned());
                    all.push(value);
                }
                (None, None) if layout.texts.len() < MOST_FIELDS => {
                    budget.name(name)?;
                    places.insert(name.to_owned(), None);
                    layout.texts.push(name.to_owned());
                }
                (None, _) => {}
            }
            Some(())
        })?;
        if places.len() > before {
            self.wanted = sink.topic(self.id, &self.layout);
            self.stamp = Stamp::of(&self.layout);
        }
        object.is_object().then_some(())
    }
}

/// Reports every number below a JSON value, and the presence of every text, until `tell` refuses one.
/// `name` is that of the value; what is appended to it is removed again.
fn flatten(
    value: &Value,
    name: &mut String,
    tell: &mut dyn FnMut(&str, Option<f64>) -> Option<()>,
) -> Option<()> {
    let length = name.len();
    match value {
        Value::Null => {}
        Value::Bool(yes) => tell(name, Some(f64::from(u8::from(*yes))))?,
        Value::Number(number) => tell(name, number.as_f64())?,
        Value::String(_) => tell(name, None)?,
        Value::Array(elements) => {
            for (k, element) in elements.iter().take(LONGEST_ARRAY).enumerate() {
                name.push_str(&format!("[{k}]"));
                flatten(element, name, tell)?;
                name.truncate(length);
            }
        }
        Value::Object(fields) => {
            for (field, value) in fields {
                if !name.is_empty() {
                    name.push('.');
                }
                name.push_str(field);
                flatten(value, name, tell)?;
                name.truncate(length);
            }
        }
    }
    Some(())
}

/// Packed and unpacked bytes of a log, and whether they are within the limit.
#[derive(Default)]
pub(super) struct Unpacking {
    packed: u64,
    unpacked: u64,
}

impl Unpacking {
    /// Decompresses bytes, as far as they are whole and within the limits, and tells whether they are whole.
    pub(super) fn unpack(&mut self, bytes: &[u8], compression: &str) -> (bool, Vec<u8>) {
        if let "" | "none" = compression {
            return (true, bytes.to_vec());
        }
        self.packed += bytes.len() as u64;
        let left = limits::allowance(self.packed).saturating_sub(self.unpacked);
        let most = left.min(RECORD_BYTES as u64);
        let (whole, unpacked) = unpack_prefix(bytes, compression, most);
        self.unpacked += unpacked.len() as u64;
        (whole, unpacked)
    }

    /// Whether the unpacked bytes are within the limit.
    pub(super) fn check(&self) -> Result<(), Excess> {
        limits::unpacked(self.packed, self.unpacked)
    }
}

/// Decompresses bytes to one more than `most` at most, as far as they are whole, and tells whether they are.
fn unpack_prefix(bytes: &[u8], compression: &str, most: u64) -> (bool, Vec<u8>) {
    use std::io::Read;
    let mut unpacked = Vec::new();
    let mut read = |input: &mut dyn Read| {
        let left = (most + 1).saturating_sub(unpacked.len() as u64);
        let read = input.take(left).read_to_end(&mut unpacked);
        read.is_ok() && unpacked.len() as u64 <= most
    };
    let whole = match compression {
        "lz4" => read(&mut lz4_flex::frame::FrameDecoder::new(bytes)),
        "bz2" => read(&mut bzip2::read::BzDecoder::new(bytes)),
        "zstd" => zstd::unpack(bytes, &mut read),
        _ => false,
    };
    (whole, unpacked)
}
