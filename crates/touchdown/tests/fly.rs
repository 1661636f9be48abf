//! `touchdown fly` against an autopilot's side that shares no code with it: `peer/autopilot.py`, made with pymavlink, over
//! a real socket and in real time. Nothing is asserted on timing.
#![allow(clippy::print_stderr)]

mod common;

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::{fails, json, root, text};
use serde_json::Value;

/// A Python with pymavlink; `.ci/run` makes one.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("TOUCHDOWN_PEER_PYTHON").map(PathBuf::from);
    if python.is_none() {
        eprintln!("skipped: TOUCHDOWN_PEER_PYTHON names no Python with pymavlink");
    }
    python
}

/// Settings for the peer's vehicle, whose root of thrust follows 7.4 times the motors' signal with a lag of 0.05 s, and for
/// two slow cores: gaps that a busy machine makes are bridged.
fn settings(port: u16) -> String {
    format!(
        r#"link = "udpin:127.0.0.1:{port}"
[sensors]
imu_gap_s = 0.2
[rates]
least_share = 0.3
[limits]
round_trip_s = 0.2
silent_s = 0.8
stale_s = 0.9
[control]
controller = "observer"
planner = false
terminal_s = 3.0
finds_latency = false
watch_s = 2.0
[control.lander]
imu_age_s = 0.3
[models.thrust.library]
one = 0.0
x = -20.0
s = 148.0
s2 = 0.0
x3 = 0.0
s3 = 0.0
exp_neg_x_s = 0.0
sin_x_s = 0.0
"#
    )
}

/// Our side and the peer's, until both have ended: the objects that they print.
fn flight(python: &Path, folder: &Path, peer: &[&str]) -> (Value, Value) {
    // Closed again at the end of the statement, so that ours can have the port.
    let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    let port = free.unwrap().port();
    let file = folder.join("flight.toml");
    std::fs::write(&file, settings(port)).unwrap();
    let mut ours = Command::new(env!("CARGO_BIN_EXE_touchdown"));
    ours.args(["--json", "fly"]).arg(&file);
    ours.arg("--out").arg(folder.join("flight.mcap"));
    let ours = started(&mut ours);
    let mut theirs = Command::new(python);
    theirs.arg(root().join("crates/touchdown/tests/peer/autopilot.py"));
    theirs.args(["--port", &port.to_string()]).args(peer);
    let theirs = finished(started(&mut theirs));
    (finished(ended(ours)), theirs)
}

/// A process that has ended, if need be by us: a companion whose vehicle did not land waits for it.
fn ended(mut child: Child) -> Child {
    let patience = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if patience.elapsed() > Duration::from_secs(30) {
            child.kill().unwrap();
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    child
}

fn started(command: &mut Command) -> Child {
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    piped.spawn().unwrap()
}

fn finished(child: Child) -> Value {
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    // Objects of the flight's progress come before the last line.
    let printed = text(&output.stdout);
    let last = printed.lines().last().unwrap_or_default();
    serde_json::from_str(last).unwrap_or_else(|e| panic!("{e}: {said}"))
}

fn replay(folder: &Path) -> Value {
    let recording = folder.join("flight.mcap");
    json(
        0,
        ["fly".into(), "--replay".into(), recording.into_os_string()],
    )
}

#[test]
fn prop_a_vehicle_over_a_heaving_deck_is_landed_and_disarmed() {
    let Some(python) = python() else { return };
    for autopilot in ["px4", "ardupilot"] {
        let folder = tempfile::tempdir().unwrap();
        let (ours, theirs) = flight(&python, folder.path(), &["--autopilot", autopilot]);
        assert_eq!(ours["flight"]["ending"], "landed", "{ours:#} {theirs:#}");
        assert_eq!(theirs["armed"], false);
        let of = |key: &str| theirs[key].as_f64().unwrap();
        assert!(of("touch_mps") < 0.3, "{theirs:#}");
        assert!(of("offset_m") < 0.3, "{theirs:#}");
        assert_eq!(of("parameters_set"), 0.0);
        assert_eq!(of("mode_requests"), 0.0);
        assert!(of("answered") > 0.0 && of("heartbeats") > 0.0);
        let again = replay(folder.path());
        assert_eq!(again["difference"], Value::Null);
        assert_eq!(again["flight"]["ending"], "landed");
        assert_eq!(again["flight"], ours["flight"]);
    }
}

#[test]
fn prop_a_pilot_who_takes_over_gets_no_setpoint_any_more() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (ours, theirs) = flight(&python, folder.path(), &["--pilot", "takes-over"]);
    assert_eq!(ours["flight"]["ending"], "pilot_took_over", "{ours:#}");
    assert_eq!(theirs["setpoints_after_take_over"], 0);
    assert_eq!(theirs["mode_requests"], 0);
    assert_eq!(theirs["armed"], true);
    assert_eq!(replay(folder.path())["difference"], Value::Null);
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
    assert!(fails(1, ["fly", "--replay", "no-such.mcap"]).contains("no-such.mcap"));
    fails(2, ["fly"]);
}
