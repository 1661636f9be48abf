//! Interface between the readers of logs and their sinks, for all formats.

use super::LogFormat;
use crate::limits::Excess;

/// A topic of a log, as a reader announces it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    pub(crate) name: String,
    /// The type of its messages, such as `sensor_msgs/Imu`; empty if the format states none.
    pub(crate) kind: String,
    /// Number of the source among those of one kind.
    pub(crate) instance: u32,
    /// Names of the fields that hold numbers.
    pub(crate) fields: Vec<String>,
    /// Names of the fields that hold text.
    pub(crate) texts: Vec<String>,
}

/// Data of a topic that a sink requests.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// No data.
    Nothing,
    /// Only the stamps of its messages.
    Stamps,
    /// Stamps and the values of these fields, in this order.
    Fields(Vec<usize>),
}

/// The name of a type as ROS 1 has it: `sensor_msgs/Imu` for `sensor_msgs/msg/Imu`.
pub(super) fn short_kind(kind: &str) -> String {
    kind.replacen("/msg/", "/", 1)
}

/// Receives the content of a log from its reader, in the order of the file.
pub(crate) trait Sink {
    /// A topic, before its first message, and again whenever it has new fields. `id` counts topics
    /// from 0.
    fn topic(&mut self, id: usize, layout: &Layout) -> Wanted;
    /// A message with its stamp in ns since the log's own zero, and the requested values.
    fn message(&mut self, id: usize, stamp_ns: Option<i64>, values: &[f64]);
    /// Shifts the stamps of all messages of these topics since their last shift.
    fn shift(&mut self, ids: &[usize], by_ns: i64);
    /// A parameter of the vehicle.
    fn parameter(&mut self, name: &str, value: f64);
    /// What the log asks for beyond a limit of the sink. A reader asks after each record, and ends.
    fn excess(&self) -> Option<Excess> {
        None
    }
}

/// Data that a reader could not read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Loss {
    /// Whether the file ends inside a record.
    pub(crate) truncated: bool,
    /// Number of damaged sections: bytes that are not records.
    pub(crate) corrupt: usize,
    /// Bytes in damaged sections, and in the incomplete last record.
    pub(crate) skipped_bytes: u64,
    /// Messages that do not fit their definition.
    pub(crate) undecodable: usize,
    /// Further warnings, one sentence each.
    pub(crate) notes: Vec<String>,
}

/// Largest number of stored sentences, so that the report of a damaged file stays readable.
const MOST_NOTES: usize = 32;

impl Loss {
    /// Stores a sentence, unless there are too many.
    pub(crate) fn note(&mut self, text: String) {
        match self.notes.len() {
            ..MOST_NOTES => self.notes.push(text),
            MOST_NOTES => self
                .notes
                .push("further messages of this kind were omitted".to_owned()),
            _ => {}
        }
    }
}

/// Error of a reader.
#[derive(Debug)]
pub(crate) enum ReadError {
    Io(std::io::Error),
    /// The file is not of this format, or contains none of its records.
    Broken(String),
    /// The file asks for more than a reader takes.
    Excess(Excess),
}

impl From<Excess> for ReadError {
    fn from(excess: Excess) -> Self {
        Self::Excess(excess)
    }
}

impl From<std::io::Error> for ReadError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl ReadError {
    pub(crate) fn broken(format: LogFormat, what: &str) -> Self {
        Self::Broken(format!("{} {what}", format.name()))
    }
}

/// A number as it lies in a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    pub(crate) const fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number that starts at `at`; NaN if the bytes end before.
    #[inline]
    pub(crate) fn read(self, bytes: &[u8], at: usize) -> f64 {
        fn take<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
            bytes.get(at..at.checked_add(N)?)?.try_into().ok()
        }
        let value = match self {
            Self::Bool => bytes.get(at).map(|&b| f64::from(u8::from(b != 0))),
            Self::U8 => bytes.get(at).map(|&b| f64::from(b)),
            Self::I8 => take(bytes, at).map(|b| f64::from(i8::from_le_bytes(b))),
            Self::I16 => take(bytes, at).map(|b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => take(bytes, at).map(|b| f64::from(u16::from_le_bytes(b))),
            Self::I32 => take(bytes, at).map(|b| f64::from(i32::from_le_bytes(b))),
            Self::U32 => take(bytes, at).map(|b| f64::from(u32::from_le_bytes(b))),
            Self::I64 => take(bytes, at).map(|b| i64::from_le_bytes(b) as f64),
            Self::U64 => take(bytes, at).map(|b| u64::from_le_bytes(b) as f64),
            Self::F32 => take(bytes, at).map(|b| f64::from(f32::from_le_bytes(b))),
            Self::F64 => take(bytes, at).map(f64::from_le_bytes),
        };
        value.unwrap_or(f64::NAN)
    }

    /// Writes the number at the start of `bytes`, rounded and clamped to what fits.
    pub(crate) fn write(self, bytes: &mut [u8], value: f64) {
        let eight: [u8; 8] = match self {
            Self::F64 => value.to_le_bytes(),
            Self::F32 => u64::from((value as f32).to_bits()).to_le_bytes(),
            Self::U64 => (value.round() as u64).to_le_bytes(),
            Self::U32 => u64::from(value.round() as u32).to_le_bytes(),
            Self::U16 => u64::from(value.round() as u16).to_le_bytes(),
            Self::U8 => u64::from(value.round() as u8).to_le_bytes(),
            Self::Bool => u64::from(value != 0.0).to_le_bytes(),
            Self::I64 => (value.round() as i64).to_le_bytes(),
            Self::I32 => i64::from(value.round() as i32).to_le_bytes(),
            Self::I16 => i64::from(value.round() as i16).to_le_bytes(),
            Self::I8 => i64::from(value.round() as i8).to_le_bytes(),
        };
        let size = self.size().min(bytes.len());
        bytes[..size].copy_from_slice(&eight[..size]);
    }
}
