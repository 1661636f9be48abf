//! From the log of a thrust stand to a landing, as commands: every form, rotors, and vehicles that cannot lift themselves.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use touchdown_model::Card;

/// The default vehicle's weight, N.
const WEIGHT_N: f64 = 1.37 * 9.81;

fn touchdown(args: &[&str], paths: &[&Path]) -> Output {
    let mut command = Command::cargo_bin("touchdown").unwrap();
    command.args(args).args(paths).output().unwrap()
}

fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).to_string()
}

/// The log of one motor on a stand: steps of throttle every second at 100 Hz, `√T = √most (0.1 + 0.9 s)` behind a lag of
/// 0.05 s, noise of 0.02 N, and a battery that sags.
fn stand(folder: &Path, most_n: f64) -> PathBuf {
    let mut text = String::from("time_s,throttle,thrust_n,battery_v\n");
    let mut state = 1_u64;
    let mut uniform = || {
        // A linear congruential generator (Knuth's MMIX).
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut x, mut throttle) = (0.3, 0.2);
    for row in 0..2500 {
        if row % 100 == 0 {
            throttle = 0.15 + 0.8 * uniform();
        }
        let volts = 12.0 - 0.0003 * f64::from(row);
        let target = most_n.sqrt() * (0.1 + 0.9 * throttle * volts / 12.0);
        x += (target - x) * (1.0 - (-0.01_f64 / 0.05).exp());
        let thrust = x * x + 0.07 * (uniform() - 0.5);
        let time = 0.01 * f64::from(row);
        writeln!(text, "{time:.2},{throttle:.4},{thrust:.4},{volts:.3}").unwrap();
    }
    let path = folder.join(format!("stand-{most_n}.csv"));
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn prop_every_form_of_a_stand_lands_vertically_and_in_space() {
    let folder = tempfile::tempdir().unwrap();
    let log = stand(folder.path(), 6.0);
    let forms: [&[&str]; 9] = [
        &["--form", "static_sqrt"],
        &["--form", "static_sqrt", "--battery"],
        &["--form", "static_thrust"],
        &["--form", "static_thrust", "--battery"],
        &["--form", "lagged_motors"],
        &["--form", "lagged_motors", "--battery"],
        &["--form", "first_order"],
        &["--form", "library"],
        &[],
    ];
    for form in forms {
        let card = folder.path().join("card.toml");
        let args = [
            &["identify", "thrust", "--quiet", "--rotors", "1"],
            form,
            &["--out"],
        ]
        .concat();
        let identified = touchdown(&args, &[&card, &log]);
        assert!(
            identified.status.success(),
            "{form:?}: {}",
            error(&identified)
        );
        for way in [&["land"][..], &["land", "--space"]] {
            let args = [
                way,
                &[
                    "--json",
                    "--trials",
                    "1",
                    "--controller",
                    "dynamic",
                    "--thrust",
                ],
            ];
            let out = folder.path().join("out");
            let mut command = Command::cargo_bin("touchdown").unwrap();
            command
                .args(args.concat())
                .arg(&card)
                .arg("--out")
                .arg(&out);
            let landed = command.output().unwrap();
            assert!(
                landed.status.success(),
                "{form:?} {way:?}: {}",
                error(&landed)
            );
            let results: Value = serde_json::from_slice(&landed.stdout).unwrap();
            let count = match way.len() {
                1 => &results["landing"]["dynamic"]["landed"],
                _ => &results["points"][0]["landed"]["count"],
            };
            assert_eq!(count, 1, "{form:?} {way:?}: {results}");
        }
    }
}

#[test]
fn prop_a_card_has_what_settings_and_map_say_of_the_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let log = stand(folder.path(), 6.0);
    let [card, settings, map] =
        ["card.toml", "settings.toml", "map.toml"].map(|f| folder.path().join(f));
    std::fs::write(
        &settings,
        "[vehicle]\nmass_kg = 0.9\nrotors = 6\nmeasured_rotors = 2\n",
    )
    .unwrap();
    let channels =
        "schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = 'throttle'\nthrust_n = 'thrust_n'\n";
    let identify = |vehicle: &str| {
        std::fs::write(&map, format!("{channels}[vehicle]\n{vehicle}")).unwrap();
        let mut command = Command::cargo_bin("touchdown").unwrap();
        command
            .args(["identify", "thrust", "--form", "first_order", "--quiet"])
            .arg(&log);
        command
            .arg("--map")
            .arg(&map)
            .arg("--settings")
            .arg(&settings)
            .arg("--out")
            .arg(&card);
        command.output().unwrap()
    };
    // The settings come first, the map fills in the rest.
    let done = identify("mass_kg = 1.2\nrotor_radius_m = 0.06\narm_m = 0.11\n");
    assert!(done.status.success(), "{}", error(&done));
    let card = Card::read(&card).unwrap();
    assert_eq!(card.measured_rotors, Some(2));
    let vehicle = card.vehicle;
    assert_eq!((vehicle.mass_kg, vehicle.rotors), (Some(0.9), Some(6)));
    assert_eq!(
        (vehicle.rotor_radius_m, vehicle.arm_m),
        (Some(0.06), Some(0.11))
    );
    let wrong = identify("rotors = 0\n");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(
        error(&wrong).contains("line 7, vehicle.rotors: expected a whole number, at least 1"),
        "{}",
        error(&wrong)
    );
}

#[test]
fn prop_thrust_is_multiplied_by_the_rotors() {
    let folder = tempfile::tempdir().unwrap();
    let log = stand(folder.path(), 6.0);
    let card = folder.path().join("card.toml");
    let identified = touchdown(&["identify", "thrust", "--out"], &[&card, &log]);
    assert!(error(&identified).contains("taken for that of one rotor"));
    assert_eq!(Card::read(&card).unwrap().measured_rotors, Some(1));
    let land = |vehicle: &str| {
        let scenario = folder.path().join("scenario.toml");
        std::fs::write(
            &scenario,
            format!("controllers = [\"empirical\"]\ntrials = 1\n{vehicle}"),
        )
        .unwrap();
        let out = folder.path().join("out");
        let mut command = Command::cargo_bin("touchdown").unwrap();
        command
            .arg("land")
            .arg(&scenario)
            .arg("--thrust")
            .arg(&card)
            .arg("--out")
            .arg(&out);
        command.output().unwrap()
    };
    let four = land("");
    let said = String::from_utf8_lossy(&four.stdout).to_string();
    assert!(four.status.success(), "{}", error(&four));
    assert!(
        said.contains("times 4/1: 4 rotors (assumed: set rotors in [vehicle]), 1 measured"),
        "{said}"
    );
    // The scenario that is written flies again, without the vehicle being stated twice.
    let again = folder.path().join("again");
    let written = folder.path().join("out/scenario.toml");
    let repeated = touchdown(&["land", "--trials", "1", "--out"], &[&again, &written]);
    assert!(repeated.status.success(), "{}", error(&repeated));
    // Two of these motors give 12 N, 0.9 of the weight.
    let two = land("[vehicle]\nrotors = 2\n");
    assert_eq!(two.status.code(), Some(2));
    let said = error(&two);
    let sentence = format!("is below 1.3 times the weight of the vehicle, {WEIGHT_N:.3} N");
    assert!(
        said.contains("its greatest thrust, 1") && said.contains(&sentence),
        "{said}"
    );
    // They lift a vehicle of half the mass, which starts lower.
    let light = land("[vehicle]\nrotors = 2\nmass_kg = 0.6\nrotor_radius_m = 0.08\n");
    assert!(light.status.success(), "{}", error(&light));
    let said = String::from_utf8_lossy(&light.stdout).to_string();
    assert!(
        said.contains("simulated vehicle: 0.6 kg, rotor radius 0.0800 m"),
        "{said}"
    );
    let none = land("[vehicle]\nrotors = 0\n");
    assert!(error(&none).contains("key `vehicle.rotors`: expected at least 1, found 0"));
}
