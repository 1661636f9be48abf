//! Landings as MCAP files, for Foxglove and PlotJuggler.
//!
//! | topic | schema | what it holds |
//! | --- | --- | --- |
//! | `/tf` | `foxglove.FrameTransform` | `world` to `deck`, `world` to `vehicle` |
//! | `/vehicle/pose`, `/deck/pose` | `foxglove.PoseInFrame` | the true poses |
//! | `/deck` | `touchdown.Deck` | motion of the deck, true, estimated and forecast 1 s ahead |
//! | `/vehicle` | `touchdown.Vehicle` | motion of the vehicle, in world axes and relative to the deck |
//! | `/forces` | `touchdown.Forces` | rotors, ground effect, feet, thrust asked for, wind |
//! | `/estimate` | `touchdown.Estimate` | what the landing computer believes |
//! | `/phase` | `touchdown.Phase` | where the landing is, and why |
//!
//! Messages are JSON with JSON schemas; times count from the start of the trial.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::{Value, json};
use touchdown_sim::space::{SpaceTrace, TraceRow};

use crate::error::{Error, Result};

type Message = fn(&TraceRow) -> Value;

/// Topic, schema, message.
const TOPICS: [(&str, &str, Message); 9] = [
    ("/tf", "foxglove.FrameTransform", |r| {
        transform(r, "deck", r.deck_m, level(r.deck_normal))
    }),
    ("/tf", "foxglove.FrameTransform", |r| {
        transform(r, "vehicle", r.position_m, r.attitude)
    }),
    ("/vehicle/pose", "foxglove.PoseInFrame", |r| {
        pose(r, r.position_m, r.attitude)
    }),
    ("/deck/pose", "foxglove.PoseInFrame", |r| {
        pose(r, r.deck_m, level(r.deck_normal))
    }),
    ("/deck", "touchdown.Deck", |r| {
        json!({
            "timestamp": stamp(r),
            "velocity_mps": xyz(r.deck_mps),
            "acceleration_mps2": xyz(r.deck_mps2),
            "normal": xyz(r.deck_normal),
            "estimated_heave_mps": r.estimated_deck_mps,
            "estimated_heave_sd_mps": r.estimated_deck_sd_mps,
            "estimated_heave_mps2": r.estimated_deck_mps2,
            "forecast_heave_mps": r.forecast_deck_mps,
            "forecast_heave_sd_mps": r.forecast_deck_sd_mps,
        })
    }),
    ("/vehicle", "touchdown.Vehicle", |r| {
        json!({
            "timestamp": stamp(r),
            "velocity_mps": xyz(r.velocity_mps),
            "rates_radps": xyz(r.rates),
            "relative_m": xyz(r.relative_m),
            "relative_mps": xyz(r.relative_mps),
            "throttle": quad(r.throttle),
        })
    }),
    ("/forces", "touchdown.Forces", |r| {
        json!({
            "timestamp": stamp(r),
            "rotor_n": quad(r.rotor_n),
            "ground_effect_n": r.ground_effect_n,
            "counted_ground_effect_n": r.counted_ground_effect_n,
            "feet_n": quad(r.feet_n),
            "thrust_asked_n": r.thrust_n,
            "disturbance_n": xyz(r.disturbance_n),
            "wind_mps": xyz(r.wind_mps),
        })
    }),
    ("/estimate", "touchdown.Estimate", |r| {
        json!({
            "timestamp": stamp(r),
            "position_m": xyz(r.estimated_m),
            "velocity_mps": xyz(r.estimated_mps),
            "position_sd_m": xyz(r.estimated_sd_m),
            "target_height_m": r.target.map(|t| t[0]),
            "target_velocity_mps": r.target.map(|t| t[1]),
        })
    }),
    (
        "/phase",
        "touchdown.Phase",
        |r| json!({ "timestamp": stamp(r), "phase": r.phase, "reason": r.reason }),
    ),
];

fn nanoseconds(row: &TraceRow) -> u64 {
    // Steps are whole milliseconds.
    (row.time_s * 1e3).round() as u64 * 1_000_000
}

fn stamp(row: &TraceRow) -> Value {
    let ns = nanoseconds(row);
    json!({ "sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000 })
}

fn xyz([x, y, z]: [f64; 3]) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

fn wxyz([w, x, y, z]: [f64; 4]) -> Value {
    json!({ "x": x, "y": y, "z": z, "w": w })
}

fn quad([a, b, c, d]: [f64; 4]) -> Value {
    json!({ "0": a, "1": b, "2": c, "3": d })
}

fn pose(row: &TraceRow, position_m: [f64; 3], attitude: [f64; 4]) -> Value {
    json!({
        "timestamp": stamp(row),
        "frame_id": "world",
        "pose": { "position": xyz(position_m), "orientation": wxyz(attitude) },
    })
}

fn transform(row: &TraceRow, child: &str, translation_m: [f64; 3], rotation: [f64; 4]) -> Value {
    json!({
        "timestamp": stamp(row),
        "parent_frame_id": "world",
        "child_frame_id": child,
        "translation": xyz(translation_m),
        "rotation": wxyz(rotation),
    })
}

/// The shortest turn from upright to a normal: a deck turns about its level axes only, but for terms of second order.
fn level([x, y, z]: [f64; 3]) -> [f64; 4] {
    let [w, i, j] = [1.0 + z, -y, x];
    let length = (w * w + i * i + j * j).sqrt();
    [w / length, i / length, j / length, 0.0]
}

/// The JSON schema that a message has. Numbers that may be absent are `null` then.
fn schema(of: &Value) -> Value {
    match of {
        Value::Object(keys) => {
            let properties: serde_json::Map<_, _> = keys
                .iter()
                .map(|(key, value)| (key.clone(), schema(value)))
                .collect();
            json!({ "type": "object", "properties": properties })
        }
        Value::Number(number) if number.is_u64() => json!({ "type": "integer" }),
        Value::String(_) => json!({ "type": "string" }),
        _ => json!({ "type": "number" }),
    }
}

/// The bytes of an MCAP file with a landing's record.
///
/// # Errors
/// A record without rows.
pub fn mcap(trace: &SpaceTrace) -> Result<Vec<u8>> {
    written(trace)
        .map_err(|e| Error::Arguments(format!("the landing cannot be written as MCAP: {e}")))
}

fn written(trace: &SpaceTrace) -> std::result::Result<Vec<u8>, McapError> {
    let mut bytes = Vec::new();
    let options = WriteOptions::new()
        .compression(None)
        .library(concat!("touchdown ", env!("CARGO_PKG_VERSION")));
    let mut writer: Writer<_> = options.create(Cursor::new(&mut bytes))?;
    let mut channels = Vec::new();
    for (topic, name, message) in TOPICS {
        let Some(row) = trace.rows.first() else { break };
        let mut schema = schema(&message(row));
        if name == "touchdown.Phase" {
            schema["properties"]["reason"] = json!({ "type": "string" });
        }
        let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        channels.push(writer.add_channel(schema, topic, "json", &BTreeMap::new())?);
    }
    for (sequence, row) in trace.rows.iter().enumerate() {
        let ns = nanoseconds(row);
        for ((.., message), &channel_id) in TOPICS.iter().zip(&channels) {
            let header = MessageHeader {
                channel_id,
                sequence: sequence as u32,
                log_time: ns,
                publish_time: ns,
            };
            writer.write_to_known_channel(&header, message(row).to_string().as_bytes())?;
        }
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes)
}
