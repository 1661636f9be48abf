//! Writing a recording.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use mavlink::dialects::common::MavMessage;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use serde_json::Value;
use touchdown_foxglove::Topic;
use touchdown_foxglove::messages::stamp;

use super::{
    CAMERA, FLIGHT, SENT, SET_PARAMETERS, SIGNED_LINK, SIGNED_START, TAKE_CONTROL, TOPICS,
};
use crate::checklist::Checklist;
use crate::companion::{Event, FlightState, Session, state};
use crate::decoded;
use crate::error::LinkError;
use crate::settings::FlightSettings;
use crate::wire::Decoder;

/// Topic of images, and their schema.
const IMAGES: &str = "/camera/image";
const IMAGE_SCHEMA: &[u8] = br#"{"title": "foxglove.CompressedImage", "type": "object", "properties": {"timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}, "frame_id": {"type": "string"}, "data": {"type": "string", "contentEncoding": "base64"}, "format": {"type": "string"}}}"#;
/// Time between two flushes, µs.
const FLUSH_US: u64 = 500_000;

/// Gets each JSON message as it is written: place of its topic in [`Recorder::topics`], time in ns, and the message.
pub type Watcher = Box<dyn FnMut(usize, u64, &[u8]) + Send>;

/// Writes a recording.
pub struct Recorder {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; TOPICS.len()],
    /// Channels of the topics with JSON.
    json: Vec<u16>,
    /// Channel of images, once there is one.
    images: Option<u16>,
    /// Decoders of received and of sent bytes.
    decoders: [Decoder; 2],
    watcher: Option<Watcher>,
    sequence: u32,
    flushed_us: u64,
}

/// Metadata of the flight: settings, and the operator's permissions.
fn metadata(settings: &FlightSettings, session: &Session) -> Result<Metadata, toml::ser::Error> {
    // The key is a secret; the rest is needed to make the same signatures again.
    let signed = session.signing.map_or_else(Default::default, |signing| {
        (signing.link_id.to_string(), signing.start.to_string())
    });
    let entries = [
        ("settings", toml::to_string(settings)?),
        (TAKE_CONTROL, session.take_control.to_string()),
        (SET_PARAMETERS, session.set_parameters.to_string()),
        (SIGNED_LINK, signed.0),
        (SIGNED_START, signed.1),
    ];
    Ok(Metadata {
        name: FLIGHT.to_string(),
        metadata: entries.map(|(key, value)| (key.to_string(), value)).into(),
    })
}

/// Opens a file that no other recorder writes, and empties it. Its lock ends with the process.
fn own(path: &Path) -> std::io::Result<File> {
    let file = File::options()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)?;
    // Not every file system has locks.
    if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        let taken = "another flight writes this file: give each its own `--out`";
        return Err(std::io::Error::other(taken));
    }
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    Ok(file)
}

impl Recorder {
    /// The topics with JSON: decoded messages, then the state of the flight.
    #[must_use]
    pub fn topics() -> Vec<Topic> {
        decoded::topics().chain(state::topics()).collect()
    }

    /// Creates the file.
    ///
    /// # Errors
    /// A file that cannot be written, or that another flight writes.
    pub fn create(
        path: &Path,
        settings: &FlightSettings,
        session: &Session,
    ) -> Result<Self, LinkError> {
        let failed = |reason: String| LinkError::Recording {
            path: path.to_owned(),
            reason,
        };
        let file = own(path).map_err(|e| failed(e.to_string()))?;
        let metadata = metadata(settings, session).map_err(|e| failed(e.to_string()))?;
        let open = || -> Result<_, McapError> {
            let mut writer = WriteOptions::new()
                .use_chunks(false)
                .compression(None)
                .library(concat!("touchdown ", env!("CARGO_PKG_VERSION")))
                .create(BufWriter::new(file))?;
            writer.write_metadata(&metadata)?;
            let mut channels = [0; TOPICS.len()];
            for (channel, topic) in channels.iter_mut().zip(TOPICS) {
                let encoding = if topic == TOPICS[CAMERA] {
                    "json"
                } else {
                    "mavlink"
                };
                *channel = writer.add_channel(0, topic, encoding, &BTreeMap::new())?;
            }
            let mut json = Vec::new();
            for Topic {
                name,
                schema_name,
                schema,
            } in Self::topics()
            {
                let schema = writer.add_schema(&schema_name, "jsonschema", schema.as_bytes())?;
                json.push(writer.add_channel(schema, &name, "json", &BTreeMap::new())?);
            }
            writer.flush()?;
            Ok((writer, channels, json))
        };
        let (writer, channels, json) = open().map_err(|e| failed(e.to_string()))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels,
            json,
            images: None,
            decoders: Default::default(),
            watcher: None,
            sequence: 0,
            flushed_us: 0,
        })
    }

    /// Passes each JSON message to a watcher as well.
    #[must_use]
    pub fn watched_by(mut self, watcher: Option<Watcher>) -> Self {
        self.watcher = watcher;
        self
    }

    /// Writes an event, and the bytes that it caused to be sent.
    ///
    /// # Errors
    /// A file that cannot be written, as on a full disk.
    pub fn write(&mut self, at_us: u64, event: Event<'_>, sent: &[u8]) -> Result<(), LinkError> {
        self.put(at_us, event, sent).map_err(|e| self.failed(&e))
    }

    fn put(&mut self, at_us: u64, event: Event<'_>, sent: &[u8]) -> Result<(), McapError> {
        match event {
            Event::Received(bytes) => self.message(at_us, self.channels[0], bytes)?,
            Event::Tick => self.message(at_us, self.channels[1], &[])?,
            Event::Stop => self.message(at_us, self.channels[2], &[])?,
            Event::Camera(report) => {
                let text = report.to_json();
                self.message(at_us, self.channels[CAMERA], text.as_bytes())?;
            }
        }
        if !sent.is_empty() {
            self.message(at_us, self.channels[SENT], sent)?;
        }
        if let Event::Received(bytes) = event {
            self.decode(at_us, 0, bytes)?;
        }
        self.decode(at_us, 1, sent)?;
        if at_us.saturating_sub(self.flushed_us) >= FLUSH_US {
            self.flushed_us = at_us;
            self.writer.flush()?;
        }
        Ok(())
    }

    /// Writes an image of the camera, the bytes of a PNG file, as `foxglove.CompressedImage`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_image(&mut self, at_us: u64, png: &[u8]) -> Result<(), LinkError> {
        self.put_image(at_us, png).map_err(|e| self.failed(&e))
    }

    fn put_image(&mut self, at_us: u64, png: &[u8]) -> Result<(), McapError> {
        let channel = match self.images {
            Some(channel) => channel,
            None => {
                let writer = &mut self.writer;
                let schema =
                    writer.add_schema("foxglove.CompressedImage", "jsonschema", IMAGE_SCHEMA)?;
                writer.add_channel(schema, IMAGES, "json", &BTreeMap::new())?
            }
        };
        self.images = Some(channel);
        let image = serde_json::json!({
            "timestamp": stamp(at_us.saturating_mul(1000)),
            "frame_id": "camera",
            "data": BASE64_STANDARD.encode(png),
            "format": "png",
        });
        self.message(at_us, channel, image.to_string().as_bytes())
    }

    /// Writes the messages in bytes that were received (0) or sent (1).
    fn decode(&mut self, at_us: u64, way: usize, bytes: &[u8]) -> Result<(), McapError> {
        self.decoders[way].push(bytes);
        while let Some(frame) = self.decoders[way].next_frame() {
            // Our own heartbeat and those of other companions are not the vehicle's.
            let heartbeat = matches!(frame.message, MavMessage::HEARTBEAT(_));
            if heartbeat && (way == 1 || frame.component != 1) {
                continue;
            }
            if let Some((topic, object)) = decoded::decoded(&frame.message) {
                self.json(at_us, topic, &object)?;
            }
        }
        Ok(())
    }

    /// Writes the state of the flight.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_state(&mut self, state: &FlightState) -> Result<(), LinkError> {
        let mut messages = Vec::new();
        state.messages(|place, message| messages.push((place, message)));
        let at_us = state.time_us();
        messages
            .iter()
            .try_for_each(|(place, message)| {
                self.json(at_us, decoded::TOPICS.len() + place, message)
            })
            .map_err(|e| self.failed(&e))
    }

    /// Writes the checklist.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_checklist(&mut self, at_us: u64, list: &Checklist) -> Result<(), LinkError> {
        let (place, message) = state::checklist(at_us, list);
        self.json(at_us, decoded::TOPICS.len() + place, &message)
            .map_err(|e| self.failed(&e))
    }

    fn json(&mut self, at_us: u64, topic: usize, message: &Value) -> Result<(), McapError> {
        let text = message.to_string();
        if let Some(watcher) = &mut self.watcher {
            watcher(topic, at_us.saturating_mul(1000), text.as_bytes());
        }
        self.message(at_us, self.json[topic], text.as_bytes())
    }

    fn message(&mut self, at_us: u64, channel_id: u16, bytes: &[u8]) -> Result<(), McapError> {
        let time_ns = at_us.saturating_mul(1000);
        let header = MessageHeader {
            channel_id,
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
            reason: match error {
                // What the system says: a disk that is full, say.
                McapError::Io(error) => error.to_string(),
                error => error.to_string(),
            },
        }
    }
}
