//! The recording of a flight: an MCAP file that is written as it happens.
//!
//! | topic | content |
//! | --- | --- |
//! | `/received` | bytes as they arrived |
//! | `/tick` | nothing: a tick of the companion |
//! | `/camera` | news of the camera as JSON, which the replay reads too |
//! | `/camera/image` | images of the camera, if the settings ask for them |
//! | `/stop` | nothing: the companion was asked to end |
//! | `/sent` | the bytes that the companion sent upon the event before |
//! | `/mavlink/...` | the messages in those bytes, as JSON in SI units: for other readers, not for the replay |
//! | `/vehicle/pose`, `/phase`, … | the state of the flight ([`FlightState`](crate::companion::FlightState)), as JSON: for other readers, not for the replay |
//!
//! Times are those of the companion's clock, from its start. The metadata record `flight` holds the settings as TOML. No
//! message waits for a chunk, and the file is flushed twice a second: a kill loses at most the
//! messages since then.

mod reader;
mod recorder;
#[cfg(test)]
mod tests;

pub use reader::{Entry, Recording};
pub use recorder::{Recorder, Watcher};

/// Topics of the bytes.
const TOPICS: [&str; 5] = ["/received", "/tick", "/stop", "/sent", "/camera"];
const SENT: usize = 3;
const CAMERA: usize = 4;
/// Name of the metadata record, and of its entries beside the settings.
const FLIGHT: &str = "flight";
const TAKE_CONTROL: &str = "take_control";
const SET_PARAMETERS: &str = "set_parameters";
const SIGNED_LINK: &str = "signed_link";
const SIGNED_START: &str = "signed_start";
