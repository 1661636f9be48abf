//! The templates for PX4 and ArduPilot are accepted by a C++ compiler, the first against stubs of PX4's headers.

#![allow(clippy::print_stderr)]

use std::path::Path;
use std::process::Command;

/// Whether g++ accepts a source; prints that it skips where there is no g++.
fn accepted(source: &str, includes: &[&str]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new("g++");
    // PX4 and ArduPilot compile their C++ as 14 and 17; the stubs need 17.
    command.args([
        "-std=c++17",
        "-fsyntax-only",
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
    match command.arg(folder.join(source)).output() {
        Err(_) => eprintln!("skipped: g++ is not on this machine"),
        Ok(output) => assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        ),
    }
}

#[test]
fn regress_template_of_a_px4_module_compiles() {
    let folder = "examples/px4_module/touchdown_vertical";
    let source = format!("{folder}/TouchdownVertical.cpp");
    accepted(&source, &["tests/px4_stubs"]);
}

#[test]
fn regress_template_of_an_ardupilot_library_compiles() {
    accepted("examples/ardupilot/AP_Touchdown/AP_Touchdown.cpp", &[]);
}
