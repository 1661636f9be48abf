//! Messages that the companion sends.

use mavlink::dialects::common::{
    AttitudeTargetTypemask, COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavMessage,
    MavModeFlag, MavParamType, MavState, MavType, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA,
    SET_ATTITUDE_TARGET_DATA, TIMESYNC_DATA,
};

use crate::autopilot::Mode;

/// Component id of the autopilot.
const AUTOPILOT: u8 = 1;
/// Disarms in the air as well, and on a deck that PX4's land detector does not accept.
const FORCED: f32 = 21196.0;

pub(super) fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}

/// A request for the other's time (`tc1_ns` = 0), or the answer to one.
pub(super) fn timesync(tc1_ns: i64, ts1_ns: i64) -> MavMessage {
    MavMessage::TIMESYNC(TIMESYNC_DATA {
        tc1: tc1_ns,
        ts1: ts1_ns,
        ..TIMESYNC_DATA::default()
    })
}

pub(super) fn parameter(system: u8, name: &str) -> MavMessage {
    MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index: -1,
        target_system: system,
        target_component: AUTOPILOT,
        param_id: name.into(),
    })
}

pub(super) fn set_parameter(system: u8, name: &str, value: f32, kind: MavParamType) -> MavMessage {
    MavMessage::PARAM_SET(PARAM_SET_DATA {
        param_value: value,
        target_system: system,
        target_component: AUTOPILOT,
        param_id: name.into(),
        param_type: kind,
    })
}

/// A request for `AUTOPILOT_VERSION`.
pub(super) fn version(system: u8) -> MavMessage {
    command(system, MavCmd::MAV_CMD_REQUEST_MESSAGE, [148.0, 0.0, 0.0])
}

pub(super) fn message_interval(system: u8, message_id: u32, hz: f64) -> MavMessage {
    let interval_us = (1e6 / hz) as f32;
    command(
        system,
        MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
        [message_id as f32, interval_us, 0.0],
    )
}

pub(super) fn set_mode(system: u8, mode: Mode) -> MavMessage {
    // 1: the modes are the autopilot's own.
    command(
        system,
        MavCmd::MAV_CMD_DO_SET_MODE,
        [1.0, f32::from(mode.main), f32::from(mode.sub)],
    )
}

pub(super) fn disarm(system: u8) -> MavMessage {
    command(
        system,
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        [0.0, FORCED, 0.0],
    )
}

/// Attitude (w, x, y, z; forward-right-down to north-east-down) and thrust in [0, 1].
pub(super) fn attitude_target(
    system: u8,
    time_boot_ms: u32,
    quaternion: [f64; 4],
    thrust: f64,
) -> MavMessage {
    MavMessage::SET_ATTITUDE_TARGET(SET_ATTITUDE_TARGET_DATA {
        time_boot_ms,
        q: quaternion.map(|c| c as f32),
        body_roll_rate: 0.0,
        body_pitch_rate: 0.0,
        body_yaw_rate: 0.0,
        thrust: thrust as f32,
        target_system: system,
        target_component: AUTOPILOT,
        type_mask: AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE
            | AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE
            | AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_BODY_YAW_RATE_IGNORE,
        thrust_body: [0.0; 3],
    })
}

fn command(system: u8, command: MavCmd, [param1, param2, param3]: [f32; 3]) -> MavMessage {
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        command,
        target_system: system,
        target_component: AUTOPILOT,
        ..COMMAND_LONG_DATA::default()
    })
}
