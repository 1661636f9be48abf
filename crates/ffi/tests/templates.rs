//! The templates for PX4 and ArduPilot are accepted by a C++ compiler, the first against stubs of PX4's headers.

#![allow(clippy::print_stderr)]

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

const PX4_MODULE: &str = "examples/px4_module/touchdown_vertical";

/// Compiles a source by g++ with these options and returns true; prints that it skips where there is no g++.
fn compiled(source: &Path, includes: &[&str], options: &[&OsStr]) -> bool {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new("g++");
    // PX4 and ArduPilot compile their C++ as 14 and 17; the stubs need 17.
    command.args([
        "-std=c++17",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-Wno-unused-parameter",
        "-I",
    ]);
    command.arg(folder.join("include"));
    for include in includes {
        command.arg("-I").arg(folder.join(include));
    }
    match command.args(options).arg(folder.join(source)).output() {
        Err(_) => {
            eprintln!("skipped: g++ is not on this machine");
            false
        }
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{text}");
            true
        }
    }
}

fn accepted(source: &str, includes: &[&str]) {
    compiled(Path::new(source), includes, &[OsStr::new("-fsyntax-only")]);
}

/// Runs the module in offboard mode with a library that refuses its settings. Ends with the number of the check that failed.
const ENTRIES: &str = r#"
#include <cmath>
#include <cstdint>
#define private public
#include "TouchdownVertical.cpp"

td_error td_vertical_settings_default(td_vertical_settings *) { return TD_ERROR_NONE; }
td_error td_hover_throttle(const td_vehicle *, const td_models *, float *, td_setting *) { return TD_ERROR_NONE; }
td_error td_vertical_init(void *, size_t, const td_vertical_settings *, const td_measurement *, float, td_vertical **,
                          td_setting *) { return TD_ERROR_SETTING; }
td_error td_vertical_step(td_vertical *, const td_measurement *, float, td_command *) { return TD_ERROR_NONE; }
const char *td_error_text(uint32_t) { return ""; }

int main()
{
    TouchdownVertical module;
    for (int entry = 1; entry <= 2; ++entry) {
        stub_nav_state = vehicle_status_s::NAVIGATION_STATE_OFFBOARD;
        for (int period = 0; period < 10; ++period) {
            module.Run();
        }
        if (stub_logs != entry) {
            return entry;
        }
        stub_nav_state = 0;
        module.Run();
    }
    return 0;
}
"#;

#[test]
fn regress_template_of_a_px4_module_prints_a_refusal_once_for_each_entry() {
    let built = tempfile::tempdir().unwrap();
    let source = built.path().join("entries.cpp");
    let program = built.path().join("entries");
    std::fs::write(&source, ENTRIES).unwrap();
    let output = [OsStr::new("-o"), program.as_os_str()];
    if compiled(&source, &["tests/px4_stubs", PX4_MODULE], &output) {
        let status = Command::new(&program).status().unwrap();
        assert_eq!(status.code(), Some(0), "the entry that printed otherwise");
    }
}

#[test]
fn regress_template_of_a_px4_module_compiles() {
    let source = format!("{PX4_MODULE}/TouchdownVertical.cpp");
    accepted(&source, &["tests/px4_stubs"]);
}

#[test]
fn regress_template_of_an_ardupilot_library_compiles() {
    accepted("examples/ardupilot/AP_Touchdown/AP_Touchdown.cpp", &[]);
}
