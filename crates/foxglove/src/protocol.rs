//! Foxglove's WebSocket protocol, first version: JSON for control, binary for messages.
//!
//! Source: <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>. `foxglove.sdk.v1` is the same protocol under
//! its newer name.

use serde::Deserialize;
use serde_json::json;

use crate::Topic;

/// Names of the protocol, in the order of preference.
pub(crate) const NAMES: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// First byte of a binary message.
const MESSAGE_DATA: u8 = 1;

/// A request of a client. Others (parameters, services, publishing) are not offered, and are ignored.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum Request {
    #[serde(rename_all = "camelCase")]
    Subscribe { subscriptions: Vec<Subscription> },
    #[serde(rename_all = "camelCase")]
    Unsubscribe { subscription_ids: Vec<u32> },
}

/// A subscription, by the client's own number for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    pub(crate) id: u32,
    /// Number of the topic.
    pub(crate) channel_id: u64,
}

/// The first message to a client.
pub(crate) fn server_info(name: &str) -> String {
    json!({ "op": "serverInfo", "name": name, "capabilities": [] }).to_string()
}

/// The topics, numbered by their place.
pub(crate) fn advertise(topics: &[Topic]) -> String {
    let channels: Vec<_> = topics
        .iter()
        .enumerate()
        .map(|(id, topic)| {
            json!({
                "id": id,
                "topic": topic.name,
                "encoding": "json",
                "schemaName": topic.schema_name,
                "schemaEncoding": "jsonschema",
                "schema": topic.schema,
            })
        })
        .collect();
    json!({ "op": "advertise", "channels": channels }).to_string()
}

/// The bytes of a message for a subscription.
pub(crate) fn message_data(subscription: u32, time_ns: u64, message: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(13 + message.len());
    bytes.push(MESSAGE_DATA);
    bytes.extend_from_slice(&subscription.to_le_bytes());
    bytes.extend_from_slice(&time_ns.to_le_bytes());
    bytes.extend_from_slice(message);
    bytes
}
