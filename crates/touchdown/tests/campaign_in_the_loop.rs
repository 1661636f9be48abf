//! `touchdown campaign` with an autopilot in the loop, whose side is played by `peer/simulated.py`, made with pymavlink. It shares
//! no code with the command. Simulated time runs as fast as the machine can; nothing is asserted on real time.
#![cfg(unix)]

use crate::common;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::common::{PATIENT, peer_program, python, text};
use serde_json::Value;

/// Two controllers on the paper's deck, two landings each, in two blocks.
fn sweep(autopilot: &str, speed: f64) -> String {
    format!(
        r#"seed = 3
trials = 2
block = 2
autopilot = "{autopilot}"
[software_in_the_loop]
program = "px4/bin/px4"
speed = {speed:?}
companion = "fly.toml"
[grid]
"control.controller" = ["observer", "feedback"]
[scenario]
timeout_s = 40.0
[scenario.deck]
kind = "sines"
[[scenario.deck.tones]]
axis = "heave"
amplitude = 0.05
frequency_hz = 0.5
"#
    )
}

/// A folder with the sweep, the companion's settings, and the peer in place of the autopilot.
fn prepared(python: &Path, autopilot: &str, speed: f64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    peer_program(folder.path(), python);
    std::fs::write(folder.path().join("sweep.toml"), sweep(autopilot, speed)).unwrap();
    std::fs::write(folder.path().join("fly.toml"), PATIENT).unwrap();
    std::fs::create_dir(folder.path().join("scratch")).unwrap();
    folder
}

/// The command in a folder whose temporary files are its own.
fn campaign(folder: &Path, out: &str, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_touchdown"));
    command.args(["--json", "campaign"]);
    command.arg(folder.join("sweep.toml"));
    command.args(["--threads", "2"]).args(more);
    command.arg("--out").arg(folder.join(out));
    command.env("TMPDIR", folder.join("scratch"));
    command
}

fn nothing_is_left(folder: &Path) {
    let left: Vec<_> = std::fs::read_dir(folder.join("scratch")).unwrap().collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

fn results(output: &Output) -> Value {
    let shown = text(&output.stderr);
    assert!(output.status.success(), "{shown}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {shown}"))
}

fn block(folder: &Path, out: &str, number: u64) -> PathBuf {
    let name = format!("landings/block-{number:06}.parquet");
    folder.join(out).join(name)
}

#[test]
fn xval_two_instances_of_both_autopilots_sides_land_and_a_lost_block_is_flown_again() {
    let Some(python) = python() else { return };
    for autopilot in ["px4", "ardupilot"] {
        let folder = prepared(&python, autopilot, 0.0);
        let folder = folder.path();
        // The first instance's port is in use, here or by somebody else: it is passed over.
        let _in_use = UdpSocket::bind("127.0.0.1:14540");
        let whole = results(&campaign(folder, "out", &[]).output().unwrap());
        nothing_is_left(folder);
        assert_eq!(whole["reproducible_to_the_bit"], false);
        assert_eq!(whole["autopilot"], autopilot);
        for point in whole["points"].as_array().unwrap() {
            assert_eq!(point["landed"]["count"], 2, "{point}");
            // The deck's greatest speed is 0.16 m/s: a landing that ignored it would touch at up to that plus its own descent.
            assert!(point["v_l_mps"]["max"].as_f64().unwrap() < 0.25, "{point}");
        }
        assert_eq!(whole["points"][1]["controller"], "feedback");
        let page = std::fs::read_to_string(folder.join("out/report.html")).unwrap();
        assert!(page.contains("not reproducible to the bit"));
        let table = std::fs::read_to_string(folder.join("out/summary.csv")).unwrap();
        assert!(table.lines().next().unwrap().contains("not_flown"));

        let kept = std::fs::read(block(folder, "out", 0)).unwrap();
        std::fs::remove_file(block(folder, "out", 1)).unwrap();
        let again = results(&campaign(folder, "out", &["--resume"]).output().unwrap());
        assert_eq!(std::fs::read(block(folder, "out", 0)).unwrap(), kept);
        assert_eq!(again["points"][0], whole["points"][0]);
        assert_eq!(again["landings"], 4);
    }
}

#[test]
fn prop_an_autopilot_that_ends_is_the_outcome_of_its_landing_and_not_the_end_of_the_campaign() {
    let Some(python) = python() else { return };
    let folder = prepared(&python, "px4", 0.0);
    let folder = folder.path();
    let shard = |index: u64, out: &str| {
        let mut command = campaign(folder, out, &["--shard", &format!("{index}/2")]);
        let output = command.env("PEER_FAULT", "ends").output().unwrap();
        assert_eq!(results(&output)["complete"], false);
    };
    shard(1, "a");
    shard(2, "b");
    nothing_is_left(folder);
    let failure = folder.join("a/failures/landing-000001.txt");
    let failure = std::fs::read_to_string(failure).unwrap();
    assert!(failure.contains("as a crashed autopilot does"), "{failure}");
    // Another machine puts the shards together, without the autopilot.
    std::fs::remove_dir_all(folder.join("px4")).unwrap();
    let mut merge = Command::new(env!("CARGO_BIN_EXE_touchdown"));
    merge.args(["--json", "campaign", "merge"]);
    merge.args(["a", "b", "--out", "whole"]).current_dir(folder);
    let whole = results(&merge.output().unwrap());
    for point in whole["points"].as_array().unwrap() {
        // It ends 3 s after its start, before the deck moves.
        assert_eq!(point["trials"], 2, "{point}");
        assert_eq!(point["not_flown"], 2, "{point}");
        assert_eq!(point["not_flown_reasons"]["autopilot_ended"], 2, "{point}");
        assert_eq!(point["landed"], Value::Null, "{point}");
    }
    let page = std::fs::read_to_string(folder.join("whole/report.html")).unwrap();
    assert!(page.contains("None of 4 trials began"));
}

#[test]
fn prop_neither_ctrl_c_nor_a_kill_leaves_an_autopilot() {
    if common::ignores_interrupts() {
        return;
    }
    let Some(python) = python() else { return };
    for (signal, status) in [("-INT", Some(130)), ("-KILL", None)] {
        let folder = prepared(&python, "px4", 1.0);
        let folder = folder.path();
        let alive = folder.join("alive");
        let made = Command::new("mkfifo").arg(&alive).status().unwrap();
        assert!(made.success());
        let mut command = campaign(folder, "out", &[]);
        command.env("PEER_ALIVE", &alive);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let ours = command.spawn().unwrap();
        // Each peer writes a letter as it starts, and holds the pipe until it ends.
        let mut pipe = File::open(&alive).unwrap();
        let mut letters = [0; 2];
        pipe.read_exact(&mut letters).unwrap();
        let pid = ours.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status().unwrap();
        assert!(sent.success());
        let output = ours.wait_with_output().unwrap();
        assert_eq!(output.status.code(), status);
        // The end of the pipe is the end of the last peer.
        let mut rest = Vec::new();
        pipe.read_to_end(&mut rest).unwrap();
        assert!(rest.is_empty(), "another autopilot was started: {rest:?}");
        if signal == "-INT" {
            let shown = text(&output.stderr);
            assert!(shown.contains("0 of 2 blocks"), "{shown}");
            assert!(shown.contains("--threads 2"), "{shown}");
            nothing_is_left(folder);
        }
    }
}

/// A program that the command or its guard finds instead of the system's, because its folder comes first in `PATH`.
fn stand_in(folder: &Path, name: &str, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;

    let path = folder.join(name);
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn prop_a_kill_in_the_middle_of_an_end_leaves_nothing() {
    if common::ignores_interrupts() {
        return;
    }
    let Some(python) = python() else { return };
    let folder = prepared(&python, "px4", 1.0);
    let folder = folder.path();
    for pipe in ["alive", "middle", "goes_on", "removed"] {
        let made = Command::new("mkfifo").arg(folder.join(pipe)).status();
        assert!(made.unwrap().success());
    }
    // Open at both ends: no writer waits for a reader, and the end of one is not the end of all.
    let open = |pipe: &str| {
        let mut options = File::options();
        let options = options.read(true).write(true);
        options.open(folder.join(pipe)).unwrap()
    };
    let (mut middle, mut goes_on) = (open("middle"), open("goes_on"));
    let mut removed = open("removed");
    // The end of an autopilot begins with `kill`, which here says so and waits; the guard's `rm` says when it is done.
    let programs = folder.join("programs");
    std::fs::create_dir(&programs).unwrap();
    let at = |name: &str| folder.join(name).display().to_string();
    let waits = format!("echo > '{}'\nread -r _ < '{}'", at("middle"), at("goes_on"));
    stand_in(&programs, "kill", &waits);
    let removes = format!("/bin/rm \"$@\"\necho > '{}'", at("removed"));
    stand_in(&programs, "rm", &removes);
    let mut command = campaign(folder, "out", &[]);
    let path = std::env::var("PATH").unwrap();
    command.env("PATH", format!("{}:{path}", programs.display()));
    command.env("PEER_ALIVE", folder.join("alive"));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut ours = command.spawn().unwrap();
    let mut alive = File::open(folder.join("alive")).unwrap();
    alive.read_exact(&mut [0; 2]).unwrap();
    let pid = ours.id().to_string();
    let signal = |signal: &str| Command::new("kill").args([signal, &pid]).status().unwrap();
    assert!(signal("-INT").success());
    middle.read_exact(&mut [0]).unwrap();
    assert!(signal("-KILL").success());
    assert_eq!(ours.wait().unwrap().code(), None);
    // Each of the two guards removes once or more often. Without them nothing is ever said: a minute is enough to know it.
    let (say, said) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let read = removed.read_exact(&mut [0; 2]);
        // The test may have given up.
        let _ = say.send(read.is_ok());
    });
    let removed = said.recv_timeout(std::time::Duration::from_mins(1));
    assert_eq!(
        removed,
        Ok(true),
        "no guard removed what the autopilots left"
    );
    nothing_is_left(folder);
    // Those that wait in `kill` end.
    goes_on.write_all(b"\n\n").unwrap();
}

#[test]
fn prop_settings_that_do_not_fit_together_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |sweep: &str, arguments: &[&str], expected: &str| {
        std::fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_touchdown"));
        let output = command
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let shown = text(&output.stderr);
        assert!(
            !output.status.success() && shown.contains(expected),
            "{shown}"
        );
    };
    std::fs::write(folder.path().join("program"), "").unwrap();
    let of_loop = "autopilot = \"px4\"\n[software_in_the_loop]\nprogram = \"program\"\n";
    let campaign: &[&str] = &["campaign", "sweep.toml", "--out", "out"];
    for (sweep, expected) in [
        (
            "autopilot = \"px4\"\n".to_string(),
            "software_in_the_loop.program",
        ),
        ("autopilot = \"paparazzi\"\n".to_string(), "paparazzi"),
        (
            "[software_in_the_loop]\nprogram = \"x\"\n".to_string(),
            "key `autopilot`",
        ),
        (of_loop.replace("program\"", "none\""), "none"),
        (
            format!("{of_loop}speed = -1.0\n"),
            "software_in_the_loop.speed",
        ),
        (format!("{of_loop}companion = \"none.toml\"\n"), "none.toml"),
        (
            format!("{of_loop}[software_in_the_loop.companion.control]\nwatch_s = 1.0\n"),
            "`control`",
        ),
        (
            format!("{of_loop}[software_in_the_loop.companion]\nnever = 1\n"),
            "never",
        ),
    ] {
        refused(&sweep, campaign, expected);
    }
    let mcap: &[&str] = &[
        "campaign",
        "sweep.toml",
        "--mcap",
        "records",
        "--out",
        "out",
    ];
    refused(of_loop, mcap, "record = true");
    let replay: &[&str] = &[
        "campaign",
        "replay",
        "sweep.toml",
        "--landing",
        "0",
        "--mcap",
        "m",
    ];
    refused(of_loop, replay, "record = true");
    let land: &[&str] = &["land", "--space", "sweep.toml", "--out", "out"];
    refused(of_loop, land, "touchdown campaign");
    let simulator: &[&str] = &["simulator", "px4", "sweep.toml"];
    refused(of_loop, simulator, "touchdown campaign");
}
