//! The examples in C and C++ are compiled, run, and compared with the same landing in Rust.

#![allow(clippy::print_stderr)]

use std::env::consts::OS;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use touchdown_flight::method::{Method, VerticalLanding, VerticalSettings};
use touchdown_flight::{Command as Thrust, Measurement};
use touchdown_lander::models::FlightModels;
use touchdown_record::SEED;
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::space::{Case, SpaceLander};
use touchdown_sim::landing::vertical::{LandingScenario, land};

/// What every compiler is asked for.
const WARNINGS: [&str; 5] = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-O1"];

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The compilers of this machine, of a list.
fn compilers(names: &[&'static str]) -> Vec<&'static str> {
    let found: Vec<_> = names
        .iter()
        .copied()
        .filter(|name| {
            Command::new(name)
                .arg("--version")
                .output()
                .is_ok_and(|output| output.status.success())
        })
        .collect();
    if found.is_empty() {
        eprintln!("skipped: none of {names:?} is on this machine");
    }
    found
}

/// The static library that cargo has built for this test: the newest with the feature `world`,
/// since other builds leave theirs.
fn library() -> PathBuf {
    let deps = std::env::current_exe().unwrap();
    let deps = deps.parent().unwrap();
    let is_ours = |path: &Path| {
        path.extension() == Some(OsStr::new("a"))
            && path
                .file_stem()
                .and_then(OsStr::to_str)
                .is_some_and(|name| name.starts_with("libtouchdown_ffi"))
    };
    let has_world = |path: &PathBuf| {
        let name = b"td_world_land_vertical";
        let bytes = fs::read(path).unwrap();
        bytes.windows(name.len()).any(|window| window == name)
    };
    let mut libraries: Vec<_> = fs::read_dir(deps)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| is_ours(path))
        .collect();
    libraries.sort_by_key(|path| fs::metadata(path).unwrap().modified().unwrap());
    libraries
        .into_iter()
        .rfind(has_world)
        .expect("cargo builds the static library beside the test")
}

fn said(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{}{}",
        text(&output.stdout),
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Compiles an example and runs it.
fn run(compiler: &str, standard: &str, source: &str, arguments: &[&str]) -> String {
    let built = tempfile::tempdir().unwrap();
    let program = built.path().join("program");
    let compiled = Command::new(compiler)
        .arg(standard)
        .args(WARNINGS)
        .args(["-DTOUCHDOWN_WORLD", "-I"])
        .arg(folder("include"))
        .arg(folder(source))
        .arg(library())
        // What Rust's standard library needs of the system.
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    said(&compiled);
    said(&Command::new(&program).args(arguments).output().unwrap())
}

/// T_L and V_L of a line that an example prints.
fn printed(text: &str) -> [f64; 2] {
    ["T_L = ", "V_L = "].map(|name| {
        let (_, rest) = text.split_once(name).expect("an example prints it");
        rest.split_once(' ').unwrap().0.parse().unwrap()
    })
}

#[allow(clippy::cast_possible_truncation)]
fn narrow(x: f64) -> f32 {
    x as f32
}

/// The landing of `examples/c/vertical.c`, without the interface.
fn vertical_in_rust() -> [f64; 2] {
    let models = FlightModels::<f32>::paper();
    let landing = VerticalLanding {
        mass_kg: 1.37,
        gravity_mps2: 9.81,
        start_height_m: 0.5,
        deck_angular_frequency: Some(core::f32::consts::PI),
        deck_acceleration: true,
    };
    let settings = VerticalSettings {
        c_per_s: 0.5566,
        ..VerticalSettings::default()
    };
    let controller = settings
        .controller(Method::Dynamic, &landing, models.thrust, models.dynamic)
        .unwrap();
    let start = Measurement {
        height_m: 0.5,
        ..Measurement::default()
    };
    let hover = controller.thrust.throttle_for(1.37 * 9.81);
    let mut state = controller.initial(&start, hover);
    let mut fly = |measured: &Measurement<f64>| {
        let measurement = Measurement {
            height_m: narrow(measured.height_m),
            relative_velocity_mps: narrow(measured.relative_velocity_mps),
            vehicle_velocity_mps: narrow(measured.vehicle_velocity_mps),
            acceleration_mps2: narrow(measured.acceleration_mps2),
        };
        Thrust {
            throttle: f64::from(controller.step(&mut state, &measurement, 0.01).throttle),
            ..Thrust::default()
        }
    };
    let scenario = LandingScenario {
        start_height_m: 0.5,
        deck: DeckMotion::Sine {
            amplitude_m: 0.05,
            frequency_hz: 0.5,
            phase_rad: 0.0,
        },
        ..LandingScenario::default()
    };
    let flown = land(&scenario, 0, 1, &mut fly, false).unwrap();
    [flown.t_l_s.unwrap(), flown.v_l_mps.unwrap()]
}

/// Prints sizes as a C compiler sees them, in the order of the test below.
const SIZES: &str = r#"
#include <stdio.h>
#include "touchdown.h"
int main(void)
{
    printf("%zu %zu %zu %zu %zu %zu %zu %zu %zu\n", (size_t)TD_VERTICAL_SIZE, (size_t)TD_COMPUTER_SIZE,
           sizeof(td_vertical_settings), sizeof(td_computer_settings), sizeof(td_measurement), sizeof(td_reading),
           sizeof(td_sensed), sizeof(td_computer_output), sizeof(td_setting));
    return 0;
}
"#;

#[test]
fn xval_sizes_are_those_of_rust() {
    use touchdown_ffi::*;
    let built = tempfile::tempdir().unwrap();
    let source = built.path().join("sizes.c");
    fs::write(&source, SIZES).unwrap();
    let expected = [
        TD_VERTICAL_SIZE,
        TD_COMPUTER_SIZE,
        size_of::<td_vertical_settings>(),
        size_of::<td_computer_settings>(),
        size_of::<td_measurement>(),
        size_of::<td_reading>(),
        size_of::<td_sensed>(),
        size_of::<td_computer_output>(),
        size_of::<td_setting>(),
    ];
    for compiler in compilers(&["cc", "clang"]) {
        let text = run(compiler, "-std=c99", source.to_str().unwrap(), &[]);
        let found: Vec<usize> = text
            .split_whitespace()
            .map(|n| n.parse().unwrap())
            .collect();
        assert_eq!(found, expected, "{compiler}");
    }
}

#[test]
fn xval_vertical_example_in_c_lands_as_in_rust() {
    if OS != "linux" {
        eprintln!("skipped: the libraries that a program links are those of Linux here");
        return;
    }
    let expected = vertical_in_rust();
    for compiler in compilers(&["cc", "clang"]) {
        let found = printed(&run(compiler, "-std=c99", "examples/c/vertical.c", &[]));
        assert_eq!(
            found.map(f64::to_bits),
            expected.map(f64::to_bits),
            "{compiler}: {found:?} {expected:?}"
        );
    }
}

#[test]
fn xval_computer_example_in_cpp_lands_as_in_rust() {
    if OS != "linux" {
        eprintln!("skipped: the libraries that a program links are those of Linux here");
        return;
    }
    for case in [Case::Paper, Case::Nan] {
        // The recorder's own landing: another conversion of readings and commands.
        let lander = SpaceLander::new(&case.scenario()).unwrap();
        assert_eq!(SEED, 1, "the seed of the example");
        let flown = touchdown_record::space(case, &lander, 0).unwrap().landing;
        let touch = flown.touch.unwrap();
        let expected = [touch.t_l_s, touch.v_l_mps];
        for compiler in compilers(&["c++", "clang++"]) {
            let source = "examples/cpp/computer.cpp";
            let text = run(compiler, "-std=c++11", source, &[case.name()]);
            let found = printed(&text);
            assert_eq!(
                found.map(f64::to_bits),
                expected.map(f64::to_bits),
                "{compiler}, {}: {found:?} {expected:?}",
                case.name()
            );
            // The computer flies through readings without numbers, and the program sees them.
            let without = text.contains(" 0 of them with values that are not finite");
            assert_eq!(without, case == Case::Paper, "{text}");
        }
    }
}
