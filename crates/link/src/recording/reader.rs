//! Reading a recording.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, McapResult, parse_record};

use super::{
    CAMERA, FLIGHT, SENT, SET_PARAMETERS, SIGNED_LINK, SIGNED_START, TAKE_CONTROL, TOPICS,
};
use crate::camera::CameraReport;
use crate::companion::Session;
use crate::error::LinkError;
use crate::settings::FlightSettings;
use crate::wire::signing::{Signing, SigningKey};

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
    /// The operator's permissions, without signing.
    pub(super) unsigned: Session,
    /// Id of the signed link and time of its start, if the link was signed.
    signed: Option<(u8, u64)>,
    /// Times, µs, and entries.
    pub entries: Vec<(u64, Entry)>,
    /// Whether the file has no end, as after a kill.
    pub cut_off: bool,
}

/// The records of a file, whose sum is checked at the end of the data.
struct Records<'a> {
    rest: &'a [u8],
    reader: LinearReader,
}

impl<'a> Records<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(bytes.len())
            .with_skip_end_magic(true)
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true);
        Self {
            rest: bytes,
            reader: LinearReader::new_with_options(options),
        }
    }

    fn next(&mut self) -> McapResult<Option<Record<'static>>> {
        while let Some(event) = self.reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(need) => {
                    let (now, rest) = self.rest.split_at(need.min(self.rest.len()));
                    self.reader.insert(now.len()).copy_from_slice(now);
                    self.reader.notify_read(now.len());
                    self.rest = rest;
                }
                LinearReadEvent::Record { opcode, data } => {
                    return Ok(Some(parse_record(opcode, data)?.into_owned()));
                }
            }
        }
        Ok(None)
    }
}

impl Recording {
    /// The operator's permissions.
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
    /// A file that cannot be read, is no recording of a flight, or has an end but other bytes than were written.
    pub fn read(path: &Path) -> Result<Self, LinkError> {
        let failed = |reason: String| LinkError::Recording {
            path: path.to_owned(),
            reason,
        };
        let bytes = std::fs::read(path).map_err(|e| failed(e.to_string()))?;
        let mut records = Records::of(&bytes);
        let mut flight = None;
        let mut topics = BTreeMap::new();
        let mut entries = Vec::new();
        let mut cut_off = true;
        loop {
            let record = match records.next() {
                Ok(Some(record)) => record,
                Ok(None) => break,
                // The index behind the end of the data is not needed.
                Err(_) if !cut_off => break,
                // A kill ends the file within a record. Whatever follows was not written either.
                Err(McapError::UnexpectedEof) if !bytes.ends_with(MAGIC) => break,
                Err(error) => {
                    return Err(failed(format!(
                        "expected the bytes that the flight wrote, found a damaged file: {error}"
                    )));
                }
            };
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
