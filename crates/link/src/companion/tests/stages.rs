//! The stages, in the order of a flight.

use super::*;

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
        let text = bench.companion.checklist().changes(&[]);
        assert_eq!(bench.companion.stage(), Stage::Ready, "{text}");
        assert!(bench.setpoints() > 50);
        let parameters = bench
            .sent
            .iter()
            .any(|m| matches!(m, MavMessage::PARAM_SET(_)));
        assert!(!parameters, "no parameter is changed");
        let summary = bench.companion.summary();
        assert_eq!(summary.firmware.unwrap().to_string(), "1.17.0");
        assert_eq!(bench.commands(MavCmd::MAV_CMD_DO_SET_MODE), 0);
    }
}

#[test]
fn prop_in_the_air_control_waits_until_the_weight_is_measured() {
    let mut bench = Bench::new();
    bench.mute.push(ATTITUDE_TARGET);
    bench.becomes_ready();
    bench.mute.clear();
    // Reports came for 2 s: a pilot who switches now is refused.
    bench.run(2.0);
    assert_eq!(bench.companion.stage(), Stage::Checking);
    // Who follows setpoints already is not measured, and gets none.
    bench.mode = OFFBOARD;
    bench.run(1.5);
    assert_eq!(bench.companion.stage(), Stage::Checked);
    bench.mode = POSITION;
    bench.run(3.0);
    assert_eq!(bench.companion.stage(), Stage::Ready);
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
fn prop_a_vehicle_that_follows_already_gets_no_setpoint_before_another_switch() {
    for begins_armed in [true, false] {
        let mut bench = Bench::new();
        (bench.mode, bench.armed) = (OFFBOARD, begins_armed);
        bench.run(10.0);
        // Arming is no switch either.
        bench.armed = true;
        bench.run(5.0);
        assert_eq!(bench.companion.stage(), Stage::Checked);
        assert_eq!(bench.setpoints(), 0);
        let said = bench.companion.take_notes().join("\n");
        assert!(said.contains("until the pilot leaves OFFBOARD"), "{said}");
        bench.mode = POSITION;
        // The weight is measured once the vehicle does not follow setpoints.
        bench.run(5.0);
        assert_eq!(bench.companion.stage(), Stage::Ready);
        bench.mode = OFFBOARD;
        bench.run(1.0);
        assert_eq!(bench.companion.stage(), Stage::InControl);
    }
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
    let bytes = |bench: &Bench| {
        let mut bytes = Vec::new();
        bench.companion.hold_bytes(&mut bytes);
        bytes.len()
    };
    assert_eq!(bytes(&Bench::ready()), 0);
    assert!(bytes(&Bench::flying()) > 0);
}

#[test]
fn prop_a_change_of_the_mode_is_seen_in_current_mode_too() {
    let mut bench = Bench::flying();
    bench.deliver(&MavMessage::CURRENT_MODE(CURRENT_MODE_DATA {
        custom_mode: POSITION,
        ..CURRENT_MODE_DATA::default()
    }));
    bench.ends(Stage::Ended, Ending::PilotTookOver);
}

#[test]
fn prop_reports_of_the_mode_and_echoed_setpoints_are_asked_for() {
    // PX4 refuses faster heartbeats; ArduPilot has no CURRENT_MODE.
    for (autopilot, id, interval_us) in [
        (PX4, 436.0, 2e4),
        (PX4, 83.0, 2e4),
        (MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA, 0.0, 1e5),
        (MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA, 83.0, 2e4),
    ] {
        let mut bench = Bench::with(autopilot, false);
        bench.becomes_ready();
        let asked = bench.sent.iter().any(|m| {
            matches!(m, MavMessage::COMMAND_LONG(m)
                if m.command == MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL && m.param1 == id && m.param2 == interval_us)
        });
        assert!(asked, "{id}");
    }
}

#[test]
fn prop_a_landed_vehicle_is_disarmed_until_it_says_so() {
    let mut bench = Bench::landed();
    bench.run(1.0);
    assert!((4..=7).contains(&bench.disarms()), "five times a second");
    bench.armed = false;
    bench.heartbeat();
    bench.ends(Stage::Ended, Ending::Landed);
    let disarms = bench.disarms();
    bench.run(2.0);
    assert_eq!(bench.disarms(), disarms);
}

#[test]
fn prop_a_pilot_who_takes_off_again_is_not_disarmed() {
    let mut bench = Bench::landed();
    bench.mode = POSITION;
    bench.heartbeat();
    let disarms = bench.disarms();
    bench.run(2.0);
    assert_eq!(bench.disarms(), disarms);
    bench.ends(Stage::Ended, Ending::PilotTookOver);
    // Without reports of the mode nobody knows who flies.
    let mut bench = Bench::landed();
    bench.mute = vec![0];
    bench.run(1.6);
    let disarms = bench.disarms();
    bench.run(2.0);
    assert_eq!(bench.disarms(), disarms);
}

#[test]
fn prop_ctrl_c_on_the_deck_waits_for_the_disarming() {
    let mut bench = Bench::landed();
    bench.event(Event::Stop);
    assert_eq!(bench.companion.stage(), Stage::Landed);
    bench.run(0.5);
    assert!(bench.disarms() > 1);
    bench.armed = false;
    bench.heartbeat();
    bench.ends(Stage::Ended, Ending::Landed);
    let mut bench = Bench::landed();
    bench.event(Event::Stop);
    bench.run(5.5);
    bench.ends(Stage::Ended, Ending::Stopped);
}

#[test]
fn prop_an_autopilot_with_another_system_id_is_named_once() {
    let mut bench = Bench::new();
    bench.companion.settings.system_id = 77;
    bench.run(4.0);
    assert_eq!(bench.companion.stage(), Stage::Waiting);
    let said = bench.companion.take_notes();
    let expected = "system_id: expected an autopilot with system id 77, found PX4 with system id 7: it is ignored";
    assert_eq!(said, [expected]);
}

#[test]
fn prop_an_autopilot_that_cannot_be_flown_and_a_silent_link_are_told_once() {
    let mut bench = Bench::new();
    bench.autopilot = MavAutopilot::MAV_AUTOPILOT_GENERIC;
    bench.run(15.0);
    assert_eq!(bench.companion.stage(), Stage::Waiting);
    let expected = "expected PX4 or ArduPilot of a multirotor, found MAV_AUTOPILOT_GENERIC of MAV_TYPE_QUADROTOR with system id 7: it is ignored";
    assert_eq!(bench.companion.take_notes(), [expected]);

    let mut bench = Bench::new();
    bench.mute = vec![0];
    bench.run(9.9);
    assert!(bench.companion.take_notes().is_empty());
    bench.run(15.0);
    let expected = "no heartbeat of an autopilot for 10 s: `link` must be the port to which it sends, at its speed";
    assert_eq!(bench.companion.take_notes(), [expected]);
    // It may come later.
    bench.mute = Vec::new();
    bench.run(2.0);
    assert_ne!(bench.companion.stage(), Stage::Waiting);
}
