//! Every transition and every fault of the companion, against an autopilot that hovers above a deck at rest.

use std::collections::BTreeMap;

use mavlink::Message as _;
use mavlink::dialects::common::*;
use proptest::prelude::*;

use super::{Companion, Ending, Event, Stage};
use crate::settings::FlightSettings;
use crate::wire::{Decoder, Encoder};

const PX4: MavAutopilot = MavAutopilot::MAV_AUTOPILOT_PX4;
const OFFBOARD: u32 = 6 << 16;
const POSITION: u32 = 3 << 16;
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
    /// How far the autopilot's clock is ahead, µs.
    ahead_us: u64,
    /// Height above the deck, m.
    height_m: f64,
    specific_force: f32,
    sent: Vec<MavMessage>,
}

/// What a test does to the bench.
type Fault = fn(&mut Bench);

impl Bench {
    fn new() -> Self {
        Self::with(PX4, false)
    }

    fn with(autopilot: MavAutopilot, take_control: bool) -> Self {
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
            ("GUID_OPTIONS", 8.0),
            ("GUID_TIMEOUT", 0.5),
            ("MOT_THST_EXPO", 0.0),
            ("MOT_THST_HOVER", hover),
            ("MOT_SPIN_MIN", 0.0),
            ("MOT_SPIN_MAX", 1.0),
            ("PLND_ENABLED", 0.0),
        ];
        Self {
            companion: Companion::new(&settings, take_control).unwrap(),
            encoder: Encoder::new(7, 1),
            now_us: 0,
            autopilot,
            mode: if autopilot == PX4 { POSITION } else { 5 },
            armed: true,
            parameters: parameters.into(),
            mute: Vec::new(),
            ahead_us: AHEAD_US,
            height_m: 0.8,
            specific_force: -9.81,
            sent: Vec::new(),
        }
    }

    /// A companion that is ready.
    fn ready() -> Self {
        let mut bench = Self::new();
        bench.run(8.0);
        assert_eq!(
            bench.companion.stage(),
            Stage::Ready,
            "{}",
            bench.companion.checklist().text()
        );
        bench
    }

    /// A companion in control.
    fn flying() -> Self {
        let mut bench = Self::ready();
        bench.mode = OFFBOARD;
        bench.run(1.5);
        assert_eq!(bench.companion.stage(), Stage::InControl);
        bench
    }

    fn boot_ms(&self) -> u32 {
        ((self.now_us + self.ahead_us) / 1000) as u32
    }

    fn deliver(&mut self, message: &MavMessage) {
        if self.mute.contains(&message.message_id()) {
            return;
        }
        let mut bytes = Vec::new();
        self.encoder.write(message, &mut bytes);
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
            MavMessage::PARAM_REQUEST_READ(m) => {
                let name = m.param_id.to_str().unwrap();
                let Some(value) = self.parameters.get(name).copied() else {
                    return;
                };
                let integer = self.autopilot == PX4 && name == "COM_OBL_RC_ACT";
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
            _ => {}
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
            autopilot: self.autopilot,
            base_mode: armed | MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
            ..HEARTBEAT_DATA::default()
        }));
    }

    fn readings(&mut self, tick: u64) {
        let time_boot_ms = self.boot_ms();
        self.deliver(&MavMessage::ATTITUDE_QUATERNION(ATTITUDE_QUATERNION_DATA {
            time_boot_ms,
            q1: 1.0,
            ..ATTITUDE_QUATERNION_DATA::default()
        }));
        if self.autopilot == PX4 {
            self.deliver(&MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
                time_usec: u64::from(time_boot_ms) * 1000,
                zacc: self.specific_force,
                ..HIGHRES_IMU_DATA::default()
            }));
        } else {
            self.deliver(&MavMessage::SCALED_IMU(SCALED_IMU_DATA {
                time_boot_ms,
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
                z: self.height_m as f32,
                position_valid: MavBool::MAV_BOOL_TRUE,
                ..LANDING_TARGET_DATA::default()
            }));
            self.deliver(&MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms,
                ..LOCAL_POSITION_NED_DATA::default()
            }));
        }
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.now_us += 10_000;
            let tick = self.now_us / 10_000;
            if tick.is_multiple_of(100) {
                self.heartbeat();
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

    fn ends(&self, stage: Stage, ending: Ending) {
        let summary = self.companion.summary();
        assert_eq!((summary.stage, summary.ending), (stage, Some(ending)));
    }
}

#[test]
fn prop_nothing_is_asked_of_an_autopilot_that_was_not_heard() {
    let mut bench = Bench::new();
    bench.mute = vec![0];
    bench.run(3.0);
    assert_eq!(bench.companion.stage(), Stage::Waiting);
    assert!(bench.sent.iter().all(|m| m.message_id() == 0));
    assert_eq!(bench.sent.len(), 3, "heartbeats at 1 Hz");
}

#[test]
fn prop_a_good_checklist_and_a_known_deck_make_the_companion_ready() {
    for autopilot in [PX4, MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA] {
        let mut bench = Bench::with(autopilot, false);
        bench.run(0.5);
        assert_eq!(bench.companion.stage(), Stage::Waiting, "no heartbeat yet");
        bench.run(7.5);
        let text = bench.companion.checklist().text();
        assert_eq!(bench.companion.stage(), Stage::Ready, "{text}");
        assert!(bench.setpoints() > 50);
        let parameters = bench
            .sent
            .iter()
            .any(|m| matches!(m, MavMessage::PARAM_SET(_)));
        assert!(!parameters, "no parameter is changed");
        assert_eq!(bench.commands(MavCmd::MAV_CMD_DO_SET_MODE), 0);
    }
}

#[test]
fn prop_no_setpoint_while_disarmed_or_refused_or_blind() {
    let cases: [(&str, Fault, Stage); 6] = [
        ("disarmed", |b| b.armed = false, Stage::Checked),
        (
            "a failsafe that lands",
            |b| {
                b.parameters.insert("COM_OBL_RC_ACT", f32::from_bits(4));
            },
            Stage::Checking,
        ),
        (
            "a parameter that is not answered",
            |b| {
                b.parameters.remove("COM_OBL_RC_ACT");
            },
            Stage::Checking,
        ),
        ("no target", |b| b.mute = vec![149], Stage::Checking),
        ("no range", |b| b.mute = vec![132], Stage::Checking),
        ("no time", |b| b.mute = vec![111], Stage::Checking),
    ];
    for (name, fault, stage) in cases {
        let mut bench = Bench::new();
        fault(&mut bench);
        bench.run(8.0);
        assert_eq!(
            (bench.companion.stage(), bench.setpoints()),
            (stage, 0),
            "{name}"
        );
        bench.mode = OFFBOARD;
        bench.run(2.0);
        assert_eq!(
            (bench.companion.stage(), bench.setpoints()),
            (stage, 0),
            "{name}"
        );
    }
}

#[test]
fn prop_a_mode_that_the_vehicle_already_has_is_no_switch() {
    let mut bench = Bench::new();
    bench.mode = OFFBOARD;
    bench.run(10.0);
    assert_eq!(bench.companion.stage(), Stage::Ready);
    bench.mode = POSITION;
    bench.run(1.0);
    bench.mode = OFFBOARD;
    bench.run(1.0);
    assert_eq!(bench.companion.stage(), Stage::InControl);
}

#[test]
fn prop_it_takes_control_itself_only_where_it_may() {
    let mut bench = Bench::with(PX4, true);
    bench.run(10.0);
    assert!(bench.commands(MavCmd::MAV_CMD_DO_SET_MODE) >= 1);
    let mut bench = Bench::new();
    bench.run(10.0);
    assert_eq!(bench.commands(MavCmd::MAV_CMD_DO_SET_MODE), 0);
}

#[test]
fn prop_another_mode_ends_control_for_good() {
    let mut bench = Bench::flying();
    bench.mode = POSITION;
    bench.heartbeat();
    bench.ends(Stage::Ended, Ending::PilotTookOver);
    let before = (bench.setpoints(), bench.sent.len());
    bench.run(2.0);
    bench.mode = OFFBOARD;
    bench.run(3.0);
    assert_eq!(bench.setpoints(), before.0);
    assert_eq!(bench.sent.len(), before.1 + 5, "heartbeats alone");
}

#[test]
fn prop_faults_in_control_hand_the_vehicle_over_and_nothing_descends_on_old_data() {
    let cases: [(&str, Fault, f64, Ending); 8] = [
        (
            "silence",
            |b| b.mute = (0..500).collect(),
            1.0,
            Ending::Silent,
        ),
        ("no attitude", |b| b.mute = vec![31], 1.0, Ending::Stale),
        (
            "no specific force",
            |b| b.mute = vec![105],
            1.0,
            Ending::Stale,
        ),
        ("restart", |b| b.ahead_us = 0, 1.0, Ending::ClockStepped),
        ("NaN", |b| b.specific_force = f32::NAN, 1.0, Ending::Stale),
        (
            "another autopilot with the same id",
            |b| {
                b.autopilot = MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA;
                b.heartbeat();
            },
            0.1,
            Ending::OtherAutopilot,
        ),
        ("Ctrl-C", |b| b.event(Event::Stop), 0.1, Ending::Stopped),
        (
            "disarmed by another",
            |b| b.armed = false,
            1.0,
            Ending::Disarmed,
        ),
    ];
    for (name, fault, seconds, ending) in cases {
        let mut bench = Bench::flying();
        fault(&mut bench);
        bench.run(seconds);
        let summary = bench.companion.summary();
        assert_eq!(summary.ending, Some(ending), "{name}");
        let over = summary.stage == Stage::Ended;
        assert!(
            over || bench.commands(MavCmd::MAV_CMD_DO_SET_MODE) > 0,
            "{name}"
        );
        let before = bench.setpoints();
        bench.run(8.0);
        assert_eq!(
            bench.setpoints(),
            before,
            "{name}: a setpoint after the hand-over"
        );
        assert_eq!(bench.companion.stage(), Stage::Ended, "{name}");
    }
}

#[test]
fn prop_a_clock_that_steps_ahead_is_a_fault() {
    let mut bench = Bench::flying();
    // Readings seem to come from the future until the clocks agree again.
    bench.ahead_us += 100_000;
    bench.run(1.0);
    bench.ends(Stage::HandingOver, Ending::ClockStepped);
}

#[test]
fn prop_the_holding_mode_that_the_autopilot_enters_ends_the_hand_over() {
    let mut bench = Bench::flying();
    bench.event(Event::Stop);
    let holds = bench.commands(MavCmd::MAV_CMD_DO_SET_MODE);
    assert_eq!(holds, 1);
    bench.mode = (4 << 16) | (3 << 24);
    bench.heartbeat();
    bench.ends(Stage::Ended, Ending::Stopped);
}

#[test]
fn prop_without_range_or_target_the_vehicle_does_not_descend() {
    for mute in [132, 149] {
        let mut bench = Bench::flying();
        bench.mute = vec![mute];
        bench.run(5.0);
        let phase = bench.companion.summary().phase;
        use touchdown_lander::state_machine::Phase;
        assert!(
            !matches!(
                phase,
                Some(Phase::Descend | Phase::Commit | Phase::Touchdown)
            ),
            "{mute}: {phase:?}"
        );
    }
}

#[test]
fn prop_other_systems_are_skipped_and_counted() {
    let mut bench = Bench::flying();
    let before = bench.companion.summary().other_senders;
    let ours = bench.encoder;
    bench.encoder = Encoder::new(8, 1);
    bench.mode = POSITION;
    bench.heartbeat();
    bench.readings(6);
    bench.encoder = ours;
    assert_eq!(bench.companion.stage(), Stage::InControl);
    assert_eq!(bench.companion.summary().other_senders, before + 6);
}

#[test]
fn prop_timesync_is_answered_with_our_time() {
    let mut bench = Bench::flying();
    bench.deliver(&MavMessage::TIMESYNC(TIMESYNC_DATA {
        ts1: 123,
        ..TIMESYNC_DATA::default()
    }));
    let answer = bench.sent.last().cloned();
    let Some(MavMessage::TIMESYNC(answer)) = answer else {
        panic!("{answer:?}");
    };
    assert_eq!((answer.tc1, answer.ts1), (bench.now_us as i64 * 1000, 123));
}

#[test]
fn prop_hold_bytes_exist_only_in_control() {
    assert!(Bench::ready().companion.hold_bytes().is_none());
    assert!(Bench::flying().companion.hold_bytes().is_some());
}

/// What may happen, in any order.
#[derive(Clone, Debug)]
enum Happening {
    Heartbeat(u32, bool),
    Readings(f64, f32),
    Ticks(u8),
    Bytes(Vec<u8>),
    Sync(i64, i64),
    Parameter(f32),
    Pause(u32),
    Stop,
}

fn happening() -> impl Strategy<Value = Happening> {
    prop_oneof![
        3 => (prop_oneof![Just(OFFBOARD), Just(POSITION), any::<u32>()], any::<bool>())
            .prop_map(|(mode, armed)| Happening::Heartbeat(mode, armed)),
        4 => (0.0..3.0_f64, prop_oneof![Just(-9.81_f32), any::<f32>()])
            .prop_map(|(height, force)| Happening::Readings(height, force)),
        4 => (1..40_u8).prop_map(Happening::Ticks),
        1 => proptest::collection::vec(any::<u8>(), 0..80).prop_map(Happening::Bytes),
        1 => (any::<i64>(), any::<i64>()).prop_map(|(a, b)| Happening::Sync(a, b)),
        1 => any::<f32>().prop_map(Happening::Parameter),
        1 => any::<u32>().prop_map(Happening::Pause),
        1 => Just(Happening::Stop),
    ]
}

fn happen(bench: &mut Bench, happening: &Happening) {
    match happening {
        Happening::Heartbeat(mode, armed) => {
            (bench.mode, bench.armed) = (*mode, *armed);
            bench.heartbeat();
        }
        Happening::Readings(height_m, force) => {
            (bench.height_m, bench.specific_force) = (*height_m, *force);
            bench.now_us += 1000;
            bench.readings(6);
        }
        Happening::Ticks(count) => bench.run(f64::from(*count) * 0.01),
        Happening::Bytes(bytes) => bench.event(Event::Received(bytes)),
        Happening::Sync(tc1, ts1) => bench.deliver(&MavMessage::TIMESYNC(TIMESYNC_DATA {
            tc1: *tc1,
            ts1: *ts1,
            ..TIMESYNC_DATA::default()
        })),
        Happening::Parameter(value) => bench.deliver(&MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: *value,
            param_id: "THR_MDL_FAC".into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            ..PARAM_VALUE_DATA::default()
        })),
        Happening::Pause(us) => bench.now_us += u64::from(*us) % 3_000_000,
        Happening::Stop => bench.event(Event::Stop),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    /// Whatever happens: no panic, no setpoint that is not finite, and none after the end.
    #[test]
    fn prop_no_sequence_yields_a_setpoint_after_a_take_over(
        flies in any::<bool>(),
        sequence in proptest::collection::vec(happening(), 0..40),
    ) {
        let mut bench = if flies { Bench::flying() } else { Bench::new() };
        let mut after_end = None;
        for each in &sequence {
            let stage = bench.companion.stage();
            happen(&mut bench, each);
            for message in &bench.sent {
                if let MavMessage::SET_ATTITUDE_TARGET(m) = message {
                    prop_assert!(m.q.iter().all(|c| c.is_finite()) && (0.0..=1.0).contains(&m.thrust));
                }
            }
            if stage == Stage::Ended {
                prop_assert_eq!(bench.companion.stage(), Stage::Ended);
                prop_assert_eq!(bench.setpoints(), after_end.unwrap_or(0));
            }
            if matches!(stage, Stage::HandingOver) {
                prop_assert!(matches!(bench.companion.stage(), Stage::HandingOver | Stage::Ended));
            }
            after_end = Some(bench.setpoints());
        }
    }
}
