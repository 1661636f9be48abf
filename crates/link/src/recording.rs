//! The recording of a flight: an MCAP file that is written as it happens.
//!
//! | topic | what it holds |
//! | --- | --- |
//! | `/received` | bytes as they arrived |
//! | `/tick` | nothing: a tick of the companion |
//! | `/stop` | nothing: the companion was asked to end |
//! | `/sent` | the bytes that the companion sent upon the event before |
//!
//! Times are those of the companion's clock, from its start. The metadata record `flight` holds the settings as TOML. No
//! message waits for a chunk, and the file is flushed twice a second: a process that is killed loses at most what came
//! since then.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::read::{LinearReader, Options};
use mcap::records::{MessageHeader, Metadata, Record};
use mcap::{McapError, WriteOptions, Writer};

use crate::companion::Event;
use crate::error::LinkError;
use crate::settings::FlightSettings;

const TOPICS: [&str; 4] = ["/received", "/tick", "/stop", "/sent"];
const SENT: usize = 3;
/// Time between two flushes, µs.
const FLUSH_US: u64 = 500_000;
/// Name of the metadata record.
const FLIGHT: &str = "flight";

/// Writes a recording.
pub struct Recorder {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; 4],
    sequence: u32,
    flushed_us: u64,
}

impl Recorder {
    /// Creates the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(
        path: &Path,
        settings: &FlightSettings,
        take_control: bool,
    ) -> Result<Self, LinkError> {
        let failed = |reason: String| LinkError::Recording {
            path: path.to_owned(),
            reason,
        };
        let file = File::create(path).map_err(|e| failed(e.to_string()))?;
        let text = toml::to_string(settings).map_err(|e| failed(e.to_string()))?;
        let open = || -> Result<_, McapError> {
            let mut writer = WriteOptions::new()
                .use_chunks(false)
                .compression(None)
                .library(concat!("touchdown ", env!("CARGO_PKG_VERSION")))
                .create(BufWriter::new(file))?;
            let metadata = [
                ("settings".to_string(), text),
                ("take_control".to_string(), take_control.to_string()),
            ];
            writer.write_metadata(&Metadata {
                name: FLIGHT.to_string(),
                metadata: metadata.into(),
            })?;
            let mut channels = [0; 4];
            for (channel, topic) in channels.iter_mut().zip(TOPICS) {
                *channel = writer.add_channel(0, topic, "mavlink", &BTreeMap::new())?;
            }
            writer.flush()?;
            Ok((writer, channels))
        };
        let (writer, channels) = open().map_err(|e| failed(e.to_string()))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels,
            sequence: 0,
            flushed_us: 0,
        })
    }

    /// Writes an event, and what was sent upon it.
    ///
    /// # Errors
    /// A file that cannot be written, as on a full disk.
    pub fn write(&mut self, at_us: u64, event: Event<'_>, sent: &[u8]) -> Result<(), LinkError> {
        self.put(at_us, event, sent).map_err(|e| self.failed(&e))
    }

    fn put(&mut self, at_us: u64, event: Event<'_>, sent: &[u8]) -> Result<(), McapError> {
        let (topic, bytes): (usize, &[u8]) = match event {
            Event::Received(bytes) => (0, bytes),
            Event::Tick => (1, &[]),
            Event::Stop => (2, &[]),
        };
        self.message(at_us, topic, bytes)?;
        if !sent.is_empty() {
            self.message(at_us, SENT, sent)?;
        }
        if at_us.saturating_sub(self.flushed_us) >= FLUSH_US {
            self.flushed_us = at_us;
            self.writer.flush()?;
        }
        Ok(())
    }

    fn message(&mut self, at_us: u64, topic: usize, bytes: &[u8]) -> Result<(), McapError> {
        let time_ns = at_us.saturating_mul(1000);
        let header = MessageHeader {
            channel_id: self.channels[topic],
            sequence: self.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, bytes)
    }

    /// Writes the summary of the file and closes it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(), LinkError> {
        let finished = self.writer.finish().map(|_| ());
        finished.map_err(|e| self.failed(&e))
    }

    fn failed(&self, error: &McapError) -> LinkError {
        LinkError::Recording {
            path: self.path.clone(),
            reason: error.to_string(),
        }
    }
}

/// An entry of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Bytes that arrived.
    Received(Vec<u8>),
    /// A tick.
    Tick,
    /// A request to end.
    Stop,
    /// Bytes that were sent upon the event before.
    Sent(Vec<u8>),
}

/// A recording that was read.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Settings of the flight.
    pub settings: FlightSettings,
    /// Whether the companion switched the mode itself.
    pub take_control: bool,
    /// Times, µs, and entries.
    pub entries: Vec<(u64, Entry)>,
    /// Whether the file has no end, as after a kill.
    pub cut_off: bool,
}

impl Recording {
    /// Reads a recording. One without an end is read as far as it goes.
    ///
    /// # Errors
    /// A file that cannot be read, or is no recording of a flight.
    pub fn read(path: &Path) -> Result<Self, LinkError> {
        let failed = |reason: String| LinkError::Recording {
            path: path.to_owned(),
            reason,
        };
        let bytes = std::fs::read(path).map_err(|e| failed(e.to_string()))?;
        let records = LinearReader::new_with_options(&bytes, Options::IgnoreEndMagic.into())
            .map_err(|e| failed(e.to_string()))?;
        let mut flight = None;
        let mut topics = BTreeMap::new();
        let mut entries = Vec::new();
        let mut cut_off = true;
        for record in records {
            // Whatever follows a record that is not whole was not written whole either.
            let Ok(record) = record else { break };
            match record {
                Record::Metadata(metadata) if metadata.name == FLIGHT => flight = Some(metadata),
                Record::Channel(channel) => {
                    let topic = TOPICS.iter().position(|topic| *topic == channel.topic);
                    topics.insert(channel.id, topic);
                }
                Record::Message { header, data } => {
                    let entry = match topics.get(&header.channel_id).copied().flatten() {
                        Some(0) => Entry::Received(data.to_vec()),
                        Some(1) => Entry::Tick,
                        Some(2) => Entry::Stop,
                        Some(SENT) => Entry::Sent(data.to_vec()),
                        _ => continue,
                    };
                    entries.push((header.log_time / 1000, entry));
                }
                Record::DataEnd(_) => cut_off = false,
                _ => {}
            }
        }
        let flight =
            flight.ok_or_else(|| failed("this is no recording of `touchdown fly`".to_string()))?;
        let of = |key: &str| {
            flight
                .metadata
                .get(key)
                .map(String::as_str)
                .unwrap_or_default()
        };
        Ok(Self {
            settings: toml::from_str(of("settings")).map_err(|e| failed(e.to_string()))?,
            take_control: of("take_control") == "true",
            entries,
            cut_off,
        })
    }
}
