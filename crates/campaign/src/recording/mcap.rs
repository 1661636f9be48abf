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
//! | `/sensors` | `touchdown.Sensors` | what the estimator makes of each sensor, whether it has diverged, estimated latency |
//! | `/imu` | `sensor_msgs/msg/Imu` | the inertial unit, 250 Hz; axes forward, port, up |
//! | `/motors` | `touchdown.Motors` | throttles of the motors, 250 Hz; without keys while they are off |
//! | `/range` | `sensor_msgs/msg/Range` | the range finder, when a reading was taken |
//! | `/tag` | `geometry_msgs/msg/PointStamped` | the tag in camera axes, at the stamp of the image that has arrived |
//! | `/battery` | `sensor_msgs/msg/BatteryState` | the battery's voltage |
//! | `/local_position/velocity_local` | `geometry_msgs/msg/TwistStamped` | how the vehicle believes to move, world axes, z up |
//!
//! Messages are JSON with JSON schemas; what has no value has no key. Times count from the start of the trial.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::{Value, json};
use touchdown_foxglove::messages::{self, POSE, TRANSFORM, quaternion, schema, xyz};
use touchdown_sim::landing::space::{ImuRow, SensorRow, SpaceTrace, TraceRow};

use crate::error::{Error, Result};

type Message<LandingRow> = fn(&LandingRow) -> Value;

/// Topic, schema, message.
const TOPICS: [(&str, &str, Message<TraceRow>); 11] = [
    ("/tf", TRANSFORM, |r| {
        transform(r, "deck", r.deck_m, level(r.deck_normal))
    }),
    ("/tf", TRANSFORM, |r| {
        transform(r, "vehicle", r.position_m, r.attitude)
    }),
    ("/vehicle/pose", POSE, |r| pose(r, r.position_m, r.attitude)),
    ("/deck/pose", POSE, |r| {
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
        let motion = [r.estimated_m, r.estimated_mps, r.estimated_sd_m];
        messages::estimate(nanoseconds(r.time_s), motion, r.target)
    }),
    ("/phase", "touchdown.Phase", |r| {
        json!({
            "timestamp": stamp(r), "phase": r.phase, "reason": r.reason, "waits_for": r.waits_for,
        })
    }),
    ("/sensors", "touchdown.Sensors", |r| {
        json!({
            "timestamp": stamp(r),
            "range": sensor(&r.range),
            "tag": sensor(&r.tag),
            "gnss": sensor(&r.gnss),
            "beacon": sensor(&r.beacon),
            "diverged": r.diverged,
            "estimated_latency_s": r.estimated_latency_s,
        })
    }),
    (
        "/local_position/velocity_local",
        "geometry_msgs/msg/TwistStamped",
        |r| {
            json!({
                "header": header(r.time_s, "world"),
                "twist": { "linear": xyz(r.estimated_velocity_mps) },
            })
        },
    ),
];

/// Readings of the sensors, at the rate of the inertial unit.
const SENSED: [(&str, &str, Message<ImuRow>); 3] = [
    ("/imu", "sensor_msgs/msg/Imu", |r| {
        json!({
            "header": header(r.time_s, "vehicle"),
            "orientation": quaternion(r.attitude),
            "angular_velocity": xyz(r.rates),
            "linear_acceleration": xyz(r.specific_force_mps2),
        })
    }),
    ("/motors", "touchdown.Motors", |r| {
        let throttle = r.throttle.unwrap_or([f64::NAN; 4]);
        json!({ "header": header(r.time_s, "vehicle"), "throttle": quad(throttle) })
    }),
    (
        "/battery",
        "sensor_msgs/msg/BatteryState",
        |r| json!({ "header": header(r.time_s, "vehicle"), "voltage": r.battery_v }),
    ),
];

fn nanoseconds(time_s: f64) -> u64 {
    // Steps are whole milliseconds.
    (time_s * 1e3).round() as u64 * 1_000_000
}

fn stamp(row: &TraceRow) -> Value {
    messages::stamp(nanoseconds(row.time_s))
}

/// The header of messages of ROS 2.
fn header(time_s: f64, frame: &str) -> Value {
    messages::header(nanoseconds(time_s), frame)
}

fn quad([a, b, c, d]: [f64; 4]) -> Value {
    json!({ "0": a, "1": b, "2": c, "3": d })
}

fn sensor(row: &SensorRow) -> Value {
    json!({ "age_s": row.age_s, "nis": row.nis, "rejected_in_a_row": row.rejected_in_a_row })
}

fn pose(row: &TraceRow, position_m: [f64; 3], attitude: [f64; 4]) -> Value {
    messages::pose(nanoseconds(row.time_s), "world", position_m, attitude)
}

fn transform(row: &TraceRow, child: &str, translation_m: [f64; 3], rotation: [f64; 4]) -> Value {
    let time_ns = nanoseconds(row.time_s);
    messages::transform(time_ns, ["world", child], translation_m, rotation)
}

/// The shortest turn from upright to a normal: a deck turns about its level axes only, but for terms of second order.
fn level([x, y, z]: [f64; 3]) -> [f64; 4] {
    let [w, i, j] = [1.0 + z, -y, x];
    let length = (w * w + i * i + j * j).sqrt();
    [w / length, i / length, j / length, 0.0]
}

/// The bytes of an MCAP file with a landing's record.
///
/// # Errors
/// What the writer of MCAP refuses; nothing of a landing's trace is.
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
    // Messages by their time; those of one time stand as the topics do.
    let mut rows: Vec<(u64, usize, Value)> = Vec::new();
    let mut channels: Vec<(&str, &str)> = Vec::new();
    let mut add = |topic, schema, of: &mut dyn Iterator<Item = (f64, Value)>| {
        let channel = channels.len();
        channels.push((topic, schema));
        rows.extend(of.map(|(time_s, value)| (nanoseconds(time_s), channel, value)));
    };
    for (topic, schema, message) in TOPICS {
        let of = trace.rows.iter().map(|row| (row.time_s, message(row)));
        add(topic, schema, &mut { of });
    }
    for (topic, schema, message) in SENSED {
        let of = trace.log.imu.iter().map(|row| (row.time_s, message(row)));
        add(topic, schema, &mut { of });
    }
    let finder = &trace.log.range_finder;
    let of = trace.log.ranges.iter().map(|row| {
        let value = json!({
            "header": header(row.time_s, "range_finder"),
            "radiation_type": 1,
            "field_of_view": 0.0,
            "min_range": finder.least_m,
            "max_range": finder.greatest_m,
            "range": row.distance_m,
        });
        (row.time_s, value)
    });
    add("/range", "sensor_msgs/msg/Range", &mut { of });
    let of = trace.log.tags.iter().map(|row| {
        let header = header(row.time_s, "camera");
        let value = json!({ "header": header, "point": xyz(row.position_m) });
        (row.time_s, value)
    });
    add("/tag", "geometry_msgs/msg/PointStamped", &mut { of });
    rows.sort_by_key(|(ns, channel, _)| (*ns, *channel));

    let mut ids = Vec::new();
    for (channel, (topic, name)) in channels.iter().enumerate() {
        let Some((.., first)) = rows.iter().find(|(_, of, _)| of == &channel) else {
            ids.push(None);
            continue;
        };
        let mut schema = schema(first);
        if *name == "touchdown.Phase" {
            for key in ["reason", "waits_for"] {
                schema["properties"][key] = json!({ "type": "string" });
            }
        }
        let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        ids.push(Some(writer.add_channel(
            schema,
            topic,
            "json",
            &BTreeMap::new(),
        )?));
    }
    for (sequence, (ns, channel, message)) in rows.into_iter().enumerate() {
        let Some(channel_id) = ids[channel] else {
            continue;
        };
        let header = MessageHeader {
            channel_id,
            sequence: sequence as u32,
            log_time: ns,
            publish_time: ns,
        };
        let text = messages::present(message).to_string();
        writer.write_to_known_channel(&header, text.as_bytes())?;
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes)
}
