//! Every transition and every fault of the companion, against an autopilot that hovers above a deck at rest.

mod camera;
mod faults;
mod parameters;
mod sequences;
mod stages;

use std::collections::BTreeMap;

use super::{Companion, Ending, Event, Session, Stage};
use crate::settings::FlightSettings;
use crate::wire::{Decoder, Encoder};
use mavlink::Message as _;
use mavlink::dialects::common::*;

const PX4: MavAutopilot = MavAutopilot::MAV_AUTOPILOT_PX4;
const OFFBOARD: u32 = 6 << 16;
const POSITION: u32 = 3 << 16;
/// Message id of the setpoints that the autopilot follows.
const ATTITUDE_TARGET: u32 = 83;
/// The autopilot started 5 s before the companion.
const AHEAD_US: u64 = 5_000_000;

/// A companion, and an autopilot whose vehicle hovers.
struct Bench {
    companion: Companion,
    encoder: Encoder,
    now_us: u64,
    autopilot: MavAutopilot,
    mode: u32,
    armed: bool,
    parameters: BTreeMap<&'static str, f32>,
    /// Message ids that are not sent.
    mute: Vec<u32>,
    /// Message ids whose values stay the same to the bit.
    frozen: Vec<u32>,
    /// Whether it does not hear PARAM_SET.
    deaf: bool,
    /// How far the autopilot's clock is ahead, µs.
    ahead_us: u64,
    /// How long readings are on their way, µs.
    late_us: u64,
    /// Height above the deck, m.
    height_m: f64,
    specific_force: f32,
    yaw_rad: f32,
    /// Remaining battery, per cent.
    battery: i8,
    /// The autopilot follows this thrust; none for the newest setpoint.
    follows: Option<f32>,
    thrust: f32,
    sent: Vec<MavMessage>,
}

/// What a test does to the bench.
type Fault = fn(&mut Bench);

impl Bench {
    fn new() -> Self {
        Self::with(PX4, false)
    }

    fn with(autopilot: MavAutopilot, take_control: bool) -> Self {
        let session = Session {
            take_control,
            ..Session::default()
        };
        Self::session(autopilot, &session)
    }

    fn session(autopilot: MavAutopilot, session: &Session) -> Self {
        let mut settings = FlightSettings::default();
        settings.control.watch_s = 1.0;
        settings.control.planner = false;
        settings.control.finds_latency = false;
        let hover = settings.models.thrust.throttle_for(1.37 * 9.81) as f32;
        let parameters = [
            ("THR_MDL_FAC", 0.0),
            ("MPC_THR_HOVER", hover),
            ("COM_OF_LOSS_T", 0.5),
            ("COM_OBL_RC_ACT", f32::from_bits(5)),
            ("EKF2_RNG_CTRL", 0.0),
            ("MPC_LAND_SPEED", 0.7),
            ("LNDMC_Z_VEL_MAX", 0.25),
            ("MC_BAT_SCALE_EN", f32::from_bits(0)),
            ("GUID_OPTIONS", 8.0),
            ("GUID_TIMEOUT", 0.5),
            ("MOT_THST_EXPO", 0.0),
            ("MOT_THST_HOVER", hover),
            ("MOT_SPIN_MIN", 0.0),
            ("MOT_SPIN_MAX", 1.0),
            ("PLND_ENABLED", 0.0),
            ("ATC_ANGLE_BOOST", 1.0),
            ("MOT_BAT_VOLT_MAX", 0.0),
        ];
        Self {
            companion: Companion::new(&settings, session).unwrap(),
            encoder: Encoder::new(7, 1),
            now_us: 0,
            autopilot,
            mode: if autopilot == PX4 { POSITION } else { 5 },
            armed: true,
            parameters: parameters.into(),
            mute: Vec::new(),
            frozen: Vec::new(),
            deaf: false,
            ahead_us: AHEAD_US,
            late_us: 0,
            height_m: 0.8,
            specific_force: -9.81,
            yaw_rad: 0.0,
            battery: 80,
            follows: None,
            thrust: hover,
            sent: Vec::new(),
        }
    }

    /// A companion that is ready.
    fn ready() -> Self {
        let mut bench = Self::new();
        bench.becomes_ready();
        bench
    }

    fn becomes_ready(&mut self) {
        self.run(8.0);
        let text = self.companion.checklist().changes(&[]);
        assert_eq!(self.companion.stage(), Stage::Ready, "{text}");
    }

    /// A companion in control.
    fn flying() -> Self {
        let mut bench = Self::ready();
        bench.mode = OFFBOARD;
        bench.run(1.5);
        assert_eq!(bench.companion.stage(), Stage::InControl);
        bench
    }

    /// A companion that has landed: the vehicle stands on the deck and its rotors idle.
    fn landed() -> Self {
        let mut bench = Self::flying();
        bench.companion.enter(Stage::Landed);
        bench.run(0.1);
        bench
    }

    fn boot_ms(&self) -> u32 {
        ((self.now_us + self.ahead_us - self.late_us) / 1000) as u32
    }

    fn deliver(&mut self, message: &MavMessage) {
        if self.mute.contains(&message.message_id()) {
            return;
        }
        let mut bytes = Vec::new();
        self.encoder
            .write_at(message, self.now_us as i64, &mut bytes);
        self.event(Event::Received(&bytes));
    }

    fn event(&mut self, event: Event<'_>) {
        let mut out = Vec::new();
        self.companion.handle(self.now_us, event, &mut out);
        let mut decoder = Decoder::default();
        decoder.push(&out);
        while let Some(frame) = decoder.next_frame() {
            assert_eq!(frame.component, 191);
            self.answer(&frame.message);
            self.sent.push(frame.message);
        }
    }

    fn answer(&mut self, message: &MavMessage) {
        match message {
            MavMessage::TIMESYNC(m) if m.tc1 == 0 => {
                let tc1 = ((self.now_us + self.ahead_us) * 1000) as i64;
                let answer = TIMESYNC_DATA {
                    tc1,
                    ts1: m.ts1,
                    ..TIMESYNC_DATA::default()
                };
                self.deliver(&MavMessage::TIMESYNC(answer));
            }
            MavMessage::PARAM_REQUEST_READ(m) => self.parameter(m.param_id.to_str().unwrap()),
            MavMessage::PARAM_SET(m) if !self.deaf => {
                let name = m.param_id.to_str().unwrap();
                if let Some(value) = self.parameters.get_mut(name) {
                    *value = m.param_value;
                }
                self.parameter(name);
            }
            MavMessage::SET_ATTITUDE_TARGET(m) => self.thrust = m.thrust,
            MavMessage::COMMAND_LONG(m) if m.param1 == 148.0 => {
                self.deliver(&MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
                    flight_sw_version: 0x0111_00ff,
                    ..AUTOPILOT_VERSION_DATA::default()
                }));
            }
            _ => {}
        }
    }

    fn parameter(&mut self, name: &str) {
        let Some(value) = self.parameters.get(name).copied() else {
            return;
        };
        let whole = ["COM_OBL_RC_ACT", "MC_BAT_SCALE_EN"].contains(&name);
        let integer = self.autopilot == PX4 && whole;
        let answer = PARAM_VALUE_DATA {
            param_value: value,
            param_id: name.into(),
            param_type: if integer {
                MavParamType::MAV_PARAM_TYPE_INT32
            } else {
                MavParamType::MAV_PARAM_TYPE_REAL32
            },
            ..PARAM_VALUE_DATA::default()
        };
        self.deliver(&MavMessage::PARAM_VALUE(answer));
    }

    fn heartbeat(&mut self) {
        let armed = if self.armed {
            MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED
        } else {
            MavModeFlag::empty()
        };
        self.deliver(&MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: self.mode,
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: self.autopilot,
            base_mode: armed | MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
            ..HEARTBEAT_DATA::default()
        }));
    }

    /// What moves the last digits of a message: noise of the sensor.
    fn noise(&self, message_id: u32, tick: u64) -> f32 {
        if self.frozen.contains(&message_id) {
            1e-4
        } else {
            1e-4 * (tick as f32).sin()
        }
    }

    fn readings(&mut self, tick: u64) {
        let time_boot_ms = self.boot_ms();
        self.deliver(&MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1: (0.5 * self.yaw_rad).cos(),
            q2: self.noise(31, tick),
            q4: (0.5 * self.yaw_rad).sin(),
            ..ATTITUDE_QUATERNION_DATA::default()
        }));
        if self.autopilot == PX4 {
            self.deliver(&MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
                time_usec: u64::from(time_boot_ms) * 1000,
                xacc: self.noise(105, tick),
                zacc: self.specific_force,
                ..HIGHRES_IMU_DATA::default()
            }));
        } else {
            self.deliver(&MavMessage::SCALED_IMU(SCALED_IMU_DATA {
                time_boot_ms,
                xacc: (2e4 * self.noise(26, tick)) as i16,
                zacc: (self.specific_force / 9.80665e-3) as i16,
                ..SCALED_IMU_DATA::default()
            }));
        }
        if tick.is_multiple_of(2) {
            self.deliver(&MavMessage::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
                time_boot_ms,
                min_distance: 2,
                max_distance: 1200,
                current_distance: (self.height_m * 100.0).round() as u16,
                orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
                ..DISTANCE_SENSOR_DATA::default()
            }));
        }
        if tick.is_multiple_of(3) {
            self.deliver(&MavMessage::LANDING_TARGET(LANDING_TARGET_DATA {
                time_usec: u64::from(time_boot_ms) * 1000,
                frame: MavFrame::MAV_FRAME_BODY_FRD,
                x: self.noise(149, tick),
                z: self.height_m as f32,
                position_valid: MavBool::MAV_BOOL_TRUE,
                ..LANDING_TARGET_DATA::default()
            }));
            self.deliver(&MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms,
                vx: self.noise(32, tick),
                ..LOCAL_POSITION_NED_DATA::default()
            }));
        }
    }

    /// Reports at 50 Hz: the setpoint that is followed, and the battery.
    fn reports(&mut self) {
        self.deliver(&MavMessage::ATTITUDE_TARGET(ATTITUDE_TARGET_DATA {
            thrust: self.follows.unwrap_or(self.thrust),
            ..ATTITUDE_TARGET_DATA::default()
        }));
        self.deliver(&MavMessage::SYS_STATUS(SYS_STATUS_DATA {
            battery_remaining: self.battery,
            ..SYS_STATUS_DATA::default()
        }));
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.now_us += 10_000;
            let tick = self.now_us / 10_000;
            if tick.is_multiple_of(100) {
                self.heartbeat();
            }
            if tick.is_multiple_of(2) {
                self.reports();
            }
            self.readings(tick);
            self.event(Event::Tick);
        }
    }

    fn setpoints(&self) -> usize {
        let is_setpoint = |m: &&MavMessage| matches!(m, MavMessage::SET_ATTITUDE_TARGET(_));
        self.sent.iter().filter(is_setpoint).count()
    }

    fn commands(&self, command: MavCmd) -> usize {
        let is_it =
            |m: &&MavMessage| matches!(m, MavMessage::COMMAND_LONG(m) if m.command == command);
        self.sent.iter().filter(is_it).count()
    }

    fn holds(&self) -> usize {
        self.commands(MavCmd::MAV_CMD_DO_SET_MODE)
    }

    fn disarms(&self) -> usize {
        self.commands(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM)
    }

    fn ends(&self, stage: Stage, ending: Ending) {
        let summary = self.companion.summary();
        assert_eq!((summary.stage, summary.ending), (stage, Some(ending)));
    }
}
