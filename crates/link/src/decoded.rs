//! Decoded messages as JSON in SI units, so that any reader of MCAP can plot and identify a recording.

use mavlink::dialects::common::{MavMessage, MavModeFlag, MavSensorOrientation};
use serde_json::{Value, json};
use touchdown_foxglove::Topic;

/// The objects of decoded topics contain numbers only.
const SCHEMA: &str = r#"{"type": "object", "additionalProperties": {"type": ["number", "null"]}}"#;

/// Topics of decoded messages.
pub(crate) const TOPICS: [&str; 9] = [
    "/mavlink/attitude",
    "/mavlink/imu",
    "/mavlink/distance",
    "/mavlink/local_position",
    "/mavlink/landing_target",
    "/mavlink/attitude_target",
    "/mavlink/heartbeat",
    "/mavlink/battery",
    "/mavlink/setpoint",
];

/// The topics with their schemas.
pub(crate) fn topics() -> impl Iterator<Item = Topic> {
    TOPICS.into_iter().map(|name| Topic {
        name: name.to_string(),
        schema_name: "touchdown.Mavlink".to_string(),
        schema: SCHEMA.to_string(),
    })
}

/// The topic and the object of a message; none for those that are not decoded. Axes are MAVLink's own: forward-right-down
/// and north-east-down. A number that is not finite is null.
pub(crate) fn decoded(message: &MavMessage) -> Option<(usize, Value)> {
    let entry = match message {
        MavMessage::ATTITUDE_QUATERNION(m) => (
            0,
            json!({"time_boot_s": boot(m.time_boot_ms), "qw": m.q1, "qx": m.q2, "qy": m.q3, "qz": m.q4}),
        ),
        MavMessage::HIGHRES_IMU(m) => {
            let time_s = m.time_usec as f64 * 1e-6;
            (1, imu(time_s, [m.xacc, m.yacc, m.zacc].map(f64::from)))
        }
        MavMessage::SCALED_IMU(m) => {
            let force = [m.xacc, m.yacc, m.zacc].map(|a| f64::from(a) * 9.80665e-3);
            (1, imu(boot(m.time_boot_ms), force))
        }
        MavMessage::DISTANCE_SENSOR(m) => {
            if m.orientation != MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270 {
                return None;
            }
            let inside = (m.min_distance..=m.max_distance).contains(&m.current_distance);
            let distance_m = inside.then_some(f64::from(m.current_distance) * 0.01);
            (
                2,
                json!({"time_boot_s": boot(m.time_boot_ms), "distance_m": distance_m}),
            )
        }
        MavMessage::LOCAL_POSITION_NED(m) => (
            3,
            json!({"time_boot_s": boot(m.time_boot_ms), "x_m": m.x, "y_m": m.y, "z_m": m.z,
                "vx_mps": m.vx, "vy_mps": m.vy, "vz_mps": m.vz}),
        ),
        MavMessage::LANDING_TARGET(m) => (
            4,
            json!({"time_s": m.time_usec as f64 * 1e-6, "frame": m.frame as u8, "x_m": m.x, "y_m": m.y, "z_m": m.z}),
        ),
        MavMessage::ATTITUDE_TARGET(m) => (5, target(m.time_boot_ms, m.q, m.thrust)),
        MavMessage::HEARTBEAT(m) => {
            let armed = m
                .base_mode
                .contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
            (
                6,
                json!({"custom_mode": m.custom_mode, "armed": u8::from(armed)}),
            )
        }
        MavMessage::SYS_STATUS(m) => (
            7,
            json!({"voltage_v": f64::from(m.voltage_battery) * 1e-3, "remaining": f64::from(m.battery_remaining) * 0.01}),
        ),
        MavMessage::SET_ATTITUDE_TARGET(m) => (8, target(m.time_boot_ms, m.q, m.thrust)),
        _ => return None,
    };
    Some(entry)
}

fn boot(milliseconds: u32) -> f64 {
    f64::from(milliseconds) * 1e-3
}

fn imu(time_boot_s: f64, [x, y, z]: [f64; 3]) -> Value {
    json!({"time_boot_s": time_boot_s, "specific_force_x_mps2": x, "specific_force_y_mps2": y, "specific_force_z_mps2": z})
}

fn target(time_boot_ms: u32, [w, x, y, z]: [f32; 4], thrust: f32) -> Value {
    json!({"time_boot_s": boot(time_boot_ms), "qw": w, "qx": x, "qy": y, "qz": z, "thrust": thrust})
}
