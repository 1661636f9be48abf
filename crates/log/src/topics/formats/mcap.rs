//! Reads MCAP: recordings of ROS 1, ROS 2 and of anything in JSON.
//!
//! A file is a sequence of records, each with a type, a length and that number of bytes. Most records
//! are in chunks, compressed or not. A damaged chunk is skipped and reported. An incomplete file is
//! used up to its end.

use super::channel::{Channel, Unpacking};
use super::clocks::Clocks;
use super::cursor::Cursor;
use super::lost::LostChunks;
use super::stream::Stream;
use super::{LogFormat, Reader};
use crate::limits::{NameBudget, RECORD_BYTES as LONGEST};
use crate::topics::sink::{Loss, ReadError, Sink};
use std::collections::HashMap;
use std::io::Read;

/// First and last bytes of a file.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Most channels and definitions of one log.
const MOST_CHANNELS: usize = 4096;
/// Most bytes of definitions that are kept.
const MOST_SCHEMA_BYTES: usize = 32 << 20;

const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const MESSAGE_INDEX: u8 = 7;
const FOOTER: u8 = 2;
const DATA_END: u8 = 0x0f;
/// Known opcodes. A record with another opcode is suspect.
const KNOWN: std::ops::RangeInclusive<u8> = 1..=0x0f;

struct Schema {
    name: String,
    encoding: String,
    text: Vec<u8>,
}

struct Mcap<'s> {
    sink: &'s mut dyn Sink,
    schemas: HashMap<u16, Schema>,
    schema_bytes: usize,
    channels: HashMap<u16, Channel>,
    topics: usize,
    budget: NameBudget,
    unpacking: Unpacking,
    clocks: Clocks,
    loss: Loss,
    /// Number of messages, decodable or not.
    messages: usize,
    lost: LostChunks,
    /// Of all bytes so far; `None` once some were skipped unread.
    sum: Option<crc32fast::Hasher>,
}

pub(super) const READER: Reader = Reader {
    format: LogFormat::Mcap,
    name: "MCAP recording",
    magic: &MAGIC,
    stamps_since: "the first message",
    maps: &["px4", "fly", "ros"],
    read,
};

/// Reads a whole log.
fn read(input: &mut dyn Read, sink: &mut dyn Sink) -> Result<Loss, ReadError> {
    let mut stream = Stream::new(input);
    stream.begin(&MAGIC, LogFormat::Mcap)?;
    let mut reader = Mcap {
        sink,
        schemas: HashMap::new(),
        schema_bytes: 0,
        channels: HashMap::new(),
        topics: 0,
        budget: NameBudget::default(),
        unpacking: Unpacking::default(),
        clocks: Clocks::default(),
        loss: Loss::default(),
        messages: 0,
        lost: LostChunks::default(),
        sum: Some(crc32fast::Hasher::new()),
    };
    reader.run(&mut stream)?;
    reader.lost.tell(&mut reader.clocks, &mut reader.loss);
    reader.clocks.finish(reader.sink, &mut reader.loss);
    Ok(reader.loss)
}

impl Mcap<'_> {
    fn run(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        self.add(&MAGIC);
        loop {
            let Some(head) = stream.peek(9)? else {
                return self.broken_off(stream);
            };
            let opcode = head[0];
            let length = Cursor::new(&head[1..]).u64().unwrap_or(u64::MAX);
            if opcode == DATA_END {
                let record = stream.peek(9 + 4)?;
                let stated = record.and_then(|record| Cursor::new(&record[9..]).u32());
                self.judge(stated);
                return self.end(stream);
            }
            if !KNOWN.contains(&opcode) && opcode < 0x80 {
                self.loss.corrupt += 1;
                let left = stream.skip(u64::MAX)?;
                self.loss.skipped_bytes += left;
                let text = "a record of unknown type ends the readable part of the file".to_owned();
                self.loss.notes.push(text);
                return Ok(());
            }
            if length > LONGEST as u64 {
                self.sum = None;
                let there = stream.skip(length.saturating_add(9))?;
                if there < length.saturating_add(9) {
                    self.loss.truncated = true;
                } else if opcode <= CHUNK {
                    self.loss.corrupt += 1;
                }
                self.loss.skipped_bytes += there;
                continue;
            }
            let length = 9 + length as usize;
            let Some(record) = stream.peek(length)? else {
                return self.broken_off(stream);
            };
            self.add(record);
            let body = &record[9..];
            let before = self.messages;
            if opcode != MESSAGE_INDEX {
                self.lost.close();
            }
            if self.record(opcode, body, true).is_none() {
                self.loss.corrupt += 1;
                self.loss.skipped_bytes += length as u64;
                if opcode == CHUNK {
                    self.lost.push(length, body, self.messages - before);
                }
            }
            self.check()?;
            stream.advance(length);
        }
    }

    fn add(&mut self, bytes: &[u8]) {
        if let Some(sum) = &mut self.sum {
            sum.update(bytes);
        }
    }

    /// Compares the sum that a recording states of its data with that of its bytes; 0 states none. Chunks have sums of their own: after
    /// a damaged one nothing new is said.
    fn judge(&mut self, stated: Option<u32>) {
        let stated = stated.filter(|sum| *sum != 0 && self.loss.corrupt == 0);
        let sum = self.sum.take().map(crc32fast::Hasher::finalize);
        if stated.is_some_and(|stated| sum.is_some_and(|sum| sum != stated)) {
            let text = "the checksum of the data is wrong: the file has changed since it was recorded, and its values may be false";
            self.loss.note(text.to_owned());
        }
    }

    /// Whether all that was asked for so far is within the limits.
    fn check(&self) -> Result<(), ReadError> {
        self.unpacking.check()?;
        self.budget.check()?;
        Ok(self.sink.excess().map_or(Ok(()), Err)?)
    }

    /// Skips the tables after the data, and counts the bytes after the end of the recording.
    fn end(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        loop {
            let Some(head) = stream.peek(9)? else {
                return Ok(());
            };
            let opcode = head[0];
            let length = Cursor::new(&head[1..]).u64().unwrap_or(u64::MAX);
            stream.skip(length.saturating_add(9))?;
            if opcode == FOOTER {
                break;
            }
        }
        if stream.peek(MAGIC.len())? != Some(&MAGIC) {
            return Ok(());
        }
        stream.advance(MAGIC.len());
        let left = stream.skip(u64::MAX)?;
        if left > 0 {
            self.loss.corrupt += 1;
            self.loss.skipped_bytes += left;
            let text = format!("{left} bytes follow the end of the recording");
            self.loss.notes.push(text);
        }
        Ok(())
    }

    /// Uses the existing part of a truncated chunk.
    fn broken_off(&mut self, stream: &mut Stream<'_>) -> Result<(), ReadError> {
        self.loss.truncated = true;
        let left = stream.window();
        self.loss.skipped_bytes += left.len() as u64;
        if left.len() > 9 && left[0] == CHUNK {
            let mut cursor = Cursor::new(&left[9..]);
            if let Some((_, compression)) = chunk_head(&mut cursor) {
                let (_, unpacked) = self.unpacking.unpack(cursor.rest(), compression);
                self.records(&unpacked);
            }
        }
        self.check()
    }

    /// The records of a chunk; `None` if they are not complete.
    fn records(&mut self, bytes: &[u8]) -> Option<()> {
        let mut cursor = Cursor::new(bytes);
        while !cursor.rest().is_empty() {
            let [opcode] = cursor.array()?;
            let length = usize::try_from(cursor.u64()?).ok()?;
            let body = cursor.take(length)?;
            if self.record(opcode, body, false).is_none() {
                self.loss.corrupt += 1;
                self.loss.skipped_bytes += body.len() as u64;
            }
        }
        Some(())
    }

    /// `None` for a record that is damaged.
    fn record(&mut self, opcode: u8, body: &[u8], outside: bool) -> Option<()> {
        let mut cursor = Cursor::new(body);
        match opcode {
            SCHEMA => self.schema(&mut cursor)?,
            CHANNEL => self.channel(&mut cursor)?,
            MESSAGE => self.message(&mut cursor)?,
            CHUNK if outside => {
                let (checksum, compression) = chunk_head(&mut cursor)?;
                let unpacked;
                let records = match compression {
                    "" => cursor.rest(),
                    compression => {
                        let whole;
                        (whole, unpacked) = self.unpacking.unpack(cursor.rest(), compression);
                        whole.then_some(&unpacked[..])?
                    }
                };
                if checksum != 0 && crc32fast::hash(records) != checksum {
                    return None;
                }
                self.records(records)?;
            }
            MESSAGE_INDEX => self.lost.index(&mut cursor),
            _ => {}
        }
        Some(())
    }

    fn schema(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        let id = u16::from_le_bytes(cursor.array()?);
        // Every chunk repeats the definitions that it uses.
        if self.schemas.contains_key(&id) {
            return Some(());
        }
        let (name, encoding) = (text(cursor)?, text(cursor)?);
        let definition = cursor.sized()?;
        let bytes = self.schema_bytes + definition.len();
        if bytes > MOST_SCHEMA_BYTES {
            return None;
        }
        self.schema_bytes = bytes;
        let schema = Schema {
            name: name.to_owned(),
            encoding: encoding.to_owned(),
            text: definition.to_vec(),
        };
        self.schemas.insert(id, schema);
        Some(())
    }

    fn channel(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        let id = u16::from_le_bytes(cursor.array()?);
        let schema = u16::from_le_bytes(cursor.array()?);
        let (topic, encoding) = (text(cursor)?, text(cursor)?);
        // Every chunk repeats the channels that it uses.
        if self.channels.contains_key(&id) || self.topics == MOST_CHANNELS {
            return Some(());
        }
        let schema = self.schemas.get(&schema);
        let schema = schema.map(|s| (s.name.as_str(), s.encoding.as_str(), s.text.as_slice()));
        let channel = Channel::new(
            self.topics,
            topic,
            encoding,
            schema,
            self.sink,
            &mut self.loss,
            &mut self.budget,
        );
        self.channels.insert(id, channel);
        self.topics += 1;
        Some(())
    }

    fn message(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        let id = u16::from_le_bytes(cursor.array()?);
        cursor.u32()?;
        let recorded_ns = cursor.u64()?;
        cursor.u64()?;
        self.clocks.recorded(recorded_ns);
        self.messages += 1;
        match self.channels.get_mut(&id) {
            Some(channel) => channel.message(
                recorded_ns,
                &mut self.clocks,
                cursor.rest(),
                self.sink,
                &mut self.loss,
                &mut self.budget,
            ),
            // The record of the channel is lost, or there are too many.
            None => self.loss.undecodable += 1,
        }
        Some(())
    }
}

/// Reads checksum and compression. The rest of the bytes are the records.
fn chunk_head<'a>(cursor: &mut Cursor<'a>) -> Option<(u32, &'a str)> {
    cursor.take(24)?;
    let checksum = cursor.u32()?;
    let compression = text(cursor)?;
    cursor.u64()?;
    Some((checksum, compression))
}

fn text<'a>(cursor: &mut Cursor<'a>) -> Option<&'a str> {
    std::str::from_utf8(cursor.sized()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::survey::Surveyor;

    fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
        let length = (body.len() as u64).to_le_bytes();
        [&[opcode], &length[..], body].concat()
    }

    fn texts(texts: &[&[u8]]) -> Vec<u8> {
        let sized = |text: &&[u8]| [&(text.len() as u32).to_le_bytes()[..], text].concat();
        texts.iter().flat_map(sized).collect()
    }

    fn schema(definition: &[u8]) -> Vec<u8> {
        let body = texts(&[b"Any", b"jsonschema", definition]);
        record(SCHEMA, &[&[1, 0][..], &body].concat())
    }

    fn channel(topic: &str) -> Vec<u8> {
        let body = texts(&[topic.as_bytes(), b"json"]);
        record(CHANNEL, &[&[1, 0, 1, 0][..], &body, &[0; 4]].concat())
    }

    fn message(recorded_ns: u64, json: &[u8]) -> Vec<u8> {
        let stamps = [recorded_ns.to_le_bytes(); 2].concat();
        record(MESSAGE, &[&[1, 0, 0, 0, 0, 0][..], &stamps, json].concat())
    }

    fn chunk(records: &[Vec<u8>]) -> Vec<u8> {
        let head = [&[0; 28][..], &texts(&[b""]), &[0; 8]].concat();
        record(CHUNK, &[head, records.concat()].concat())
    }

    fn read_all(records: &[Vec<u8>]) -> (usize, Loss) {
        let mut surveyor = Surveyor::new(true);
        let end = record(DATA_END, &[0; 4]);
        let file = [MAGIC.to_vec(), records.concat(), end].concat();
        let loss = read(&mut file.as_slice(), &mut surveyor).unwrap();
        let survey = surveyor.finish("log", LogFormat::Mcap, String::new());
        (survey.messages(), loss)
    }

    #[test]
    fn prop_definitions_that_chunks_tell_again_count_once() {
        let definition = vec![b' '; 1 << 20];
        let chunks: Vec<Vec<u8>> = (0..40)
            .map(|i| chunk(&[schema(&definition), channel("a"), message(i, b"{}")]))
            .collect();
        assert!(chunks.len() << 20 > MOST_SCHEMA_BYTES);
        assert_eq!(read_all(&chunks), (40, Loss::default()));
    }

    #[test]
    fn prop_a_bad_record_costs_no_other_of_its_chunk() {
        let bad = record(SCHEMA, &[7]);
        let one = chunk(&[
            schema(b""),
            channel("a"),
            message(0, b"{}"),
            bad,
            message(1, b"{}"),
        ]);
        let (messages, loss) = read_all(&[one]);
        assert_eq!((messages, loss.corrupt, loss.skipped_bytes), (2, 1, 1));
    }

    #[test]
    fn analytic_a_changed_bit_outside_of_chunks_is_told() {
        let data = [schema(b""), channel("a"), message(0, b"{\"x\":1}")].concat();
        let mut file = [MAGIC.to_vec(), data].concat();
        let sum = crc32fast::hash(&file);
        file.extend(record(DATA_END, &sum.to_le_bytes()));
        let told = |file: &[u8]| {
            let mut surveyor = Surveyor::new(true);
            read(&mut &*file, &mut surveyor).unwrap().notes
        };
        assert!(told(&file).is_empty());
        // The value: 1 becomes 3.
        let at = file.windows(4).position(|w| w == b"\":1}").unwrap() + 2;
        file[at] ^= 2;
        assert!(told(&file)[0].contains("checksum of the data is wrong"));
        // No sum, no judgement.
        let end = file.len() - 4;
        file[end..].fill(0);
        assert!(told(&file).is_empty());
    }
}
