//! `touchdown fly` against an autopilot's side that shares no code with it: `peer/autopilot.py`, made with pymavlink, over
//! a real socket and in real time. Nothing is asserted on timing.
#![allow(clippy::print_stderr)]

mod common;

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Condvar, Mutex, PoisonError, mpsc};
use std::time::Duration;

use common::{PATIENT, fails, json, python, root, text};
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// More settings of the table `control`, and the thrust model, for the peer's vehicle: its root of thrust follows 7.4 times
/// the motors' signal with a lag of 0.05 s.
const SETTINGS: &str = r#"
terminal_s = 3.0
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
"#;

/// A thrust card of the user's own: motors a little stronger than those of the peer's vehicle.
const CARD: &str = r#"
schema = 1
name = "own"
kind = "thrust"
form = "library"
status = "fitted"
equation = "x' = 20 (7.6 s - x), x = √T [√N], s throttle in [0, 1]"
description = "Motors a little stronger than those of the peer's vehicle."
warnings = []
[vehicle]
name = "peer"
mass_kg = 1.37
[validity]
outside = "clamp"
[validity.inputs]
s = [0.05, 0.95]
x = [0.3, 7.2]
[provenance]
source = "a test"
inputs = []
[[terms]]
of = "x'"
expression = "x"
value = -20.0
unit = "1/s"
[[terms]]
of = "x'"
expression = "s"
value = 152.0
unit = "√N/s"
"#;

/// A flight against the peer.
#[derive(Clone, Copy, Default)]
struct Case<'a> {
    /// Arguments of the peer.
    peer: &'a [&'a str],
    /// Arguments of `fly`.
    ours: &'a [&'a str],
    /// Lines of settings before the tables.
    first: &'a str,
    /// Tables of settings.
    tables: &'a str,
    /// Most bytes of the recording, in units of 1024.
    disk: Option<u32>,
}

/// What came of a flight: our exit status, the objects that both printed last, and what we said.
struct Flown {
    status: Option<i32>,
    ours: Value,
    theirs: Value,
    said: String,
    objects: usize,
}

/// Flights at once: each is three busy processes, and machines have two cores.
const AT_ONCE: u32 = 2;

static FLYING: (Mutex<u32>, Condvar) = (Mutex::new(0), Condvar::new());

/// A flight's permission to begin.
struct Permission;

impl Permission {
    fn wait() -> Self {
        let count = FLYING.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut count = FLYING
            .1
            .wait_while(count, |count| *count >= AT_ONCE)
            .unwrap_or_else(PoisonError::into_inner);
        *count += 1;
        Self
    }
}

impl Drop for Permission {
    fn drop(&mut self) {
        *FLYING.0.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        FLYING.1.notify_one();
    }
}

impl Case<'_> {
    /// Our side and the peer's, until both have ended.
    fn fly(&self, python: &Path, folder: &Path) -> Flown {
        let _permission = Permission::wait();
        let over_udp = !self.peer.contains(&"--link");
        let mut theirs = Command::new(python);
        theirs.arg(root().join("crates/touchdown/tests/peer/autopilot.py"));
        theirs.args(self.peer);
        if over_udp {
            // Closed again at the end of the statement, so that ours can have the port.
            let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
            let port = free.unwrap().port();
            let link = format!("link = \"udpin:127.0.0.1:{port}\"\n");
            let ours = self.start(folder, &link);
            theirs.args(["--port", &port.to_string(), "--pid", &ours.id().to_string()]);
            let theirs = started(&mut theirs);
            return self.ended(ours, theirs, "");
        }
        let mut theirs = started(&mut theirs);
        let mut address = String::new();
        let mut lines = BufReader::new(theirs.stdout.take().unwrap());
        lines.read_line(&mut address).unwrap();
        let address: Value = serde_json::from_str(&address).unwrap();
        let ours = self.start(folder, &format!("link = {}\n", address["address"]));
        let mut rest = String::new();
        lines.read_to_string(&mut rest).unwrap();
        self.ended(ours, theirs, &rest)
    }

    fn start(&self, folder: &Path, link: &str) -> Child {
        let file = folder.join("flight.toml");
        let content = format!("{link}{}{PATIENT}{SETTINGS}{}", self.first, self.tables);
        std::fs::write(&file, content).unwrap();
        let command = env!("CARGO_BIN_EXE_touchdown");
        let mut ours = match self.disk {
            None => Command::new(command),
            Some(kib) => {
                let mut shell = Command::new("bash");
                let limited = format!("ulimit -f {kib}; trap '' XFSZ; exec \"$@\"");
                shell.args(["-c", &limited, "bash", command]);
                shell
            }
        };
        ours.args(["--json", "fly"]).arg(&file).args(self.ours);
        ours.arg("--out").arg(folder.join("flight.mcap"));
        started(&mut ours)
    }

    fn ended(&self, ours: Child, theirs: Child, printed: &str) -> Flown {
        let theirs = theirs.wait_with_output().unwrap();
        assert!(theirs.status.success(), "{}", text(&theirs.stderr));
        let ours = output(ours);
        let (out, said) = (text(&ours.stdout), text(&ours.stderr));
        // Objects of the flight's progress come before the last line.
        let last = |text: &str| -> Value {
            let line = text.lines().last().unwrap_or_default();
            serde_json::from_str(line).unwrap_or(Value::Null)
        };
        Flown {
            status: ours.status.code(),
            ours: last(&out),
            theirs: last(&(text(&theirs.stdout) + printed)),
            said,
            objects: out.lines().count(),
        }
    }
}

impl Flown {
    fn ending(&self) -> &Value {
        &self.ours["flight"]["ending"]
    }

    fn theirs(&self, key: &str) -> f64 {
        self.theirs[key].as_f64().unwrap_or(f64::NAN)
    }

    /// For a failed assertion.
    fn told(&self) -> String {
        format!("{:?}\n{}\n{:#}", self.status, self.said, self.theirs)
    }

    fn landed(&self) {
        assert_eq!(self.ending(), "landed", "{}", self.told());
        assert_eq!(self.status, Some(0));
        assert_eq!(self.theirs["armed"], false);
        // Twice what the deck itself moves at: a touchdown, not a fall.
        assert!(self.theirs("touch_mps") < 0.3, "{}", self.told());
        assert!(self.theirs("offset_m") < 0.3, "{}", self.told());
    }
}

/// Time that a companion whose vehicle did not land gets before it is killed.
const PATIENCE: Duration = Duration::from_secs(30);

/// What a process printed until its end.
fn output(child: Child) -> Output {
    let pid = child.id().to_string();
    let (sender, ended) = mpsc::channel();
    std::thread::spawn(move || sender.send(child.wait_with_output().unwrap()));
    ended.recv_timeout(PATIENCE).unwrap_or_else(|_| {
        Command::new("kill").args(["-KILL", &pid]).status().unwrap();
        ended.recv().unwrap()
    })
}

fn started(command: &mut Command) -> Child {
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    piped.spawn().unwrap()
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
    }
}

/// A client of the live view, as soon as there is one. It has asked for every topic.
fn watcher(address: &str) -> (WebSocket<MaybeTlsStream<TcpStream>>, Value) {
    let mut request = format!("ws://{address}").into_client_request().unwrap();
    let protocol = HeaderValue::from_static("foxglove.sdk.v1");
    let headers = request.headers_mut();
    headers.insert("sec-websocket-protocol", protocol);
    let mut client = loop {
        match tungstenite::connect(request.clone()) {
            Ok((client, _)) => break client,
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    let mut object = || -> Value {
        let text = client.read().unwrap().into_text().unwrap();
        serde_json::from_str(&text).unwrap()
    };
    assert_eq!(object()["op"], "serverInfo");
    let channels = object()["channels"].clone();
    let of =
        |channel: &Value| serde_json::json!({ "id": channel["id"], "channelId": channel["id"] });
    let all: Vec<_> = channels.as_array().unwrap().iter().map(of).collect();
    let subscribe = serde_json::json!({ "op": "subscribe", "subscriptions": all });
    client.send(Message::text(subscribe.to_string())).unwrap();
    (client, channels)
}

/// Messages by topic until the flight has ended.
fn watched(address: &str) -> BTreeMap<String, Vec<Value>> {
    let (mut client, channels) = watcher(address);
    let mut messages: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    while let Ok(Message::Binary(bytes)) = client.read() {
        let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap()) as usize;
        let topic = channels[id]["topic"].as_str().unwrap().to_string();
        let message = serde_json::from_slice(&bytes[13..]).unwrap();
        messages.entry(topic).or_default().push(message);
    }
    messages
}

#[test]
fn prop_a_flight_is_watched_live_and_a_watcher_that_never_reads_does_not_disturb_it() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Closed again at the end of the statement, so that ours can have the port.
    let free = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr());
    let address = free.unwrap().to_string();
    let live = format!("--live={address}");
    let case = Case {
        ours: &[&live],
        ..Case::default()
    };
    let (flown, seen) = std::thread::scope(|scope| {
        let seen = scope.spawn(|| watched(&address));
        let idle = scope.spawn(|| watcher(&address));
        let flown = case.fly(&python, folder.path());
        drop(idle.join().unwrap());
        (flown, seen.join().unwrap())
    });
    flown.landed();
    for topic in [
        "/mavlink/attitude",
        "/mavlink/setpoint",
        "/tf",
        "/vehicle/pose",
        "/deck/pose",
        "/estimate",
        "/deck/estimate",
        "/command",
        "/checklist",
    ] {
        assert!(seen.contains_key(topic), "{topic}: {:?}", seen.keys());
    }
    let values = |topic: &str, key: &str| -> Vec<Value> {
        let mut values: Vec<_> = seen[topic].iter().map(|m| m[key].clone()).collect();
        values.dedup();
        values
    };
    assert!(values("/stage", "stage").contains(&serde_json::json!("in_control")));
    assert!(values("/phase", "phase").contains(&serde_json::json!("descend")));
    assert_eq!(
        seen["/checklist"].last().unwrap()["items"][0]["verdict"],
        "good"
    );
    // The recording has the same topics, and is replayed as any other.
    let inspected = json(
        0,
        [
            "inspect".into(),
            folder.path().join("flight.mcap").into_os_string(),
        ],
    );
    assert!(
        inspected.to_string().contains("vehicle/pose"),
        "{inspected:#}"
    );
    assert_eq!(replay(folder.path())["difference"], Value::Null);
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
        // An autopilot that does not follow falls until it is noticed.
        let fell = *fault == "reject";
        assert!(
            fell || flown.theirs("least_m") > 0.1,
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
fn prop_ctrl_c_hands_the_vehicle_over_and_ends_with_130() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let case = Case {
        peer: &["--fault", "interrupt", "--parameter", "COM_OF_LOSS_T=1.1"],
        ours: &["--set-parameters"],
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
    assert!(fails(1, ["fly", "--replay", "no-such.mcap"]).contains("no-such.mcap"));
    fails(2, ["fly"]);
}
