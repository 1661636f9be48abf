//! `touchdown inspect` as a command.

mod common;

use std::path::Path;

use common::{data, fails, json, map, number, rotor_row, run, text, write_log};

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
    assert!(out.join("results.json").exists() && out.join("report.html").exists());
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
