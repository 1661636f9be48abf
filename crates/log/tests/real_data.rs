//! The worked maps on measured logs. The data are looked for in the folder that the environment
//! variable `TOUCHDOWN_DATA` names, by default beside the workspace; without them the tests say
//! that they were skipped.
//!
//! Reference figures were made with Python's `csv` module: `float` of each cell, the windows cut by
//! hand, sums in the order of rows.
#![allow(clippy::print_stderr)]

use std::path::{Path, PathBuf};
use touchdown_log::{Findings, LogError, Map, inspect, read_csv, read_trial};
use touchdown_trial::Trial;

/// Sums of up to 33 528 numbers in another order of operations: relative 1e-12 is some hundred
/// times the rounding that is to be expected.
const ROUNDING: f64 = 1e-12;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn data(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("TOUCHDOWN_DATA")
        .map_or_else(|| workspace().join("../shared/data"), PathBuf::from);
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no data at {}", path.display());
    None
}

fn map(name: &str) -> Map {
    Map::load(workspace().join("examples/maps").join(name)).unwrap()
}

fn read(path: &Path, name: &str) -> (Trial, Findings) {
    read_trial(path, Some(&map(name))).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn near(found: f64, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{found} for {expected}"
    );
}

fn known(trial: &Trial, channel: &str) -> Vec<f64> {
    let values = trial.require(channel).unwrap();
    values.iter().copied().filter(|v| !v.is_nan()).collect()
}

#[test]
fn analytic_every_worked_map_is_one() {
    let maps: Vec<PathBuf> = std::fs::read_dir(workspace().join("examples/maps"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect();
    assert!(maps.len() >= 9);
    for path in maps {
        let map = Map::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(!map.description().is_empty());
    }
}

#[test]
fn xval_crazyflie_1khz_windows() {
    let Some(path) = data("flight-crazyflie-1khz-throttle/log10.csv") else {
        return;
    };
    let (trial, findings) = read(&path, "flight-crazyflie-1khz-throttle.toml");
    assert_eq!((findings.rows_read, trial.len()), (50_496, 33_528));
    assert_eq!(findings.warnings, [""; 0]);
    assert!(!findings.is_lossy());
    near(
        mean(trial.require("thrust_n").unwrap()),
        0.268_932_547_597_338_4,
        ROUNDING,
    );
    near(
        mean(trial.require("throttle").unwrap()),
        0.615_974_307_321_502,
        ROUNDING,
    );
    let other = data("flight-crazyflie-1khz-throttle/log15.csv").unwrap();
    let (trial, _) = read(&other, "flight-crazyflie-1khz-throttle.toml");
    assert_eq!(trial.len(), 41_382);
}

#[test]
fn xval_static_stand_files() {
    let Some(path) = data("thrust-5in-props-static/a1_7.csv") else {
        return;
    };
    let folder = path.parent().unwrap();
    let (trial, _) = read(&path, "thrust-5in-props-static.toml");
    let thrust = trial.require("thrust_n").unwrap();
    near(thrust[0], 0.059_577_875_482_140_93, ROUNDING);
    near(thrust[10], 2.823_311_341_850_576_6, ROUNDING);
    let mut rows = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "csv") {
            continue;
        }
        let (trial, findings) = read(&path, "thrust-5in-props-static.toml");
        assert!(!findings.is_lossy(), "{}: {findings:?}", path.display());
        assert!(
            trial
                .require("throttle")
                .unwrap()
                .iter()
                .all(|v| (0.0..=1.0).contains(v))
        );
        rows += findings.rows_read;
    }
    assert_eq!(rows, 1056);
}

#[test]
fn xval_stand_with_columns_at_different_rates() {
    let name = "thrust-7in-rcbenchmark.toml";
    let Some(path) = data("thrust-7in-rcbenchmark-staircase/Log_2019-11-09_181347.csv") else {
        return;
    };
    let (trial, findings) = read(&path, name);
    assert_eq!(findings.rows_read, 15_875);
    assert_eq!(trial.len(), 15_870);
    assert_eq!(
        (findings.duplicate_stamps, findings.backward_stamps),
        (1, 4)
    );
    assert!(!findings.is_lossy() && findings.text_columns.is_empty());
    let thrust = known(&trial, "thrust_n");
    assert_eq!(thrust.len(), 756);
    near(
        thrust.iter().copied().fold(0.0, f64::max),
        9.80665e-3 * 1_615.995_876_799_174_3,
        ROUNDING,
    );
    let seen = inspect(&read_csv(&path).unwrap().0, None);
    assert_eq!(seen.time.unwrap().column, "Time (s)");
    let thrust = seen
        .columns
        .iter()
        .find(|c| c.name == "Thrust (gf)")
        .unwrap();
    // "every 0.15 s" of the source's own description, which gives two digits.
    near(thrust.rate_hz.unwrap(), 1.0 / 0.15, 0.05);
    // The other file has no command: a gap, and no complaint.
    let other = path.with_file_name("Log_2019-11-07_184325.csv");
    let (trial, findings) = read(&other, name);
    assert_eq!(findings.rows_read, 11_725);
    assert_eq!(
        (findings.duplicate_stamps, findings.backward_stamps),
        (1, 7)
    );
    assert_eq!(known(&trial, "thrust_n").len(), 619);
    assert!(known(&trial, "throttle").is_empty());
    assert!(!findings.is_lossy());
}

#[test]
fn xval_stamped_log() {
    let Some(path) = data("thrust-7in-rcbenchmark-staircase/esc32v3_f60-1.csv") else {
        return;
    };
    let (trial, findings) = read(&path, "thrust-7in-autoquad.toml");
    assert_eq!((findings.rows_read, trial.len()), (10_653, 10_653));
    // From 18:45:58.868 to 18:47:45.721, and 0.1 µs for each of 10 652 rows.
    near(trial.duration_s(), 106.853 + 1e-7 * 10_652.0, ROUNDING);
    assert_eq!(
        trial
            .require("throttle")
            .unwrap()
            .iter()
            .copied()
            .fold(0.0, f64::max),
        1.0
    );
}

#[test]
fn xval_scale_without_time() {
    for (file, rows, pwm, grams) in [
        (
            "cf2.1-stock-prop.csv",
            2573,
            65_500.0,
            50.008_907_318_115_234,
        ),
        ("cf21_stock2.csv", 1735, 45_000.0, 29.579_309_463_500_977),
    ] {
        let Some(path) = data(&format!("thrust-crazyflie21-scale/{file}")) else {
            return;
        };
        let (trial, findings) = read(&path, "thrust-crazyflie21-scale.toml");
        assert_eq!((trial.len(), findings.rows_dropped()), (rows, 0));
        let most = |channel| known(&trial, channel).into_iter().fold(0.0, f64::max);
        near(most("throttle"), pwm / 65_535.0, ROUNDING);
        near(most("thrust_n"), grams * 9.80665e-3, ROUNDING);
    }
}

#[test]
fn xval_flights_keep_every_row() {
    let pad = "flight-crazypad-takeoff-landing";
    let mocap = "flight-crazyflie-mocap-low-hover";
    for (folder, file, name, rows) in [
        (
            pad,
            "E9_log00_motor.csv",
            "flight-crazypad-motor.toml",
            2593,
        ),
        (
            pad,
            "E9_log04_motor.csv",
            "flight-crazypad-motor.toml",
            2598,
        ),
        (
            pad,
            "E9_log01_controller.csv",
            "flight-crazypad-controller.toml",
            2591,
        ),
        (
            mocap,
            "20240822_18_09_53.csv",
            "flight-crazyflie-mocap-floor.toml",
            1756,
        ),
        (
            mocap,
            "20240824_00_08_07.csv",
            "flight-crazyflie-mocap-table.toml",
            2577,
        ),
    ] {
        let Some(path) = data(&format!("{folder}/{file}")) else {
            return;
        };
        let (trial, findings) = read(&path, name);
        assert_eq!((trial.len(), findings.rows_read), (rows, rows), "{file}");
        assert_eq!(findings.warnings, [""; 0], "{file}");
        // None rises 1 m, and the lowest flies off a table that is 0.79 m high.
        let height = trial.require("height_m").unwrap();
        assert!(height.iter().all(|h| (-0.8..1.0).contains(h)), "{file}");
    }
}

#[test]
fn xval_buoy() {
    let Some(path) = data("waves-spotter-buoy/displacement.csv") else {
        return;
    };
    let (trial, findings) = read(&path, "waves-spotter-buoy.toml");
    assert_eq!((trial.len(), findings.warnings.len()), (54_000, 0));
    // 09:00:00.000 to 14:59:59.599; differences of numbers near 5e4 s round at 1e-11 s.
    assert!((trial.duration_s() - 21_599.599).abs() < 1e-9);
    let z = trial.require("deck_height_m").unwrap();
    let mid = mean(z);
    let deviation = (z.iter().map(|v| (v - mid).powi(2)).sum::<f64>() / z.len() as f64).sqrt();
    near(deviation, 0.776_090_011_133_573_5, ROUNDING);
}

/// Stands have no stamps here, and the buoy's are in six columns.
const WITHOUT_TIME: [&str; 2] = [
    "thrust-crazyflie21-scale/cf21_stock2.csv",
    "waves-spotter-buoy/displacement.csv",
];

#[test]
fn analytic_a_foreign_log_without_a_map_gets_a_map_that_works() {
    for file in [
        "thrust-5in-props-static/a1_7.csv",
        "thrust-7in-rcbenchmark-staircase/Log_2019-11-09_181347.csv",
        "thrust-7in-rcbenchmark-staircase/esc32v3_f60-1.csv",
        "thrust-crazyflie21-scale/cf21_stock2.csv",
        "flight-crazyflie-1khz-throttle/log15.csv",
        "flight-crazypad-takeoff-landing/E9_log00_motor.csv",
        "flight-crazyflie-mocap-low-hover/20240822_18_09_53.csv",
        "waves-spotter-buoy/displacement.csv",
    ] {
        let Some(path) = data(file) else { return };
        let error = read_trial(&path, None).unwrap_err();
        let LogError::NeedsMap { suggested, .. } = error else {
            panic!("{error}");
        };
        // Where no column is the time, someone has to say the period.
        let said = suggested.replace("\n# time_s = 'row", "\ntime_s = 'row");
        let is_without = Map::parse("suggested.toml", &suggested).is_err();
        assert_eq!(
            is_without,
            WITHOUT_TIME.contains(&file),
            "{file}\n{suggested}"
        );
        let map = Map::parse("suggested.toml", &said).unwrap();
        let (trial, _) = read_trial(&path, Some(&map)).unwrap();
        assert!(trial.len() > 10, "{file}");
    }
}

#[test]
fn analytic_a_file_that_is_no_table() {
    for file in [
        "log-px4-ulog/test_ulog.ulg",
        "log-ardupilot-dataflash/log171.bin",
    ] {
        let Some(path) = data(file) else { return };
        assert!(
            matches!(read_csv(&path), Err(LogError::NotText { .. })),
            "{file}"
        );
    }
}
