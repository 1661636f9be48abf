//! Every fault, and what happens.

use super::*;

#[test]
fn prop_faults_in_control_hand_the_vehicle_over_and_nothing_descends_on_old_data() {
    let cases: [(&str, Fault, f64, Ending); 16] = [
        ("no mode", |b| b.mute = vec![0], 4.0, Ending::ModeUnknown),
        (
            "a reset of the heading",
            |b| b.yaw_rad = 0.5,
            0.1,
            Ending::EstimatorReset,
        ),
        (
            "rejected setpoints",
            |b| b.follows = Some(0.98),
            2.0,
            Ending::Rejected,
        ),
        ("a slow link", |b| b.late_us = 400_000, 1.0, Ending::Stale),
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
        (
            "an attitude that is frozen",
            |b| b.frozen = vec![31],
            1.0,
            Ending::Stale,
        ),
        (
            "a specific force that is frozen",
            |b| b.frozen = vec![105],
            1.0,
            Ending::Stale,
        ),
        ("restart", |b| b.ahead_us = 0, 1.0, Ending::ClockStepped),
        ("NaN", |b| b.specific_force = f32::NAN, 1.0, Ending::Stale),
        (
            "a specific force of zero",
            |b| b.specific_force = 0.0,
            0.6,
            Ending::Stale,
        ),
        (
            "a specific force upside down",
            |b| b.specific_force = 9.81,
            0.6,
            Ending::Stale,
        ),
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
        let unknown = ending == Ending::ModeUnknown;
        assert!(over || unknown || bench.holds() > 0, "{name}");
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
fn prop_without_target_the_vehicle_does_not_descend() {
    use touchdown_lander::state_machine::Phase;
    // The target gives the height as well, so that a range may be missing.
    for (mute, frozen, descends) in [
        (vec![149], vec![], false),
        (vec![132, 149], vec![], false),
        (vec![132], vec![], true),
        (vec![], vec![149], false),
        (vec![132], vec![149], false),
    ] {
        let mut bench = Bench::flying();
        bench.mute.clone_from(&mute);
        bench.frozen.clone_from(&frozen);
        // The last reading counts for 0.3 s.
        bench.run(0.5);
        let mut phases = Vec::new();
        for _ in 0..50 {
            bench.run(0.1);
            phases.extend(bench.companion.summary().phase);
        }
        let down =
            |phase: &Phase| matches!(phase, Phase::Descend | Phase::Commit | Phase::Touchdown);
        assert_eq!(
            phases.iter().any(down),
            descends,
            "{mute:?} {frozen:?}: {phases:?}"
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
fn prop_a_holding_mode_is_asked_for_only_while_nobody_else_can_have_changed_the_mode() {
    let mut bench = Bench::flying();
    bench.mute = vec![0];
    bench.event(Event::Stop);
    bench.run(1.5);
    let holds = bench.holds();
    assert!(holds > 0);
    bench.run(5.0);
    assert_eq!(bench.holds(), holds, "the newest heartbeat is too old");
    bench.ends(Stage::Ended, Ending::Stopped);
}

#[test]
fn prop_a_holding_mode_that_was_accepted_is_not_asked_for_again() {
    // PX4 accepts at once, but reports the new mode only with its next heartbeat: a pilot may have changed it since, and a
    // second request, or one for a mode that holds the altitude alone, would take that from the pilot.
    let accepts = |result| COMMAND_ACK_DATA {
        command: MavCmd::MAV_CMD_DO_SET_MODE,
        result,
        ..COMMAND_ACK_DATA::default()
    };
    for (result, asked) in [
        (MavResult::MAV_RESULT_ACCEPTED, 1),
        (MavResult::MAV_RESULT_TEMPORARILY_REJECTED, 5),
    ] {
        let mut bench = Bench::flying();
        bench.event(Event::Stop);
        bench.deliver(&MavMessage::COMMAND_ACK(accepts(result)));
        bench.run(0.9);
        assert_eq!(bench.holds(), asked, "{result:?}");
    }
    // An answer to the switch before control says nothing on the hand-over.
    let mut bench = Bench::flying();
    bench.deliver(&MavMessage::COMMAND_ACK(accepts(
        MavResult::MAV_RESULT_ACCEPTED,
    )));
    bench.event(Event::Stop);
    assert_eq!(bench.holds(), 1);
}

#[test]
fn regress_requests_into_a_cut_link_do_not_count() {
    let mut bench = Bench::flying();
    // The mode is known for 1.5 s from now on: seven requests go into the cut link.
    bench.heartbeat();
    bench.mute = (0..500).collect();
    bench.run(2.0);
    bench.ends(Stage::HandingOver, Ending::Silent);
    assert!(bench.holds() > 5, "{}", bench.holds());
    bench.mute.clear();
    bench.sent.clear();
    bench.run(1.2);
    let first = bench.sent.iter().find_map(|m| match m {
        MavMessage::COMMAND_LONG(m) => Some((m.command, m.param2, m.param3)),
        _ => None,
    });
    // AUTO.LOITER, which holds the position.
    assert_eq!(first, Some((MavCmd::MAV_CMD_DO_SET_MODE, 4.0, 3.0)));
}

#[test]
fn prop_a_second_autopilot_of_the_same_kind_and_id_is_noticed() {
    let mut bench = Bench::flying();
    let mut other = Encoder::new(7, 1);
    for _ in 0..100 {
        bench.readings(6);
        bench.now_us += 1000;
        let before = std::mem::replace(&mut bench.encoder, other);
        bench.readings(6);
        other = std::mem::replace(&mut bench.encoder, before);
    }
    assert_eq!(
        bench.companion.summary().ending,
        Some(Ending::OtherAutopilot)
    );
}

#[test]
fn prop_a_replayed_burst_is_ignored() {
    let mut bench = Bench::flying();
    let mut burst = Vec::new();
    let mut encoder = bench.encoder.clone();
    for _ in 0..20 {
        let old = ATTITUDE_QUATERNION_DATA {
            time_boot_ms: bench.boot_ms() - 100,
            q3: 1.0,
            ..ATTITUDE_QUATERNION_DATA::default()
        };
        encoder.write(&MavMessage::ATTITUDE_QUATERNION(old), &mut burst);
    }
    let before = bench.companion.summary().ignored_readings.repeated;
    bench.event(Event::Received(&burst));
    bench.run(1.0);
    assert_eq!(bench.companion.stage(), Stage::InControl);
    assert_eq!(
        bench.companion.summary().ignored_readings.repeated,
        before + 20
    );
}

#[test]
fn prop_damaged_and_cut_frames_are_skipped_and_counted() {
    let mut bench = Bench::flying();
    let mut bytes = Vec::new();
    let heartbeat = HEARTBEAT_DATA {
        custom_mode: POSITION,
        ..HEARTBEAT_DATA::default()
    };
    bench
        .encoder
        .clone()
        .write(&MavMessage::HEARTBEAT(heartbeat), &mut bytes);
    let cut = &bytes[..bytes.len() - 3];
    let mut wrong = bytes.clone();
    wrong[12] ^= 4;
    bench.event(Event::Received(&wrong));
    bench.event(Event::Received(cut));
    bench.run(1.0);
    assert_eq!(bench.companion.stage(), Stage::InControl);
    assert!(bench.companion.summary().wire.corrupt >= 2);
}

#[test]
fn prop_an_empty_battery_ends_the_landing() {
    let mut bench = Bench::flying();
    bench.battery = 2;
    bench.run(150.0);
    let summary = bench.companion.summary();
    use touchdown_lander::state_machine::Phase;
    assert!(
        !matches!(
            summary.phase,
            Some(Phase::Descend | Phase::Commit | Phase::Touchdown | Phase::Disarmed)
        ) || bench.battery > 0,
        "{:?}",
        summary.phase
    );
}

#[test]
fn prop_a_parameter_that_turns_absurd_sends_no_absurd_setpoint() {
    for absurd in [f32::NAN, f32::INFINITY, -3.0e38] {
        let mut bench = Bench::ready();
        bench.parameters.insert("THR_MDL_FAC", absurd);
        bench.parameter("THR_MDL_FAC");
        bench.run(1.0);
        assert_eq!(bench.companion.stage(), Stage::Checking);
        let usable = |m: &MavMessage| match m {
            MavMessage::SET_ATTITUDE_TARGET(m) => (0.0..=1.0).contains(&m.thrust),
            _ => true,
        };
        assert!(bench.sent.iter().all(usable));
    }
}

#[test]
fn prop_a_companion_that_was_stopped_for_seconds_sends_no_setpoint() {
    let mut bench = Bench::flying();
    bench.now_us += 2_000_000;
    let before = bench.setpoints();
    bench.event(Event::Tick);
    assert_eq!(bench.setpoints(), before);
    bench.ends(Stage::HandingOver, Ending::Silent);
}

#[test]
fn prop_after_a_standstill_nothing_follows_a_take_over_that_had_not_been_read() {
    // The pilot takes over while the process stands still: reports of before and after wait in its buffers.
    for standstill_us in [300_000, 500_000, 1_000_000, 3_000_000] {
        for ticks_first in [false, true] {
            let mut bench = Bench::flying();
            bench.run(0.5);
            let (setpoints, holds) = (bench.setpoints(), bench.holds());
            bench.now_us += standstill_us;
            if ticks_first {
                bench.event(Event::Tick);
            }
            bench.now_us += 2_000;
            bench.heartbeat();
            for _ in 0..3 {
                bench.now_us += 10_000;
                bench.event(Event::Tick);
            }
            bench.mode = POSITION;
            bench.heartbeat();
            bench.run(8.0);
            let name = format!("{standstill_us} {ticks_first}");
            assert_eq!(bench.setpoints(), setpoints, "{name}");
            assert_eq!(bench.holds(), holds, "{name}");
            assert_eq!(bench.companion.stage(), Stage::Ended, "{name}");
        }
    }
}

#[test]
fn prop_a_companion_that_stood_still_goes_on_or_asks_for_a_holding_mode() {
    let mut bench = Bench::flying();
    bench.now_us += 300_000;
    let before = bench.setpoints();
    bench.run(1.0);
    assert_eq!(bench.companion.stage(), Stage::InControl);
    // A hundred ticks but those of the first 0.1 s.
    assert_eq!(bench.setpoints() - before, 90);
    for standstill_us in [1_000_000, 3_000_000] {
        let mut bench = Bench::flying();
        bench.now_us += standstill_us;
        bench.event(Event::Tick);
        bench.run(2.5);
        assert!(bench.holds() > 0, "{standstill_us}");
    }
}
