//! `touchdown fly` against an autopilot's side that shares no code with it: `peer/autopilot.py`, made with pymavlink, over
//! a real socket and in real time. Nothing is asserted on timing.
#![allow(clippy::print_stderr)]

mod flight;
mod live;

use std::path::Path;

use crate::common::{fails, json, python};
use flight::{CARD, Case, replay};
use serde_json::Value;

#[test]
fn prop_a_vehicle_over_a_heaving_deck_is_landed_and_disarmed() {
    let Some(python) = python() else { return };
    for autopilot in ["px4", "ardupilot"] {
        let folder = tempfile::tempdir().unwrap();
        let peer = ["--autopilot", autopilot];
        let case = Case {
            peer: &peer,
            ..Case::default()
        };
        let flown = case.fly(&python, folder.path());
        flown.landed();
        assert_eq!(flown.theirs("parameters_set"), 0.0);
        assert_eq!(flown.theirs("mode_requests"), 0.0);
        assert!(flown.theirs("answered") > 0.0 && flown.theirs("heartbeats") > 0.0);
        assert!(flown.objects > 5, "one a second");
        for key in ["jitter", "reading_age"] {
            assert!(flown.ours["flight"][key]["p999_ms"].is_number(), "{key}");
        }
        let again = replay(folder.path());
        assert_eq!(again["difference"], Value::Null);
        assert_eq!(again["flight"], flown.ours["flight"]);
        let inspected = json(
            0,
            [
                "inspect".into(),
                folder.path().join("flight.mcap").into_os_string(),
            ],
        );
        assert!(inspected.to_string().contains("\"fly\""), "{inspected:#}");
        let findings = inspected["logs"][0]["findings"].to_string();
        assert!(!findings.contains("cannot be decoded"), "{findings}");
    }
}

#[test]
fn analytic_a_card_of_the_users_own_replaces_the_thrust_model() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("cards")).unwrap();
    std::fs::write(folder.path().join("cards/own.toml"), CARD).unwrap();
    let case = Case {
        tables: "[cards]\nthrust = \"cards/own.toml\"\n",
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    flown.landed();
    // Motor signal √(1.37 · 9.81) / 7.6 = 0.4824; through PX4's curve with THR_MDL_FAC = 0.3 it is 0.4075. The model of the
    // settings hovers at 0.420.
    let list = &flown.ours["flight"]["checklist"];
    assert!(list.to_string().contains("hover at 0.407"), "{list:#}");
    assert_eq!(replay(folder.path())["difference"], Value::Null);
}

#[test]
fn prop_a_pilot_who_takes_over_gets_no_setpoint_any_more() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        peer: &["--pilot", "takes-over"],
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    assert_eq!(flown.ending(), "pilot_took_over", "{}", flown.told());
    assert_eq!(flown.theirs["setpoints_after_take_over"], 0);
    assert_eq!(flown.theirs["mode_requests"], 0);
    assert_eq!(flown.theirs["armed"], true);
    assert_eq!(replay(folder.path())["difference"], Value::Null);
}

/// A fault in control, and what must come of it: the vehicle holds, by our request or by the autopilot's own failsafe.
fn holds(faults: &[(&str, &str)]) {
    let Some(python) = python() else { return };
    for (fault, ending) in faults {
        let folder = tempfile::tempdir().unwrap();
        let peer = ["--fault", fault];
        let case = Case {
            peer: &peer,
            ..Case::default()
        };
        let flown = case.fly(&python, folder.path());
        assert_eq!(flown.ending(), ending, "{fault}: {}", flown.told());
        assert_eq!(
            flown.theirs["setpoints_after_fault"],
            0,
            "{fault}: {}",
            flown.told()
        );
        assert_eq!(
            flown.theirs["in_offboard"],
            false,
            "{fault}: {}",
            flown.told()
        );
        assert_eq!(flown.theirs["armed"], true, "{fault}");
        assert!(
            flown.theirs("least_m") > 0.1,
            "{fault}: it touched the deck"
        );
        assert_eq!(replay(folder.path())["difference"], Value::Null, "{fault}");
    }
}

#[test]
fn prop_a_link_that_is_cut_or_slow_makes_the_vehicle_hold() {
    holds(&[("silent", "silent"), ("slow", "silent")]);
}

#[test]
fn prop_a_clock_that_jumps_makes_the_vehicle_hold() {
    holds(&[("restart", "clock_stepped"), ("jump", "clock_stepped")]);
}

#[test]
fn prop_absurd_readings_make_the_vehicle_hold() {
    holds(&[("nan", "stale"), ("yaw", "estimator_reset")]);
}

#[test]
fn prop_rejected_setpoints_and_a_second_autopilot_make_the_vehicle_hold() {
    holds(&[("reject", "rejected"), ("second", "other_autopilot")]);
}

#[test]
fn prop_damaged_cut_and_replayed_packets_prevent_no_landing() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        peer: &["--fault", "damage"],
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    flown.landed();
    let wire = &flown.ours["flight"]["wire"];
    assert!(wire["corrupt"].as_f64().unwrap() > 10.0, "{wire}");
}

#[test]
fn prop_signals_hand_the_vehicle_over_and_end_with_130() {
    for (signal, ignores_interrupts) in [
        ("interrupt", false),
        ("interrupt", true),
        ("terminate", false),
        ("hang up", false),
    ] {
        if signal == "hang up" && ignores_hang_ups() {
            eprintln!("skipped: under nohup the command goes on, as it should");
            continue;
        }
        signal_hands_the_vehicle_over(signal, ignores_interrupts);
    }
}

/// Whether this process, and so its children, ignore SIGHUP, as everything under nohup does: the lowest bit of the mask.
fn ignores_hang_ups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask & 1 == 1)
}

fn signal_hands_the_vehicle_over(signal: &str, ignores_interrupts: bool) {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        peer: &["--fault", signal, "--parameter", "COM_OF_LOSS_T=1.1"],
        ours: &["--set-parameters"],
        ignores_interrupts,
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    assert_eq!(flown.status, Some(130), "{}", flown.told());
    assert!(flown.said.contains("interrupted"), "{}", flown.told());
    assert!(flown.theirs("mode_requests") >= 1.0, "{}", flown.told());
    assert_eq!(flown.theirs["in_offboard"], false);
    assert_eq!(flown.theirs["setpoints_after_fault"], 0);
    assert!(flown.theirs("parameters_set") >= 2.0, "{}", flown.told());
    assert_eq!(
        flown.theirs["parameters_as_before"],
        true,
        "{}",
        flown.told()
    );
}

#[test]
fn prop_signals_hand_the_vehicle_over_beside_a_terminal_that_is_stopped() {
    let Some(python) = python() else { return };
    for signal in ["interrupt", "terminate"] {
        let folder = tempfile::tempdir().unwrap();
        let case = Case {
            peer: &["--fault", signal],
            unread: true,
            ..Case::default()
        };
        let flown = case.fly(&python, folder.path());
        assert_eq!(flown.status, Some(130), "{}", flown.told());
        assert!(flown.theirs("mode_requests") >= 1.0, "{}", flown.told());
        assert_eq!(flown.theirs["in_offboard"], false);
        assert_eq!(flown.theirs["setpoints_after_fault"], 0);
    }
}

#[test]
fn prop_a_killed_companion_leaves_a_vehicle_that_holds_and_a_recording() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        peer: &["--fault", "kill"],
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    assert_eq!(flown.status, None, "a signal");
    assert_eq!(flown.theirs["failsafe"], true, "{}", flown.told());
    assert_eq!(flown.theirs["mode_requests"], 0);
    let recording = folder.path().join("flight.mcap");
    let again = json(
        3,
        ["fly".into(), "--replay".into(), recording.into_os_string()],
    );
    assert_eq!(again["difference"], Value::Null);
    // The kill came 2 s after the switch, and a second at most is lost.
    assert!(
        again["flight"]["in_control_s"].as_f64().unwrap() > 0.9,
        "{again:#}"
    );
}

#[test]
fn prop_a_full_disk_makes_the_vehicle_hold() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        // The peer lets go when nobody flies.
        peer: &["--seconds", "25"],
        disk: Some(500),
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    assert_eq!(flown.status, Some(1), "{}", flown.told());
    assert_eq!(flown.theirs["armed"], true, "{}", flown.told());
    assert_eq!(flown.theirs["in_offboard"], false, "{}", flown.told());
}

#[test]
fn prop_tcp_and_a_serial_line_carry_a_flight_too() {
    let Some(python) = python() else { return };
    for link in ["tcp", "pty"] {
        let folder = tempfile::tempdir().unwrap();
        let peer = ["--link", link];
        let case = Case {
            peer: &peer,
            ..Case::default()
        };
        case.fly(&python, folder.path()).landed();
    }
}

#[test]
fn prop_a_signed_link_flies_and_an_unsigned_one_does_not() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("key"), "correct horse\n").unwrap();
    let tables = "[signing]\nkey_file = \"key\"\n";
    let case = Case {
        peer: &["--passphrase", "correct horse"],
        tables,
        ..Case::default()
    };
    case.fly(&python, folder.path()).landed();
    assert_eq!(replay(folder.path())["difference"], Value::Null);
    let case = Case {
        peer: &["--seconds", "4"],
        tables,
        ..Case::default()
    };
    let flown = case.fly(&python, folder.path());
    assert_eq!(flown.theirs("setpoints"), 0.0);
    assert!(!flown.said.contains("Checking"), "{}", flown.told());
}

#[test]
fn prop_two_processes_land_two_vehicles_at_once() {
    let Some(python) = python() else { return };
    std::thread::scope(|scope| {
        for (system, first) in [("7", "system_id = 7\n"), ("8", "system_id = 8\n")] {
            let python = &python;
            scope.spawn(move || {
                let folder = tempfile::tempdir().unwrap();
                let peer = ["--system", system, "--seed", system];
                let case = Case {
                    peer: &peer,
                    first,
                    ..Case::default()
                };
                let flown = case.fly(python, folder.path());
                flown.landed();
                assert_eq!(flown.ours["flight"]["system_id"].to_string(), system);
            });
        }
    });
}

#[test]
fn prop_arguments_and_settings_that_make_no_sense_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flight.toml");
    let refused = |content: &str| {
        std::fs::write(&file, content).unwrap();
        let out = folder.path().join("flight.mcap");
        let path = |path: &Path| path.to_str().unwrap().to_string();
        fails(
            2,
            [
                "fly".to_string(),
                path(&file),
                "--out".to_string(),
                path(&out),
            ],
        )
    };
    assert!(refused("lnk = \"x\"\n").contains("lnk"));
    assert!(refused("link = \"bluetooth:1\"\n").contains("is no address"));
    assert!(refused("[vehicle]\nmass_kg = -1.0\n").contains("vehicle.mass_kg"));
    let heavy = refused("[vehicle]\nmass_kg = 1e300\n");
    assert!(
        heavy.contains("weight is below") && heavy.contains("found 1e300"),
        "{heavy}"
    );
    assert!(refused("system_id = 300\n").contains("a whole number from 0 to 255"));
    assert!(refused("link = \"serial:/dev/ttyUSB0:0\"\n").contains("a baud rate above 0"));
    assert!(fails(1, ["fly", "--replay", "no-such.mcap"]).contains("no-such.mcap"));
    fails(2, ["fly"]);
}

#[test]
fn prop_a_recording_takes_the_place_of_no_file_that_the_flight_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("own.toml"), CARD).unwrap();
    let settings = "[cards]\nthrust = \"own.toml\"\n[signing]\nkey_file = \"key\"\n";
    std::fs::write(at("flight.toml"), settings).unwrap();
    std::fs::write(at("key"), "a pass phrase\n").unwrap();
    // Another name of the same file, without a path that leads from one to the other.
    std::fs::hard_link(at("flight.toml"), at("linked.mcap")).unwrap();
    std::fs::hard_link(at("own.toml"), at("card.mcap")).unwrap();
    for (out, what) in [
        ("flight.toml", "settings"),
        ("linked.mcap", "settings"),
        ("own.toml", "card"),
        ("card.mcap", "card"),
        ("key", "key"),
    ] {
        let before = std::fs::read(at(out)).unwrap();
        let command = ["fly", at("flight.toml").to_str().unwrap(), "--out"].map(str::to_owned);
        let said = fails(
            2,
            command.into_iter().chain([at(out).display().to_string()]),
        );
        assert!(
            said.contains(&format!("would replace the {what}")),
            "{said}"
        );
        assert_eq!(std::fs::read(at(out)).unwrap(), before);
    }
}
