//! An autopilot whose vehicle hovers above a deck at rest, for a companion in any situation.

use std::sync::LazyLock;

use mavlink::Message as _;
use mavlink::dialects::common::*;
use touchdown_link::companion::{Companion, Event, Session, Stage};
use touchdown_link::settings::FlightSettings;
use touchdown_link::wire::{Decoder, Encoder};

/// The autopilot started 5 s before the companion.
const AHEAD_US: u64 = 5_000_000;
/// Modes of PX4.
const OFFBOARD: u32 = 6 << 16;
const POSITION: u32 = 3 << 16;
/// Height above the deck, m.
const HEIGHT_M: f32 = 0.8;
/// Messages that the companion reads.
const IDS: [u32; 20] = [
    0, 1, 22, 26, 31, 32, 33, 77, 83, 102, 105, 111, 132, 144, 148, 149, 253, 331, 436, 410,
];

/// A companion and its autopilot.
#[derive(Clone)]
pub struct Bench {
    companion: Companion,
    encoder: Encoder,
    /// What the companion hears: a frame that was cut short can swallow the one after it.
    heard: Decoder,
    now_us: u64,
    mode: u32,
    armed: bool,
    /// Whether a report of another mode has reached the companion while it was in control.
    taken_over: bool,
    /// Whether the mode of the last report is the one that follows setpoints.
    follows: bool,
    /// Called with `true` before, and with `false` after the companion handles an event.
    pub probe: fn(bool),
}

/// A companion in control.
static FLYING: LazyLock<Bench> = LazyLock::new(|| {
    let mut bench = Bench::new();
    bench.run(900);
    bench.mode = OFFBOARD;
    bench.run(150);
    assert_eq!(bench.companion.stage(), Stage::InControl);
    bench
});

impl Bench {
    fn new() -> Self {
        let mut settings = FlightSettings::default();
        settings.control.watch_s = 1.0;
        settings.control.planner = false;
        settings.control.finds_latency = false;
        settings.deck.system_id = 9;
        let session = Session {
            set_parameters: true,
            ..Session::default()
        };
        Self {
            companion: Companion::new(&settings, &session).expect("defaults"),
            encoder: Encoder::new(7, 1),
            heard: Decoder::default(),
            now_us: 0,
            mode: POSITION,
            armed: true,
            taken_over: false,
            follows: false,
            probe: |_| {},
        }
    }

    /// A companion in the first or in full flight.
    #[must_use]
    pub fn start(flies: bool) -> Self {
        if flies { FLYING.clone() } else { Self::new() }
    }

    /// Runs a script: each byte is an action, and some take further bytes.
    pub fn script(&mut self, script: &[u8]) {
        let mut rest = script.iter().copied();
        while let Some(action) = rest.next() {
            match action % 10 {
                0..=2 => self.run(usize::from(rest.next().unwrap_or(1) % 64)),
                3 => {
                    let number = rest.next().unwrap_or(0);
                    self.mode = [OFFBOARD, POSITION, 4 << 16][usize::from(number % 3)];
                    self.armed = number < 200;
                    self.heartbeat();
                }
                4 => {
                    let length = usize::from(rest.next().unwrap_or(0));
                    let bytes: Vec<u8> = rest.by_ref().take(length).collect();
                    self.event(Event::Received(&bytes));
                }
                5..=6 => {
                    let id = IDS[usize::from(rest.next().unwrap_or(0)) % IDS.len()];
                    let sender = [[7, 1], [7, 1], [7, 191], [9, 1]][usize::from(action / 10) % 4];
                    let length = usize::from(rest.next().unwrap_or(0));
                    let payload: Vec<u8> = rest.by_ref().take(length).collect();
                    self.event(Event::Received(&frame(sender, id, &payload)));
                }
                7 => self.now_us += u64::from(rest.next().unwrap_or(0)) * 10_000,
                8 => self.readings(),
                _ => {
                    if rest.next() == Some(0) {
                        self.event(Event::Stop);
                    } else {
                        self.event(Event::Tick);
                    }
                }
            }
        }
    }

    /// Whether the companion is in control.
    #[must_use]
    pub fn in_control(&self) -> bool {
        self.companion.stage() == Stage::InControl
    }

    /// Runs a number of ticks, with readings and heartbeats.
    pub fn run(&mut self, ticks: usize) {
        for _ in 0..ticks {
            self.now_us += 10_000;
            if (self.now_us / 10_000).is_multiple_of(10) {
                self.heartbeat();
            }
            self.readings();
            self.event(Event::Tick);
        }
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
            autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
            base_mode: armed | MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
            ..HEARTBEAT_DATA::default()
        }));
    }

    fn readings(&mut self) {
        let time_boot_ms = ((self.now_us + AHEAD_US) / 1000) as u32;
        let time_usec = u64::from(time_boot_ms) * 1000;
        // The last digits of a reading move; values that stay the same are those of a sensor that hangs.
        let noise = 1e-4 * (time_boot_ms as f32).sin();
        self.deliver(&MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1: 1.0,
            q2: noise,
            ..ATTITUDE_QUATERNION_DATA::default()
        }));
        self.deliver(&MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
            time_usec,
            xacc: noise,
            zacc: -9.81,
            ..HIGHRES_IMU_DATA::default()
        }));
        self.deliver(&MavMessage::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
            time_boot_ms,
            min_distance: 2,
            max_distance: 1200,
            current_distance: (HEIGHT_M * 100.0) as u16,
            orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
            ..DISTANCE_SENSOR_DATA::default()
        }));
        self.deliver(&MavMessage::LANDING_TARGET(LANDING_TARGET_DATA {
            time_usec,
            frame: MavFrame::MAV_FRAME_BODY_FRD,
            x: noise,
            z: HEIGHT_M,
            position_valid: MavBool::MAV_BOOL_TRUE,
            ..LANDING_TARGET_DATA::default()
        }));
        self.deliver(&MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
            time_boot_ms,
            vx: noise,
            ..LOCAL_POSITION_NED_DATA::default()
        }));
    }

    fn deliver(&mut self, message: &MavMessage) {
        let mut bytes = Vec::new();
        self.encoder.write(message, &mut bytes);
        self.event(Event::Received(&bytes));
    }

    /// Handles an event, checks what is sent, and answers it.
    fn event(&mut self, event: Event<'_>) {
        let before = self.companion.stage();
        if let Event::Received(bytes) = &event {
            self.hear(bytes, matches!(before, Stage::InControl | Stage::Landed));
        }
        let mut out = Vec::with_capacity(4096);
        (self.probe)(true);
        self.companion.handle(self.now_us, event, &mut out);
        (self.probe)(false);
        let after = self.companion.stage();
        if before == Stage::Ended {
            assert_eq!(after, Stage::Ended);
        }
        let mut decoder = Decoder::default();
        decoder.push(&out);
        let mut sent = Vec::new();
        while let Some(frame) = decoder.next_frame() {
            self.judge(&frame.message, after);
            sent.push(frame.message);
        }
        assert_eq!(decoder.counts.corrupt, 0);
        // An answer may bring more than itself, so it comes after all has been judged that was sent before it.
        for message in &sent {
            self.answer(message);
        }
    }

    fn hear(&mut self, bytes: &[u8], flies: bool) {
        self.heard.push(bytes);
        while let Some(frame) = self.heard.next_frame() {
            let mode = match &frame.message {
                MavMessage::HEARTBEAT(m)
                    if m.autopilot == MavAutopilot::MAV_AUTOPILOT_PX4
                        && m.mavtype == MavType::MAV_TYPE_QUADROTOR =>
                {
                    m.custom_mode
                }
                MavMessage::CURRENT_MODE(m) => m.custom_mode,
                _ => continue,
            };
            if (frame.system, frame.component) == (7, 1) {
                self.follows = mode >> 16 & 0xff == OFFBOARD >> 16;
                self.taken_over |= flies && !self.follows;
            }
        }
    }

    fn judge(&self, message: &MavMessage, stage: Stage) {
        if stage == Stage::Ended && !self.taken_over {
            return;
        }
        if let MavMessage::SET_ATTITUDE_TARGET(m) = message {
            assert!(!self.taken_over, "a setpoint after a take-over");
            let early = stage == Stage::Ready && self.follows;
            assert!(!early, "a setpoint that is followed before control");
            assert!(matches!(
                stage,
                Stage::Ready | Stage::InControl | Stage::Landed
            ));
            assert!((0.0..=1.0).contains(&m.thrust), "{m:?}");
            let square: f32 = m.q.iter().map(|c| c * c).sum();
            assert!((square - 1.0).abs() < 1e-3, "{m:?}");
        }
        if let (MavMessage::COMMAND_LONG(m), true) = (message, self.taken_over) {
            let commands = m.command == MavCmd::MAV_CMD_DO_SET_MODE
                || m.command == MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
            assert!(!commands, "a command after a take-over");
        }
    }

    fn answer(&mut self, message: &MavMessage) {
        match message {
            MavMessage::TIMESYNC(m) if m.tc1 == 0 => {
                self.deliver(&MavMessage::TIMESYNC(TIMESYNC_DATA {
                    tc1: ((self.now_us + AHEAD_US) * 1000) as i64,
                    ts1: m.ts1,
                    ..TIMESYNC_DATA::default()
                }));
            }
            MavMessage::PARAM_REQUEST_READ(m) => {
                let name = m.param_id.to_str().unwrap_or_default();
                let value = match name {
                    "MPC_THR_HOVER" => 0.5,
                    "COM_OF_LOSS_T" => 0.5,
                    "COM_OBL_RC_ACT" => 5.0,
                    _ => 0.0,
                };
                self.deliver(&MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
                    param_value: value,
                    param_id: m.param_id,
                    param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
                    ..PARAM_VALUE_DATA::default()
                }));
            }
            _ => {}
        }
    }
}

/// A frame with a right checksum and any content.
fn frame([system, component]: [u8; 2], id: u32, payload: &[u8]) -> Vec<u8> {
    let length = payload.len().min(255);
    let [a, b, c, _] = id.to_le_bytes();
    let mut bytes = vec![
        mavlink::MAV_STX_V2,
        length as u8,
        0,
        0,
        0,
        system,
        component,
        a,
        b,
        c,
    ];
    bytes.extend_from_slice(&payload[..length]);
    let checksum = mavlink::calculate_crc(&bytes[1..], MavMessage::extra_crc(id));
    bytes.extend_from_slice(&checksum.to_le_bytes());
    bytes
}
