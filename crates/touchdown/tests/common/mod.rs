//! What the tests of the commands share.
#![allow(dead_code, unreachable_pub, clippy::print_stderr)]

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

/// The project's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A file or folder of measured data: below `TOUCHDOWN_DATA`, by default beside the project. Says so where it is not
/// there, and the test that asked is passed over.
pub fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("TOUCHDOWN_DATA")
        .map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no data at {}", path.display());
    None
}

/// A Python with pymavlink, which plays the autopilots' side; `.ci/run` makes one. Says so where there is none, and the test
/// that asked is passed over.
pub fn python() -> Option<PathBuf> {
    let python = std::env::var_os("TOUCHDOWN_PEER_PYTHON").map(PathBuf::from);
    if python.is_none() {
        eprintln!("skipped: TOUCHDOWN_PEER_PYTHON names no Python with pymavlink");
    }
    python
}

/// Settings with which a companion bridges the gaps that a busy machine makes.
pub const PATIENT: &str = r#"
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
finds_latency = false
"#;

/// Puts the peer that plays an autopilot's side into a folder, where the command looks for the autopilot's program, as
/// `px4/bin/px4`.
#[cfg(unix)]
pub fn peer_program(folder: &Path, python: &Path) -> PathBuf {
    use std::os::unix::fs::PermissionsExt as _;

    let [bin, etc] = ["bin", "etc"].map(|name| folder.join("px4").join(name));
    std::fs::create_dir_all(&bin).unwrap();
    std::fs::create_dir_all(etc).unwrap();
    let peer = root().join("crates/touchdown/tests/peer/simulated.py");
    let script = format!(
        "#!/bin/sh\nexec '{}' '{}' \"$@\"\n",
        python.display(),
        peer.display()
    );
    let program = bin.join("px4");
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    program
}

/// A worked map.
pub fn map(name: &str) -> PathBuf {
    root().join("examples/maps").join(name)
}

/// Bytes of a page with one figure or a few, at most: plotly.js and the typefaces are 1.3 MB of it.
pub const SMALL_PAGE: usize = 1_700_000;
/// Bytes of a page with many figures, at most.
pub const LARGE_PAGE: usize = 3_000_000;

/// Bytes of the page of a campaign, at most: ten worst landings of 13 curves with 1200 points each, 5.3 bytes a point and
/// axis, are 0.8 MB beside plotly.js and the typefaces, however long they last; and one landing to watch.
pub const CAMPAIGN_PAGE: usize = 2_300_000 + WATCHED;
/// Bytes of the player of landings, at most, with two landings of 20 s: three.js is 0.5 MB of it, a landing 60 kB.
pub const WATCHED: usize = 800_000;

/// The page in a folder of results: its size is bounded, and its verdict stands before its first figure and section.
pub fn page(folder: &Path, bytes: usize) -> String {
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(
        html.len() <= bytes,
        "{}: {} bytes",
        folder.display(),
        html.len()
    );
    let at = |part: &str| html.find(part).unwrap_or(html.len());
    let (verdict, figure) = (at("class=\"verdict"), at("<figure class=\"chart\""));
    assert!(
        verdict < figure && figure < at("<h2"),
        "{}",
        folder.display()
    );
    html
}

/// Runs the command.
pub fn run<S: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = S>) -> Output {
    Command::cargo_bin("touchdown")
        .unwrap()
        .arg("--quiet")
        .args(args)
        .output()
        .unwrap()
}

/// Runs the command with `--json`, expects the exit status and gives the object.
pub fn json<S: AsRef<std::ffi::OsStr>>(status: i32, args: impl IntoIterator<Item = S>) -> Value {
    let args: Vec<std::ffi::OsString> = args.into_iter().map(|a| a.as_ref().to_owned()).collect();
    let output = run(args.iter().cloned().chain(["--json".into()]));
    assert_eq!(
        output.status.code(),
        Some(status),
        "{args:?}: {}",
        text(&output.stderr)
    );
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", text(&output.stdout)))
}

/// Runs the command, expects that it fails with the status and one clear error, and gives that.
pub fn fails<S: AsRef<std::ffi::OsStr>>(status: i32, args: impl IntoIterator<Item = S>) -> String {
    let args: Vec<std::ffi::OsString> = args.into_iter().map(|a| a.as_ref().to_owned()).collect();
    let output = run(&args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {error}");
    assert!(
        error.contains("error: ") && !error.contains("panicked"),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    error
}

/// Whether Ctrl-C (SIGINT) is ignored here and in every process started from here, as in a job
/// that a script runs in the background; the test that asked is then passed over. False where `/proc` does not say.
pub fn ignores_interrupts() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let ignores = mask.is_some_and(|mask| mask & 0b10 != 0);
    if ignores {
        eprintln!("skipped: this process, a job in the background, ignores Ctrl-C");
    }
    ignores
}

/// Bytes as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A number in an object.
pub fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number, not {value}"))
}

/// Writes a log with the channels `time_s`, `throttle` and `thrust_n` for every row that `row` gives.
pub fn write_log(path: &Path, rows: usize, row: impl Fn(usize) -> String) {
    let mut out = String::from("time_s,throttle,thrust_n\n");
    for i in 0..rows {
        out.push_str(&row(i));
        out.push('\n');
    }
    std::fs::write(path, out).unwrap();
}

/// A rotor with `x' = (2 s + 1 - x)/0.1`, `x = √T`, driven by a sine of the throttle, exactly.
pub fn rotor_row(i: usize) -> String {
    let (t, w, tau) = (0.01 * i as f64, 1.5_f64, 0.1_f64);
    let s = 0.5 + 0.3 * (w * t).sin();
    // Steady answer of a lag to a sine.
    let phase = (w * tau).atan();
    let late = 0.5 + 0.3 * (w * t - phase).sin() / (1.0 + (w * tau).powi(2)).sqrt();
    let x = 2.0 * late + 1.0;
    format!("{t},{s},{}", x * x)
}

/// A message fits its JSON schema: objects whose properties have a type.
pub fn fits(schema: &Value, message: &Value, at: &str) {
    match (schema["type"].as_str(), message) {
        (Some("object"), Value::Object(keys)) => {
            for (key, value) in keys {
                fits(&schema["properties"][key], value, &format!("{at}.{key}"));
            }
        }
        (Some("string"), Value::String(_))
        | (Some("number"), Value::Number(_))
        | (Some("boolean"), Value::Bool(_)) => {}
        (Some("integer"), Value::Number(number)) if number.is_u64() => {}
        (expected, _) => panic!("{at}: {message} is no {expected:?}"),
    }
}
