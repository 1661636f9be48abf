//! Messages as JSON. Positions are in m, quaternions are (w, x, y, z), times are in ns.

use serde_json::{Value, json};

const SECOND_NS: u64 = 1_000_000_000;

/// Name of the schema of [`pose`].
pub const POSE: &str = "foxglove.PoseInFrame";
/// Name of the schema of [`transform`].
pub const TRANSFORM: &str = "foxglove.FrameTransform";

/// A time stamp.
#[must_use]
pub fn stamp(time_ns: u64) -> Value {
    json!({ "sec": time_ns / SECOND_NS, "nsec": time_ns % SECOND_NS })
}

/// The header of a ROS 2 message.
#[must_use]
pub fn header(time_ns: u64, frame: &str) -> Value {
    json!({
        "stamp": { "sec": time_ns / SECOND_NS, "nanosec": time_ns % SECOND_NS },
        "frame_id": frame,
    })
}

/// A vector.
#[must_use]
pub fn xyz([x, y, z]: [f64; 3]) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

/// A quaternion.
#[must_use]
pub fn quaternion([w, x, y, z]: [f64; 4]) -> Value {
    json!({ "x": x, "y": y, "z": z, "w": w })
}

/// A pose in a frame.
#[must_use]
pub fn pose(time_ns: u64, frame: &str, position_m: [f64; 3], attitude: [f64; 4]) -> Value {
    json!({
        "timestamp": stamp(time_ns),
        "frame_id": frame,
        "pose": { "position": xyz(position_m), "orientation": quaternion(attitude) },
    })
}

/// The transform from a frame to its child.
#[must_use]
pub fn transform(
    time_ns: u64,
    [parent, child]: [&str; 2],
    translation_m: [f64; 3],
    rotation: [f64; 4],
) -> Value {
    json!({
        "timestamp": stamp(time_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": xyz(translation_m),
        "rotation": quaternion(rotation),
    })
}

/// Estimate of the vehicle's motion relative to the deck, and the controller's target (height, vertical velocity).
#[must_use]
pub fn estimate(
    time_ns: u64,
    [position_m, velocity_mps, position_sd_m]: [[f64; 3]; 3],
    target: Option<[f64; 2]>,
) -> Value {
    json!({
        "timestamp": stamp(time_ns),
        "position_m": xyz(position_m),
        "velocity_mps": xyz(velocity_mps),
        "position_sd_m": xyz(position_sd_m),
        "target_height_m": target.map(|t| t[0]),
        "target_velocity_mps": target.map(|t| t[1]),
    })
}

/// A message without the keys that have no value (`null`). Its schema says that they are numbers or texts, and a key may
/// be absent.
#[must_use]
pub fn present(message: Value) -> Value {
    match message {
        Value::Object(keys) => keys
            .into_iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| (key, present(value)))
            .collect(),
        Value::Array(items) => items.into_iter().map(present).collect(),
        value => value,
    }
}

/// The JSON schema of an example. A `null` in it counts as a number.
#[must_use]
pub fn schema(of: &Value) -> Value {
    match of {
        Value::Object(keys) => {
            let properties: serde_json::Map<_, _> = keys
                .iter()
                .map(|(key, value)| (key.clone(), schema(value)))
                .collect();
            json!({ "type": "object", "properties": properties })
        }
        Value::Array(items) => {
            let items = items.first().map_or_else(|| json!({}), schema);
            json!({ "type": "array", "items": items })
        }
        Value::Number(number) if number.is_u64() => json!({ "type": "integer" }),
        Value::String(_) => json!({ "type": "string" }),
        Value::Bool(_) => json!({ "type": "boolean" }),
        _ => json!({ "type": "number" }),
    }
}
