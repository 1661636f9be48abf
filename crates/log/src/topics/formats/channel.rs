//! Channels of recordings: messages of one type on one topic, decoded by the definition in the file.

use super::clocks::Clocks;
use super::ros::{Encoding, Message};
use crate::topics::sink::{Layout, Loss, Sink, Wanted, short_kind};
use serde_json::Value;

/// Most fields of the topics of ROS of one log.
pub(super) const MOST_FIELDS_IN_ALL: usize = 1 << 18;
/// Most fields of one topic.
const MOST_FIELDS: usize = 1024;
/// Longest array of JSON whose elements become fields.
const LONGEST_ARRAY: usize = 64;
/// Messages of these types begin with a stamp of the autopilot's own clock, in µs.
const OWN_CLOCK: &str = "px4_msgs/";

enum Decoder {
    Ros(Message),
    Json,
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
        fields_left: &mut usize,
    ) -> Self {
        let mut ros = |encoding| {
            let (kind, _, text) = schema?;
            let message = Message::new(kind, std::str::from_utf8(text).ok()?, encoding)?;
            *fields_left = fields_left.checked_sub(message.names().len())?;
            Some(Decoder::Ros(message))
        };
        let of = schema.map_or("", |(_, encoding, _)| encoding);
        let decoder = match (encoding, of) {
            ("cdr", "ros2msg") => ros(Encoding::Cdr),
            ("ros1", "ros1msg") => ros(Encoding::Ros1),
            ("json", _) => Some(Decoder::Json),
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
    ) {
        if self.wanted == Wanted::Nothing {
            return;
        }
        let whole = match &self.decoder {
            Decoder::Unknown => Some(()),
            // No sink requested its values or its stamp.
            Decoder::Ros(_) if self.wanted == Wanted::Stamps && self.stamp == Stamp::None => {
                Some(())
            }
            Decoder::Ros(message) => message.decode(bytes, &mut self.all),
            Decoder::Json => self.json(bytes, sink),
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
    fn json(&mut self, bytes: &[u8], sink: &mut dyn Sink) -> Option<()> {
        let object: Value = serde_json::from_slice(bytes).ok()?;
        self.all.clear();
        self.all.resize(self.layout.fields.len(), f64::NAN);
        let before = self.layout.fields.len();
        let texts = self.layout.texts.len();
        let (layout, all) = (&mut self.layout, &mut self.all);
        let mut next = 0;
        flatten(&object, String::new(), &mut |name, value| match value {
            Some(value) => {
                // Messages of one type usually have their fields in the same order.
                let known = match layout.fields.get(next) {
                    Some(field) if *field == name => Some(next),
                    _ => layout.fields.iter().position(|field| *field == name),
                };
                match known {
                    Some(place) => {
                        next = place + 1;
                        all[place] = value;
                    }
                    None if layout.fields.len() < MOST_FIELDS => {
                        layout.fields.push(name);
                        all.push(value);
                    }
                    None => {}
                }
            }
            None if layout.texts.len() < MOST_FIELDS && !layout.texts.contains(&name) => {
                layout.texts.push(name);
            }
            None => {}
        });
        if layout.fields.len() > before || layout.texts.len() > texts {
            self.wanted = sink.topic(self.id, &self.layout);
            self.stamp = Stamp::of(&self.layout);
        }
        object.is_object().then_some(())
    }
}

/// Reports every number below a JSON value, and the presence of every text.
fn flatten(value: &Value, name: String, tell: &mut dyn FnMut(String, Option<f64>)) {
    match value {
        Value::Null => {}
        Value::Bool(yes) => tell(name, Some(f64::from(u8::from(*yes)))),
        Value::Number(number) => tell(name, number.as_f64()),
        Value::String(_) => tell(name, None),
        Value::Array(elements) => {
            for (k, element) in elements.iter().take(LONGEST_ARRAY).enumerate() {
                flatten(element, format!("{name}[{k}]"), tell);
            }
        }
        Value::Object(fields) => {
            for (field, value) in fields {
                let inner = if name.is_empty() {
                    field.clone()
                } else {
                    format!("{name}.{field}")
                };
                flatten(value, inner, tell);
            }
        }
    }
}

/// Decompresses bytes; `None` if they are damaged or more than `most`.
pub(super) fn unpack(bytes: &[u8], compression: &str, most: usize) -> Option<Vec<u8>> {
    let (whole, unpacked) = unpack_prefix(bytes, compression, most);
    whole.then_some(unpacked)
}

/// As far as they are whole, and whether they are.
pub(super) fn unpack_prefix(bytes: &[u8], compression: &str, most: usize) -> (bool, Vec<u8>) {
    use std::io::Read;
    let mut unpacked = Vec::new();
    let mut read = |input: &mut dyn Read| {
        let limit = most as u64 + 1;
        let read = input.take(limit).read_to_end(&mut unpacked);
        read.is_ok_and(|read| read <= most)
    };
    let whole = match compression {
        "" | "none" => read(&mut { bytes }),
        "lz4" => read(&mut lz4_flex::frame::FrameDecoder::new(bytes)),
        "bz2" => read(&mut bzip2::read::BzDecoder::new(bytes)),
        "zstd" => zstd::stream::read::Decoder::new(bytes).is_ok_and(|mut input| read(&mut input)),
        _ => false,
    };
    (whole, unpacked)
}
