//! Reads bags of ROS 1, format 2.0.
//!
//! A file is a sequence of records, each with a head and data of stated lengths. Most records are in
//! chunks, compressed or not. The reader does not need the index, so it also reads a bag that was not
//! closed.

use super::channel::{Channel, Unpacking};
use super::clocks::Clocks;
use super::cursor::Cursor;
use super::stream::Stream;
use super::{LogFormat, Reader};
use crate::limits::{NameBudget, RECORD_BYTES as LONGEST};
use crate::topics::sink::{Loss, ReadError, Sink};
use std::collections::HashMap;
use std::io::Read;

/// First bytes of a file.
const MAGIC: [u8; 13] = *b"#ROSBAG V2.0\n";
/// Most connections of one log.
const MOST_CONNECTIONS: usize = 4096;

const MESSAGE: u8 = 2;
const CHUNK: u8 = 5;
const CONNECTION: u8 = 7;

struct Bag<'s> {
    sink: &'s mut dyn Sink,
    /// By the connection's number; several may be of one topic.
    channels: HashMap<u32, Channel>,
    topics: usize,
    budget: NameBudget,
    unpacking: Unpacking,
    clocks: Clocks,
    loss: Loss,
}

pub(super) const READER: Reader = Reader {
    format: LogFormat::Rosbag,
    name: "ROS 1 bag",
    magic: &MAGIC,
    stamps_since: "the first message",
    maps: &["px4", "ros"],
    read,
};

/// Reads a whole log.
fn read(input: &mut dyn Read, sink: &mut dyn Sink) -> Result<Loss, ReadError> {
    let mut stream = Stream::new(input);
    stream.begin(&MAGIC, LogFormat::Rosbag)?;
    let mut bag = Bag {
        sink,
        channels: HashMap::new(),
        topics: 0,
        budget: NameBudget::default(),
        unpacking: Unpacking::default(),
        clocks: Clocks::default(),
        loss: Loss::default(),
    };
    bag.run(&mut stream)?;
    bag.clocks.finish(bag.sink, &mut bag.loss);
    Ok(bag.loss)
}

/// Head and data of a record, as far as the file has them.
struct Record<'a> {
    head: &'a [u8],
    data: &'a [u8],
    /// Bytes of all of it, if the file has them.
    length: u64,
}

/// `None` where not even the lengths are there.
fn split(bytes: &[u8]) -> Option<Record<'_>> {
    let mut cursor = Cursor::new(bytes);
    let head = cursor.sized()?;
    let data = cursor.u32()?;
    let length = cursor.at() as u64 + u64::from(data);
    let data = cursor.rest();
    Some(Record { head, data, length })
}

/// The value of a field of a head.
fn field<'a>(head: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let mut cursor = Cursor::new(head);
    loop {
        let pair = cursor.sized()?;
        let value = pair.strip_prefix(name.as_bytes());
        if let Some(value) = value.and_then(|rest| rest.strip_prefix(b"=")) {
            return Some(value);
        }
    }
}

fn number(head: &[u8], name: &str) -> Option<u32> {
    Some(u32::from_le_bytes(field(head, name)?.try_into().ok()?))
}

fn text<'a>(head: &'a [u8], name: &str) -> Option<&'a str> {
    std::str::from_utf8(field(head, name)?).ok()
}

impl Bag<'_> {
    fn run(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        loop {
            if stream.peek(1)?.is_none() {
                return Ok(());
            }
            // The head and the length of the data.
            let head = match stream.peek(4)? {
                Some(length) => 8 + Cursor::new(length).u32().unwrap_or(u32::MAX) as usize,
                None => return self.broken_off(stream),
            };
            let length = match stream.peek(head.min(LONGEST))?.and_then(split) {
                Some(record) => record.length,
                None => return self.broken_off(stream),
            };
            if length > LONGEST as u64 {
                let there = stream.skip(length)?;
                self.loss.truncated |= there < length;
                self.loss.corrupt += usize::from(there == length);
                self.loss.skipped_bytes += there;
                continue;
            }
            let Some(bytes) = stream.peek(length as usize)? else {
                return self.broken_off(stream);
            };
            let record = split(bytes);
            if record
                .and_then(|record| self.record(record.head, record.data, true))
                .is_none()
            {
                self.loss.corrupt += 1;
                self.loss.skipped_bytes += length;
            }
            self.check()?;
            stream.advance(length as usize);
        }
    }

    /// Whether all that was asked for so far is within the limits.
    fn check(&self) -> Result<(), ReadError> {
        self.unpacking.check()?;
        self.budget.check()?;
        Ok(self.sink.excess().map_or(Ok(()), Err)?)
    }

    /// Uses the existing part of a truncated chunk.
    fn broken_off(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        self.loss.truncated = true;
        let left = stream.window();
        self.loss.skipped_bytes += left.len() as u64;
        if let Some(record) = split(left)
            && field(record.head, "op") == Some(&[CHUNK])
            && let Some(compression) = text(record.head, "compression")
        {
            let (_, unpacked) = self.unpacking.unpack(record.data, compression);
            self.records(&unpacked);
        }
        self.check()
    }

    /// The records of a chunk; `None` if they are not complete.
    fn records(&mut self, bytes: &[u8]) -> Option<()> {
        let mut cursor = Cursor::new(bytes);
        while !cursor.rest().is_empty() {
            let head = cursor.sized()?;
            let data = cursor.sized()?;
            if self.record(head, data, false).is_none() {
                self.loss.corrupt += 1;
                self.loss.skipped_bytes += data.len() as u64;
            }
        }
        Some(())
    }

    /// `None` for a record that is damaged.
    fn record(&mut self, head: &[u8], data: &[u8], outside: bool) -> Option<()> {
        let [op] = field(head, "op")?.try_into().ok()?;
        match op {
            CONNECTION => {
                let number = number(head, "conn")?;
                let topic = text(head, "topic")?;
                let (kind, definition) = (text(data, "type")?, field(data, "message_definition")?);
                if !self.channels.contains_key(&number) && self.topics < MOST_CONNECTIONS {
                    let schema = Some((kind, "ros1msg", definition));
                    let loss = &mut self.loss;
                    let left = &mut self.budget;
                    let channel =
                        Channel::new(self.topics, topic, "ros1", schema, self.sink, loss, left);
                    self.channels.insert(number, channel);
                    self.topics += 1;
                }
            }
            MESSAGE => {
                let mut time = Cursor::new(field(head, "time")?);
                let seconds = u64::from(time.u32()?);
                let recorded_ns = seconds * 1_000_000_000 + u64::from(time.u32()?);
                self.clocks.recorded(recorded_ns);
                let Some(channel) = self.channels.get_mut(&number(head, "conn")?) else {
                    // The record of the connection is lost, or there are too many.
                    self.loss.undecodable += 1;
                    return Some(());
                };
                channel.message(
                    recorded_ns,
                    &mut self.clocks,
                    data,
                    self.sink,
                    &mut self.loss,
                    &mut self.budget,
                );
            }
            CHUNK if outside => match text(head, "compression")? {
                "none" => self.records(data)?,
                compression => {
                    let (whole, unpacked) = self.unpacking.unpack(data, compression);
                    self.records(whole.then_some(&unpacked)?)?;
                }
            },
            _ => {}
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::survey::Surveyor;

    fn sized(parts: &[&[u8]]) -> Vec<u8> {
        let bytes = parts.concat();
        [&(bytes.len() as u32).to_le_bytes()[..], &bytes].concat()
    }

    fn record(op: u8, fields: &[Vec<u8>], data: &[u8]) -> Vec<u8> {
        let head = [sized(&[b"op=", &[op]]), fields.concat()].concat();
        [sized(&[&head]), sized(&[data])].concat()
    }

    fn message(second: u8) -> Vec<u8> {
        let fields = [
            sized(&[b"conn=", &[0; 4]]),
            sized(&[b"time=", &[second, 0, 0, 0, 0, 0, 0, 0]]),
        ];
        record(MESSAGE, &fields, &[second])
    }

    #[test]
    fn prop_a_bad_record_costs_no_other_of_its_chunk() {
        let definition = [
            sized(&[b"type=a/B"]),
            sized(&[b"message_definition=uint8 x"]),
        ];
        let fields = [sized(&[b"conn=", &[0; 4]]), sized(&[b"topic=/a"])];
        let connection = record(CONNECTION, &fields, &definition.concat());
        // A message that does not say when it was.
        let bad = record(MESSAGE, &fields[..1], &[9]);
        let records = [connection, message(1), bad, message(2)].concat();
        let chunk = record(CHUNK, &[sized(&[b"compression=none"])], &records);
        let file = [&MAGIC[..], &chunk].concat();
        let mut surveyor = Surveyor::new(true);
        let loss = read(&mut file.as_slice(), &mut surveyor).unwrap();
        let survey = surveyor.finish("log", LogFormat::Rosbag, String::new());
        assert_eq!((loss.corrupt, loss.skipped_bytes), (1, 1));
        let topic = &survey.topics[0];
        assert_eq!((topic.messages, topic.fields[0].sum), (2, 3.0));
    }
}
