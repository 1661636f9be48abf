//! The formats of logs with topics.
//!
//! Each is read by a module of its own, which ends in a [`Reader`]. A new format is such a module, and three
//! lines in this file: its `mod`, its [`LogFormat`] and its entry in [`READERS`].

mod bag;
mod channel;
mod clocks;
mod cursor;
mod dataflash;
mod lost;
mod mcap;
mod ros;
mod stream;
mod ulog;

use super::sink::{Loss, ReadError, Sink};
use serde::Serialize;
use std::io::Read;

pub use ulog::{UlogTopic, UlogWriter};

/// The formats of logs with topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum LogFormat {
    /// PX4's ULog.
    Ulog,
    /// ArduPilot's DataFlash log.
    DataFlash,
    /// MCAP, of ROS 1, ROS 2 or JSON.
    Mcap,
    /// A bag of ROS 1.
    Rosbag,
}

/// The reader of every format, in the order of [`LogFormat`].
static READERS: [Reader; 4] = [ulog::READER, dataflash::READER, mcap::READER, bag::READER];

/// Recognition and reading of the logs of a format.
pub(super) struct Reader {
    format: LogFormat,
    /// The format's usual name.
    pub(super) name: &'static str,
    /// The bytes with which its files begin.
    magic: &'static [u8],
    /// The event from which stamps count.
    pub(super) stamps_since: &'static str,
    /// Names of the built-in maps for its logs. The first that fits a log is taken.
    pub(super) maps: &'static [&'static str],
    /// Reads the whole log into a sink.
    pub(super) read: fn(&mut dyn Read, &mut dyn Sink) -> Result<Loss, ReadError>,
}

impl LogFormat {
    /// The format's usual name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.reader().name
    }

    /// The format of a file with these first bytes.
    #[must_use]
    pub fn of(start: &[u8]) -> Option<Self> {
        let reader = READERS.iter().find(|r| start.starts_with(r.magic))?;
        Some(reader.format)
    }

    pub(super) fn reader(self) -> &'static Reader {
        &READERS[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_format_has_its_reader() {
        for reader in &READERS {
            assert_eq!(reader.format.name(), reader.name);
            assert_eq!(LogFormat::of(reader.magic), Some(reader.format));
        }
    }
}
