//! `touchdown simulator` with an autopilot's side that shares no code with it: `peer/simulated.py`, made with pymavlink, which
//! the command starts in place of PX4 or ArduPilot. Simulated time runs as fast as the machine can; nothing is asserted on
//! real time.
#![allow(clippy::print_stderr)]
#![cfg(unix)]

use crate::common;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::common::{PATIENT, fails, peer_program, python, text};
use serde_json::Value;

/// The paper's deck; a landing that has not ended 40 s after the deck's release is over.
const DECK: &str = r#"seed = 3
[scenario]
timeout_s = 40.0
[scenario.deck]
kind = "sines"
[[scenario.deck.tones]]
axis = "heave"
amplitude = 0.05
frequency_hz = 0.5
"#;

/// A folder with the scenario, the companion's settings, and the peer where the command looks for the autopilot.
fn prepared(python: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    peer_program(folder.path(), python);
    std::fs::write(folder.path().join("deck.toml"), DECK).unwrap();
    std::fs::write(folder.path().join("fly.toml"), PATIENT).unwrap();
    folder
}

/// Runs the command in a folder whose temporary files are its own.
fn simulated(folder: &Path, autopilot: &str, fault: &str, more: &[&str]) -> Output {
    let scratch = folder.join("scratch");
    std::fs::create_dir_all(&scratch).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_touchdown"));
    command.args(["--json", "simulator", autopilot]);
    command.arg(folder.join("deck.toml"));
    command.arg("--autopilot").arg(folder.join("px4/bin/px4"));
    command.arg("--out").arg(folder.join("out"));
    command.args(["--speed", "0"]).args(more);
    command.env("TMPDIR", &scratch).env("PEER_FAULT", fault);
    let output = command.output().unwrap();
    let left: Vec<_> = std::fs::read_dir(&scratch).unwrap().collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    output
}

fn landed(output: &Output) -> Value {
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    let results: Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {said}"));
    assert_eq!(results["reproducible_to_the_bit"], false);
    let landing = results["landings"][0].clone();
    assert_eq!(landing["outcome"], "landed", "{landing}: {said}");
    landing
}

#[test]
fn xval_the_companion_lands_over_both_autopilots_sides() {
    let Some(python) = python() else { return };
    for autopilot in ["px4", "ardupilot"] {
        let folder = prepared(&python);
        let fly = folder.path().join("fly.toml");
        // The simulated camera takes the place of the one that the settings name.
        let camera = "[camera]\ncommand = [\"no such program\"]\n";
        std::fs::write(&fly, format!("{PATIENT}\n{camera}")).unwrap();
        let output = simulated(
            folder.path(),
            autopilot,
            "none",
            &["--with", fly.to_str().unwrap()],
        );
        let landing = landed(&output);
        // The deck's greatest speed is 0.16 m/s: a landing that ignored it would touch at up to that plus its own descent.
        assert!(landing["v_l_mps"].as_f64().unwrap() < 0.25, "{landing}");
        assert!(
            landing["stopped_after_s"].as_f64().unwrap() < 2.0,
            "{landing}"
        );
        assert_eq!(landing["companion"]["ending"], "landed", "{landing}");
        let out = folder.path().join("out");
        assert!(out.join("truth-0.parquet").is_file());
        let replayed = Command::new(env!("CARGO_BIN_EXE_touchdown"))
            .args(["--json", "fly", "--replay"])
            .arg(out.join("flight-0.mcap"))
            .output()
            .unwrap();
        assert!(replayed.status.success(), "{}", text(&replayed.stderr));
    }
}

#[test]
fn xval_the_companion_finds_the_pad_in_rendered_images() {
    let Some(python) = python() else { return };
    let folder = prepared(&python);
    // A third of the images of the defaults, for time.
    let slow = "[scenario.sensors.tag.schedule]\nrate_hz = 10.0\n";
    std::fs::write(folder.path().join("deck.toml"), format!("{DECK}{slow}")).unwrap();
    let fly = folder.path().join("fly.toml");
    std::fs::write(&fly, format!("{PATIENT}\n[camera]\nrate_hz = 10.0\n")).unwrap();
    let frames = folder.path().join("frames");
    let companion = ["--with", fly.to_str().unwrap(), "--camera", "rendered"];
    let more = [&companion[..], &["--frames", frames.to_str().unwrap()]].concat();
    let landing = landed(&simulated(folder.path(), "px4", "none", &more));
    assert_eq!(landing["companion"]["ending"], "landed", "{landing}");
    // The deck's greatest speed is 0.16 m/s.
    assert!(landing["v_l_mps"].as_f64().unwrap() < 0.25, "{landing}");
    let table = std::fs::read_to_string(frames.join("0/times.csv")).unwrap();
    let images = table.lines().skip(1);
    let named = images.clone().map(|line| line.split(',').next().unwrap());
    assert!(named.clone().count() > 100, "{table}");
    for name in named {
        assert!(frames.join("0").join(name).is_file(), "{name}");
    }
}

#[test]
fn xval_an_autopilot_lands_in_its_own_mode_amid_garbage_and_a_skipped_answer() {
    let Some(python) = python() else { return };
    for (autopilot, fault) in [
        ("px4", "garbage"),
        ("ardupilot", "garbage"),
        ("px4", "skips"),
        ("ardupilot", "skips"),
    ] {
        let folder = prepared(&python);
        let landing = landed(&simulated(
            folder.path(),
            autopilot,
            fault,
            &["--own-landing"],
        ));
        // It descends at 0.3 m/s on a deck that moves at up to 0.16 m/s.
        let speed_mps = landing["v_l_mps"].as_f64().unwrap();
        assert!((0.05..0.55).contains(&speed_mps), "{landing}");
        // ArduPilot sends late what it withheld.
        let missed = u64::from(fault == "skips" && autopilot == "px4");
        assert!(
            landing["missed_answers"].as_u64().unwrap() >= missed,
            "{landing}"
        );
    }
}

#[test]
fn prop_an_autopilot_that_ends_or_falls_silent_is_an_error_that_leaves_nothing() {
    let Some(python) = python() else { return };
    for (autopilot, fault) in [("px4", "ends"), ("px4", "silent"), ("ardupilot", "silent")] {
        let folder = prepared(&python);
        let output = simulated(folder.path(), autopilot, fault, &["--own-landing"]);
        assert_eq!(output.status.code(), Some(1), "{autopilot} {fault}");
        let said = text(&output.stderr);
        assert!(said.contains("the autopilot"), "{said}");
        if fault == "ends" {
            assert!(said.contains("as a crashed autopilot does"), "{said}");
            assert!(said.contains("its process ended (exit status: "), "{said}");
        }
    }
}

#[test]
fn prop_ctrl_c_ends_the_autopilot_and_leaves_nothing() {
    if common::ignores_interrupts() {
        return;
    }
    let Some(python) = python() else { return };
    let folder = prepared(&python);
    let scratch = folder.path().join("scratch");
    std::fs::create_dir_all(&scratch).unwrap();
    let mut ours = Command::new(env!("CARGO_BIN_EXE_touchdown"))
        .args(["simulator", "px4"])
        .arg(folder.path().join("deck.toml"))
        .arg("--autopilot")
        .arg(folder.path().join("px4/bin/px4"))
        .arg("--out")
        .arg(folder.path().join("out"))
        .args(["--own-landing", "--speed", "1"])
        .env("TMPDIR", &scratch)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The first lines come when the deck is released, some seconds after the start.
    let mut said = BufReader::new(ours.stderr.take().unwrap());
    let mut first = String::new();
    said.read_line(&mut first).unwrap();
    assert!(first.contains("above the deck"), "{first}");
    let pid = ours.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &pid])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(ours.wait().unwrap().code(), Some(130));
    let mut rest = String::new();
    said.read_to_string(&mut rest).unwrap();
    assert!(rest.contains("interrupted"), "{rest}");
    let left: Vec<_> = std::fs::read_dir(&scratch).unwrap().collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

#[test]
fn prop_a_program_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("deck.toml"), DECK).unwrap();
    let output = simulated(folder.path(), "px4", "none", &["--own-landing"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("the autopilot's program"), "{said}");
}

#[test]
fn prop_a_deck_that_drives_away_and_results_in_place_of_a_scenario_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sweep.toml");
    let refused = |scenario: &str, out: &Path, command: &[&str]| {
        std::fs::write(&file, scenario).unwrap();
        let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
        let said = fails(2, [command, &[file, "--out", out]].concat());
        assert_eq!(std::fs::read_to_string(file).unwrap(), scenario);
        said
    };
    let elsewhere = folder.path().join("out");
    let simulator: [&str; 2] = ["simulator", "px4"];
    let course = "[scenario.course]\nspeed_mps = 0.5\n";
    for (scenario, command) in [
        (course.to_owned(), &simulator[..]),
        (
            format!("autopilot = \"px4\"\n[software_in_the_loop]\nprogram = \"px4\"\n{course}"),
            &["campaign"],
        ),
        (
            "autopilot = \"px4\"\n[software_in_the_loop]\nprogram = \"px4\"\n[grid]\n\"course.speed_mps\" = [0.5]\n".to_owned(),
            &["campaign"],
        ),
    ] {
        let said = refused(&scenario, &elsewhere, command);
        assert!(said.contains("scenario.course") && said.contains("under way"), "{said}");
        assert!(!elsewhere.exists());
    }
    for command in [&simulator[..], &["land", "--space"]] {
        let said = refused("# mine\nseed = 2\n", folder.path(), command);
        assert!(said.contains("would replace the scenario"), "{said}");
    }
    let scenario = folder.path().join("scenario.toml");
    std::fs::write(&scenario, "# mine\nseed = 2\n").unwrap();
    let [given, out] = [&scenario, folder.path()].map(|path: &Path| path.to_str().unwrap());
    let said = fails(2, ["land", given, "--out", out]);
    assert!(said.contains("would replace the scenario"), "{said}");
    assert!(
        std::fs::read_to_string(&scenario)
            .unwrap()
            .starts_with("# mine")
    );
}

#[test]
fn prop_a_companion_for_another_vehicle_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("fly.toml"), "").unwrap();
    let warned = |scenario: &str| {
        std::fs::write(at("deck.toml"), scenario).unwrap();
        let said = fails(
            2,
            [
                "simulator",
                "px4",
                &at("deck.toml"),
                "--with",
                &at("fly.toml"),
                "--autopilot",
                &at("none"),
                "--out",
                &at("out"),
            ],
        );
        assert!(said.contains("the autopilot's program"), "{said}");
        said.contains("a vehicle of 1.37 kg")
    };
    // A payload makes no other vehicle; the next size is one.
    let payload = "[scenario.plant]\nmass_kg = 1.5\n";
    let size = "[vehicle]\npreset = \"quadrotor_4kg\"\n";
    assert_eq!(["", payload, size].map(warned), [false, false, true]);
}

#[test]
fn regress_a_wait_for_an_autopilot_is_reported_with_its_address() {
    if common::ignores_interrupts() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("deck.toml");
    std::fs::write(&deck, DECK).unwrap();
    let out = folder.path().join("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_touchdown"));
    command
        .args(["simulator", "px4"])
        .arg(&deck)
        .arg("--out")
        .arg(&out);
    // A port that the instances of the other tests do not use.
    command.args(["--instance", "9"]);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    // The test program stops what waits without a line.
    let (id, waited) = (child.id(), std::time::Duration::from_secs(20));
    let stop = std::thread::spawn(move || {
        std::thread::park_timeout(waited);
        let signal = Command::new("kill")
            .args(["-INT", &id.to_string()])
            .status();
        assert!(signal.unwrap().success());
    });
    let mut said = Vec::new();
    for line in lines.by_ref().map(Result::unwrap) {
        let waits = line.contains("waits for PX4 at TCP 127.0.0.1:4569");
        said.push(line);
        if waits {
            stop.thread().unpark();
        }
    }
    stop.join().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said:?}");
    assert!(
        said.iter().any(|line| line.contains("waits for PX4")),
        "{said:?}"
    );
    let last = said.last().unwrap();
    assert!(
        last.contains("no landing has ended") && !last.contains("recording"),
        "{last}"
    );
}
