//! The formats of logs with topics: each is read by a module of its own.

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

impl LogFormat {
    /// The format's usual name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ulog => "PX4 ULog",
            Self::DataFlash => "ArduPilot DataFlash log",
            Self::Mcap => "MCAP recording",
            Self::Rosbag => "ROS 1 bag",
        }
    }

    /// What stamps count from.
    pub(super) const fn zero(self) -> &'static str {
        match self {
            Self::Ulog => "the start of the log",
            Self::DataFlash => "the start of the vehicle",
            Self::Mcap | Self::Rosbag => "the first message",
        }
    }

    /// The format of a file that starts so.
    #[must_use]
    pub fn of(start: &[u8]) -> Option<Self> {
        if start.starts_with(&ulog::MAGIC) {
            Some(Self::Ulog)
        } else if start.starts_with(&dataflash::MAGIC) {
            Some(Self::DataFlash)
        } else if start.starts_with(&mcap::MAGIC) {
            Some(Self::Mcap)
        } else if start.starts_with(&bag::MAGIC) {
            Some(Self::Rosbag)
        } else {
            None
        }
    }
}

/// Reads a whole log of this format.
pub(super) fn read(
    format: LogFormat,
    input: &mut impl Read,
    sink: &mut dyn Sink,
) -> Result<Loss, ReadError> {
    match format {
        LogFormat::Ulog => ulog::read(input, sink),
        LogFormat::DataFlash => dataflash::read(input, sink),
        LogFormat::Mcap => mcap::read(input, sink),
        LogFormat::Rosbag => bag::read(input, sink),
    }
}
