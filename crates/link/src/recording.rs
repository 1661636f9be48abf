//! The recording of a flight: an MCAP file that is written as it happens.
//!
//! | topic | what it holds |
//! | --- | --- |
//! | `/received` | bytes as they arrived |
//! | `/tick` | nothing: a tick of the companion |
//! | `/camera` | news of the camera as JSON, which the replay reads too |
//! | `/camera/image` | images of the camera, if the settings ask for them |
//! | `/stop` | nothing: the companion was asked to end |
//! | `/sent` | the bytes that the companion sent upon the event before |
//! | `/mavlink/...` | what those bytes say, as JSON in SI units: for other readers, not for the replay |
//!
//! Times are those of the companion's clock, from its start. The metadata record `flight` holds the settings as TOML. No
//! message waits for a chunk, and the file is flushed twice a second: a process that is killed loses at most what came
//! since then.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use mavlink::dialects::common::MavMessage;
use mcap::read::{LinearReader, Options};
use mcap::records::{MessageHeader, Metadata, Record};
use mcap::{McapError, WriteOptions, Writer};

use crate::camera::CameraReport;
use crate::companion::{Event, Session};
use crate::decoded;
use crate::error::LinkError;
use crate::settings::FlightSettings;
use crate::wire::Decoder;
use crate::wire::signing::{Signing, SigningKey};

const TOPICS: [&str; 5] = ["/received", "/tick", "/stop", "/sent", "/camera"];
const SENT: usize = 3;
const CAMERA: usize = 4;
/// The objects of decoded topics have numbers only.
const SCHEMA: &[u8] =
    br#"{"type": "object", "additionalProperties": {"type": ["number", "null"]}}"#;
/// Topic of images, and their schema.
const IMAGES: &str = "/camera/image";
const IMAGE_SCHEMA: &[u8] = br#"{"title": "foxglove.CompressedImage", "type": "object", "properties": {"timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}, "frame_id": {"type": "string"}, "data": {"type": "string", "contentEncoding": "base64"}, "format": {"type": "string"}}}"#;
/// Time between two flushes, µs.
const FLUSH_US: u64 = 500_000;
/// Name of the metadata record, and of its entries beside the settings.
const FLIGHT: &str = "flight";
const TAKE_CONTROL: &str = "take_control";
const SET_PARAMETERS: &str = "set_parameters";
const SIGNED_LINK: &str = "signed_link";
const SIGNED_START: &str = "signed_start";

/// Writes a recording.
pub struct Recorder {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; TOPICS.len()],
    decoded: [u16; decoded::TOPICS.len()],
    /// Channel of images, once there is one.
    images: Option<u16>,
    /// Decoders of what came and of what went.
    decoders: [Decoder; 2],
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
        session: &Session,
    ) -> Result<Self, LinkError> {
        let failed = |reason: String| LinkError::Recording {
            path: path.to_owned(),
            reason,
        };
        let file = File::create(path).map_err(|e| failed(e.to_string()))?;
        let text = toml::to_string(settings).map_err(|e| failed(e.to_string()))?;
        // The key is a secret; the rest is needed to make the same signatures again.
        let signed = session.signing.map_or_else(Default::default, |signing| {
            (signing.link_id.to_string(), signing.start.to_string())
        });
        let open = || -> Result<_, McapError> {
            let mut writer = WriteOptions::new()
                .use_chunks(false)
                .compression(None)
                .library(concat!("touchdown ", env!("CARGO_PKG_VERSION")))
                .create(BufWriter::new(file))?;
            let metadata = [
                ("settings".to_string(), text),
                (TAKE_CONTROL.to_string(), session.take_control.to_string()),
                (
                    SET_PARAMETERS.to_string(),
                    session.set_parameters.to_string(),
                ),
                (SIGNED_LINK.to_string(), signed.0),
                (SIGNED_START.to_string(), signed.1),
            ];
            writer.write_metadata(&Metadata {
                name: FLIGHT.to_string(),
                metadata: metadata.into(),
            })?;
            let mut channels = [0; TOPICS.len()];
            for (channel, topic) in channels.iter_mut().zip(TOPICS) {
                let encoding = if topic == TOPICS[CAMERA] {
                    "json"
                } else {
                    "mavlink"
                };
                *channel = writer.add_channel(0, topic, encoding, &BTreeMap::new())?;
            }
            let schema = writer.add_schema("touchdown.Mavlink", "jsonschema", SCHEMA)?;
            let mut decoded = [0; decoded::TOPICS.len()];
            for (channel, topic) in decoded.iter_mut().zip(decoded::TOPICS) {
                *channel = writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
            }
            writer.flush()?;
            Ok((writer, channels, decoded))
        };
        let (writer, channels, decoded) = open().map_err(|e| failed(e.to_string()))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels,
            decoded,
            images: None,
            decoders: Default::default(),
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
            self.explain(at_us, 0, bytes)?;
        }
        self.explain(at_us, 1, sent)?;
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
            "timestamp": {"sec": at_us / 1_000_000, "nsec": at_us % 1_000_000 * 1000},
            "frame_id": "camera",
            "data": BASE64_STANDARD.encode(png),
            "format": "png",
        });
        self.message(at_us, channel, image.to_string().as_bytes())
    }

    /// Writes what bytes say that came (0) or went (1).
    fn explain(&mut self, at_us: u64, way: usize, bytes: &[u8]) -> Result<(), McapError> {
        self.decoders[way].push(bytes);
        while let Some(frame) = self.decoders[way].next_frame() {
            // Our own heartbeat and those of other companions are not the vehicle's.
            let heartbeat = matches!(frame.message, MavMessage::HEARTBEAT(_));
            if heartbeat && (way == 1 || frame.component != 1) {
                continue;
            }
            if let Some((topic, object)) = decoded::decoded(&frame.message) {
                let text = object.to_string();
                self.message(at_us, self.decoded[topic], text.as_bytes())?;
            }
        }
        Ok(())
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
            reason: error.to_string(),
        }
    }
}

/// An entry of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// Bytes that arrived.
    Received(Vec<u8>),
    /// A tick.
    Tick,
    /// News of the camera.
    Camera(CameraReport),
    /// A request to end.
    Stop,
    /// Bytes that were sent upon the event before.
    Sent(Vec<u8>),
}

/// A recording that was read.
#[derive(Clone, Debug)]
pub struct Recording {
    path: PathBuf,
    /// Settings of the flight.
    pub settings: FlightSettings,
    /// What the operator allowed, without signing.
    unsigned: Session,
    /// Id of the signed link and time of its start, if the link was signed.
    signed: Option<(u8, u64)>,
    /// Times, µs, and entries.
    pub entries: Vec<(u64, Entry)>,
    /// Whether the file has no end, as after a kill.
    pub cut_off: bool,
}

impl Recording {
    /// What the operator allowed.
    ///
    /// # Errors
    /// A signed link whose key is not given.
    pub fn session(&self, key: Option<SigningKey>) -> Result<Session, LinkError> {
        let signing = match (self.signed, key) {
            (None, _) => None,
            (Some((link_id, start)), Some(key)) => Some(Signing {
                key,
                link_id,
                start,
            }),
            (Some(_), None) => {
                return Err(LinkError::Recording {
                    path: self.path.clone(),
                    reason: "the link was signed: `signing.key_file` must name the key".to_string(),
                });
            }
        };
        Ok(Session {
            signing,
            ..self.unsigned
        })
    }

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
                        Some(CAMERA) => match CameraReport::from_json(&data) {
                            Some(report) => Entry::Camera(report),
                            None => continue,
                        },
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
            unsigned: Session {
                take_control: of(TAKE_CONTROL) == "true",
                set_parameters: of(SET_PARAMETERS) == "true",
                signing: None,
            },
            signed: of(SIGNED_LINK)
                .parse()
                .ok()
                .zip(of(SIGNED_START).parse().ok()),
            path: path.to_owned(),
            entries,
            cut_off,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Encoder;
    use mavlink::dialects::common::{ATTITUDE_QUATERNION_DATA, HIGHRES_IMU_DATA};

    /// Bytes of a reading of the inertial unit and an attitude.
    fn bytes() -> Vec<u8> {
        let (mut encoder, mut bytes) = (Encoder::new(7, 1), Vec::new());
        let attitude = ATTITUDE_QUATERNION_DATA {
            q1: 1.0,
            ..ATTITUDE_QUATERNION_DATA::default()
        };
        encoder.write(&MavMessage::ATTITUDE_QUATERNION(attitude), &mut bytes);
        let imu = HIGHRES_IMU_DATA {
            zacc: -9.75,
            ..HIGHRES_IMU_DATA::default()
        };
        encoder.write(&MavMessage::HIGHRES_IMU(imu), &mut bytes);
        bytes
    }

    #[test]
    fn prop_a_recording_comes_back_and_says_what_its_bytes_say() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.mcap");
        let session = Session {
            set_parameters: true,
            ..Session::default()
        };
        let settings = FlightSettings::default();
        let mut recorder = Recorder::create(&path, &settings, &session).unwrap();
        let bytes = bytes();
        recorder
            .write(10, Event::Received(&bytes), b"answer")
            .unwrap();
        recorder.write(20, Event::Tick, &[]).unwrap();
        recorder.write(30, Event::Stop, &[]).unwrap();
        recorder.finish().unwrap();
        let read = Recording::read(&path).unwrap();
        let expected = vec![
            (10, Entry::Received(bytes)),
            (10, Entry::Sent(b"answer".to_vec())),
            (20, Entry::Tick),
            (30, Entry::Stop),
        ];
        assert_eq!((read.entries, read.cut_off), (expected, false));
        assert_eq!((read.settings, read.unsigned), (settings, session));
        let whole = std::fs::read(&path).unwrap();
        let force = br#""specific_force_z_mps2":-9.75"#;
        assert!(whole.windows(force.len()).any(|part| part == force));
    }

    #[test]
    fn prop_a_recording_that_is_cut_anywhere_is_read_as_far_as_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.mcap");
        let settings = FlightSettings::default();
        let mut recorder = Recorder::create(&path, &settings, &Session::default()).unwrap();
        let begins = std::fs::metadata(&path).unwrap().len() as usize;
        for tick in 0..40 {
            recorder
                .write(tick, Event::Received(&bytes()), &[])
                .unwrap();
        }
        recorder.finish().unwrap();
        let whole = std::fs::read(&path).unwrap();
        let mut before = 0;
        for length in (begins..whole.len()).step_by(97) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let read = Recording::read(&path).unwrap();
            assert!(read.entries.len() >= before && read.entries.len() <= 40);
            before = read.entries.len();
        }
        assert_eq!(before, 40);
    }
}
