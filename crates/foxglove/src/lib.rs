//! Messages of Foxglove as JSON, and a live view over its WebSocket protocol.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`messages`] | poses, transforms, time stamps and JSON schemas, as MCAP files and the live view contain them |
//! | [`server`] | the live view: topics go to every client that subscribes |
//!
//! The server reads no clock and starts no thread: its caller passes the time.
#![forbid(unsafe_code)]

mod client;
pub mod messages;
mod protocol;
pub mod server;

/// A topic with its JSON schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Name, as `/vehicle/pose`.
    pub name: String,
    /// Name of the schema, as `foxglove.PoseInFrame`.
    pub schema_name: String,
    /// The JSON schema.
    pub schema: String,
}
