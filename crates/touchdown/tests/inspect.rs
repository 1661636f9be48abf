//! `touchdown inspect` as a command.

use std::fmt::Write as _;
use std::path::Path;

use touchdown_log::UlogWriter;

use crate::common::{
    SMALL_PAGE, data, fails, json, map, number, page, rotor_row, run, text, write_log,
};

fn arguments(paths: &[&Path]) -> Vec<std::ffi::OsString> {
    std::iter::once("inspect".into())
        .chain(paths.iter().map(std::ffi::OsString::from))
        .collect()
}

#[test]
fn analytic_channels_of_a_made_log() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    // Thrust at every third row, one row with a repeated stamp.
    write_log(&log, 301, |i| {
        let t = 0.01 * if i == 200 { 199 } else { i } as f64;
        format!(
            "{t},0.5,{}",
            if i % 3 == 0 {
                i.to_string()
            } else {
                String::new()
            }
        )
    });
    let found = json(0, arguments(&[&log]));
    let one = &found["logs"][0];
    assert_eq!(one["rows"], 301);
    let channels = &one["channels"];
    assert_eq!(channels["rows"], 300, "the repeated stamp is dropped");
    let column = |name: &str| {
        let all = channels["columns"].as_array().unwrap();
        all.iter().find(|c| c["name"] == name).unwrap().clone()
    };
    let thrust = column("thrust_n");
    assert_eq!(
        (&thrust["unit"], &thrust["min"], &thrust["max"]),
        (&"N".into(), &0.0.into(), &300.0.into())
    );
    // 0, 3, …, 300: 101 values, none of them in the dropped row.
    assert_eq!(
        (&thrust["count"], &thrust["gaps"]),
        (&101.into(), &199.into())
    );
    // A value every 0.03 s, to rounding of the stamps.
    assert!((number(&thrust["rate_hz"]) - 100.0 / 3.0).abs() < 1e-6);
    assert_eq!(column("throttle")["constant"], true);
    assert!((number(&channels["time"]["duration_s"]) - 3.0).abs() < 1e-12);
    assert_eq!(one["findings"]["duplicate_stamps"], 1);
    assert!(one["suggested_map"].is_null(), "the columns are channels");
}

#[test]
fn prop_a_foreign_log_gets_a_map_that_works() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("stand.csv");
    let rows: String = (0..40)
        .map(|i| format!("{},{},{}\n", 10 * i, 1000 + 20 * i, 5 * i))
        .collect();
    std::fs::write(
        &log,
        format!("Time (ms),ESC signal (µs),Thrust (gf)\n{rows}"),
    )
    .unwrap();
    let found = json(0, arguments(&[&log]));
    let suggested = found["logs"][0]["suggested_map"].as_str().unwrap();
    assert!(found["logs"][0]["channels"].is_null());
    let map = folder.path().join("map.toml");
    std::fs::write(&map, suggested).unwrap();
    let mapped = json(0, arguments(&[&log, Path::new("--map"), &map]));
    let columns = mapped["logs"][0]["channels"]["columns"].as_array().unwrap();
    let thrust = columns.iter().find(|c| c["name"] == "thrust_n").unwrap();
    // 195 gf; one rounding.
    assert!((number(&thrust["max"]) - 195.0 * 9.80665e-3).abs() < 1e-12);
}

#[test]
fn prop_plots_and_report_of_a_measured_log() {
    let Some(log) = data("thrust-7in-rcbenchmark-staircase/Log_2019-11-09_181347.csv") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let map = map("thrust-7in-rcbenchmark.toml");
    let args = arguments(&[&log, Path::new("--map"), &map, Path::new("--out"), &out]);
    let output = run(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    for word in [
        "15875 rows",
        "15870 rows",
        "thrust_n",
        "6.66",
        "rotor_rpm",
        "1/min",
    ] {
        assert!(shown.contains(word), "{word} in {shown}");
    }
    assert!(text(&output.stderr).contains("4 of 15875 rows have a stamp out of order"));
    assert!(out.join("results.json").exists());
    page(&out, SMALL_PAGE);
    // Six channels in one figure, as SVG and PNG.
    assert_eq!(std::fs::read_dir(out.join("figures")).unwrap().count(), 2);
}

#[test]
fn prop_what_is_lost_or_cannot_be_read_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("good.csv"), 100, rotor_row);
    let whole = std::fs::read_to_string(path("good.csv")).unwrap();
    std::fs::write(
        path("broken.csv"),
        whole.trim_end().rsplit_once(',').unwrap().0,
    )
    .unwrap();
    std::fs::write(path("empty.csv"), "").unwrap();
    assert_eq!(
        json(3, arguments(&[&path("broken.csv")]))["logs"][0]["findings"]["truncated"],
        true
    );
    let both = json(3, arguments(&[&path("empty.csv"), &path("good.csv")]));
    assert!(
        both["logs"][0]["error"]
            .as_str()
            .unwrap()
            .contains("empty file")
    );
    assert_eq!(both["logs"][1]["rows"], 100);
    assert!(fails(1, arguments(&[&path("empty.csv")])).contains("empty.csv: expected a header"));
    assert!(fails(1, arguments(&[folder.path()])).contains("cannot be read"));
    std::fs::write(
        path("map.toml"),
        "schema = 1\n[channels]\ntime_s = 'tim_s'\n",
    )
    .unwrap();
    let error = fails(
        2,
        arguments(&[&path("good.csv"), Path::new("--map"), &path("map.toml")]),
    );
    assert!(
        error.contains("map.toml, line 3, channels.time_s") && error.contains("did you mean"),
        "{error}"
    );
    // An output folder that is a file, and one below a file.
    fails(
        2,
        arguments(&[&path("good.csv"), Path::new("--out"), &path("empty.csv")]),
    );
    fails(
        1,
        arguments(&[
            &path("good.csv"),
            Path::new("--out"),
            &path("empty.csv").join("out"),
        ]),
    );
}

/// Rows of 70 MB in all, with a pause of an hour: what is more than 64 MB is counted part by part.
#[test]
fn analytic_a_large_table_is_told_without_channels() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("large.csv");
    let rows = 2_000_000_u32;
    let mut text = String::from("time_s,throttle,pad\n");
    for i in 0..rows {
        let pause = if i < rows / 2 { 0 } else { 3600 };
        let (second, ms) = (1_000_000 + i / 1000 + pause, i % 1000);
        writeln!(text, "{second}.{ms:03},0.5,{:020}", i % 11).unwrap();
    }
    assert!(text.len() > 70_000_000);
    std::fs::write(&log, text).unwrap();
    let found = json(0, arguments(&[&log]));
    let one = &found["logs"][0];
    assert_eq!(one["rows"], rows);
    assert!(one["channels"].is_null() && one["suggested_map"].is_null());
    let pad = &one["columns"][2];
    assert_eq!((&pad["count"], &pad["max"]), (&rows.into(), &10.0.into()));
    // Of the numbers 0 to 10 in turn.
    assert_eq!(pad["median"], 5.0);
    // Stamps of 1e6 s are told to 1e-10 s.
    assert!((number(&one["time"]["period_s"]) - 1e-3).abs() < 1e-9);
    let warnings = one["warnings"].to_string();
    assert!(
        warnings.contains("after row 999999, 999.999 s from the start, by 3600 s"),
        "{warnings}"
    );
    let told = one["findings"]["warnings"].to_string();
    assert!(told.contains("more than 64 MB"), "{told}");
}

/// A flight of 4 s as PX4 logs it: accelerometer at 250 Hz, motors at 100 Hz, and a stretch of
/// 0.5 s without motors.
fn px4_log() -> Vec<u8> {
    let mut log = UlogWriter::new(Vec::new(), 5_000_000).unwrap();
    log.parameter("THR_MDL_FAC", 0.5).unwrap();
    for (name, fields) in [
        (
            "sensor_combined",
            "float[3] gyro_rad;float[3] accelerometer_m_s2",
        ),
        ("actuator_motors", "float[12] control"),
        ("vehicle_attitude", "float[4] q"),
    ] {
        log.format(name, fields).unwrap();
    }
    let imu = log.topic("sensor_combined", 0).unwrap();
    let motors = log.topic("actuator_motors", 0).unwrap();
    let attitude = log.topic("vehicle_attitude", 0).unwrap();
    for i in 0..1000_u64 {
        let stamp = 5_000_000 + 4000 * i;
        log.message(imu, stamp, &[0.0, 0.0, 0.0, 0.0, 0.0, -9.75])
            .unwrap();
        if i % 5 == 0 && !(500..625).contains(&i) {
            let mut control = [f64::NAN; 12];
            control[..4].fill(0.375);
            log.message(motors, stamp, &control).unwrap();
        }
        if i % 5 == 0 {
            log.message(attitude, stamp, &[1.0, 0.0, 0.0, 0.0]).unwrap();
        }
    }
    log.finish().unwrap()
}

#[test]
fn analytic_a_px4_log_whatever_its_name() {
    let folder = tempfile::tempdir().unwrap();
    // Told by its content.
    let log = folder.path().join("flight.csv");
    std::fs::write(&log, px4_log()).unwrap();
    let found = json(0, arguments(&[&log]));
    let one = &found["logs"][0];
    assert_eq!(one["format"], "ulog");
    assert_eq!(one["recommended_map"], "px4");
    assert_eq!(one["parameters"]["THR_MDL_FAC"], 0.5);
    let topics = one["topics"].as_array().unwrap();
    let topic = |key: &str| topics.iter().find(|t| t["key"] == key).unwrap();
    assert_eq!(topic("sensor_combined")["messages"], 1000);
    assert!((number(&topic("sensor_combined")["rate_hz"]) - 250.0).abs() < 1e-6);
    assert_eq!(topic("actuator_motors")["gaps"], 1);
    assert!((number(&topic("actuator_motors")["longest_step_s"]) - 0.52).abs() < 1e-9);
    let channels = one["channels"]["columns"].as_array().unwrap();
    let channel = |name: &str| channels.iter().find(|c| c["name"] == name).unwrap();
    // c = f s² + (1 - f) s with c = 0.375 and f = 0.5 gives s = 0.5, from floats of 24 bits.
    assert!((number(&channel("throttle")["median"]) - 0.5).abs() < 1e-7);
    // The last command holds for ten steps of 0.02 s, at 0.48 to 2.18 s and from 2.5 s.
    assert_eq!(channel("throttle")["gaps"], (625 - 546));
    assert_eq!(number(&channel("specific_force_mps2")["max"]), 9.75);
    assert_eq!(number(&channel("tilt_rad")["max"]), 0.0);
    let warnings = one["findings"]["warnings"].to_string();
    assert!(warnings.contains("height_m: omitted"), "{warnings}");

    // The built-in map by name, the report, and a log that is cut.
    let out = folder.path().join("out");
    let args = arguments(&[
        &log,
        Path::new("--map"),
        Path::new("px4"),
        Path::new("--out"),
        &out,
    ]);
    let output = run(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    assert!(
        shown.contains("PX4 ULog, 3 topics, 1375 messages"),
        "{shown}"
    );
    assert!(shown.contains("gyro_rad[] accelerometer_m_s2[]"), "{shown}");
    assert!(
        std::fs::read_to_string(out.join("report.html"))
            .unwrap()
            .contains("Topics.")
    );
    let whole = px4_log();
    std::fs::write(&log, &whole[..whole.len() - 7]).unwrap();
    let cut = json(3, arguments(&[&log]));
    assert_eq!(cut["logs"][0]["findings"]["truncated"], true);
    std::fs::write(&log, &whole[..12]).unwrap();
    assert!(fails(1, arguments(&[&log])).contains("PX4 ULog that ends in its header"));
}
