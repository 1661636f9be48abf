//! `touchdown identify` as a command, on measured logs and on made ones.
//!
//! The reference values of the `xval_` tests come from plain Python (`csv`, `math`, `statistics`), written apart from
//! this code: medians of the plateaus; normal equations by elimination; lags by the exact answer to held commands, on
//! a grid of lags, with Gauss-Newton steps for eq. (7).

mod common;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use common::{
    LARGE_PAGE, SMALL_PAGE, data, fails, json, map, number, page, rotor_row, run, text, write_log,
};
use touchdown_model::Card;

const LOG10: &str = "flight-crazyflie-1khz-throttle/log10.csv";

fn words(args: &[&str], paths: &[&Path]) -> Vec<OsString> {
    let args = args.iter().map(OsString::from);
    args.chain(paths.iter().map(OsString::from)).collect()
}

/// Settings in which the lag takes the dead time in, as in the reference values.
fn without_dead_time(folder: &Path) -> PathBuf {
    let path = folder.join("none.toml");
    std::fs::write(&path, "[thrust]\ndead_time = \"none\"\n").unwrap();
    path
}

#[test]
fn xval_staircase_of_a_thrust_stand() {
    let Some(log) = data("thrust-7in-rcbenchmark-staircase/Log_2019-11-09_181347.csv") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let map = map("thrust-7in-rcbenchmark.toml");
    let args = ["identify", "thrust", "--map"];
    let mut args = words(&args, &[&map, &log]);
    args.extend(words(&["--out"], &[&out]));
    let found = json(0, args);
    assert_eq!(
        found["form"], "static_sqrt",
        "plateaus call for a static map"
    );
    assert_eq!(
        (&found["rmse"]["unit"], &found["rows_used"]),
        (&"√N".into(), &23.into())
    );
    assert!(number(&found["rmse"]["value"]) <= 0.05, "{found}");
    // Two ways of solving the same least squares: 1e-9 is far above their rounding.
    assert!(
        (number(&found["rmse"]["value"]) - 0.046_074_721_918).abs() < 1e-9,
        "{found}"
    );
    for (name, expected) in [
        ("1", -0.300_243_380_496),
        ("s", 7.469_122_709_362),
        ("s^2", -3.051_927_044_733),
    ] {
        let value = number(&found["coefficients"][format!("x:{name}")]["value"]);
        assert!((value - expected).abs() < 1e-9, "{name} = {value}");
    }
    // Reference values of 18 steps fitted one by one: lag 0.032 s, dead time 0.036 s on average, with standard errors
    // of 2 ms; the bars are 0.030 to 0.040 s and about 0.035 s.
    assert!(
        (0.030..=0.040).contains(&number(&found["lag_s"])),
        "{found}"
    );
    let dead_time = number(&found["coefficients"]["dead_time"]["value"]);
    assert!((dead_time - 0.035).abs() < 0.005, "{dead_time}");
    assert_eq!(
        found["rows_dropped"], 5,
        "one repeated stamp and four out of order"
    );
    let card = Card::read(&out.join("Log_2019-11-09_181347.toml")).unwrap();
    for branch in ["ascending", "descending"] {
        assert!(
            card.scores
                .iter()
                .any(|s| s.trial == branch && s.unit == "N"),
            "{branch} is shown apart"
        );
    }
    for file in [
        "report.html",
        "results.json",
        "summary.csv",
        "inputs/settings.toml",
    ] {
        assert!(out.join(file).exists(), "{file}");
    }
    let pictures = std::fs::read_dir(out.join("figures")).unwrap().count();
    assert_eq!(pictures, 4, "curve and course, each as SVG and PNG");
    page(&out, SMALL_PAGE);
}

#[test]
fn xval_lagged_motors_in_flight() {
    let Some(log) = data(LOG10) else { return };
    let map = map("flight-crazyflie-1khz-throttle.toml");
    let folder = tempfile::tempdir().unwrap();
    let settings = without_dead_time(folder.path());
    let args = ["identify", "thrust", "--form", "lagged_motors"];
    let mut args = words(&args, &[]);
    args.extend(words(&["--settings"], &[&settings]));
    args.extend(words(&["--map"], &[&map, &log]));
    let found = json(0, args);
    assert_eq!(found["form"], "lagged_motors");
    // Reference values 0.0735 s and 0.01324 N, the lag on a grid of 0.5 ms; the bars are wider.
    assert!((number(&found["lag_s"]) - 0.0735).abs() <= 0.005, "{found}");
    assert!(
        number(&found["rmse"]["value"]) <= 0.0135 && found["rmse"]["unit"] == "N",
        "{found}"
    );
    let rmse = number(&found["rmse"]["value"]);
    // At the minimum the residual does not feel half a step of the grid.
    assert!((rmse - 0.013_238_243).abs() < 1e-6, "{rmse}");
    assert!(found["card"].is_null(), "nothing is written without --out");
    assert_eq!(found["rows_used"], 33_528);
}

#[test]
fn xval_first_order_in_flight() {
    let Some(log) = data(LOG10) else { return };
    let map = map("flight-crazyflie-1khz-throttle.toml");
    let folder = tempfile::tempdir().unwrap();
    let settings = without_dead_time(folder.path());
    let args = ["identify", "thrust", "--form", "first_order", "--settings"];
    let mut args = words(&args, &[&settings]);
    args.extend(words(&["--map"], &[&map, &log]));
    let found = json(0, args);
    // Reference values 0.080 s and 0.0160 N, the lag on a grid of 1 ms; the bars are wider.
    assert!(
        (number(&found["coefficients"]["T_m"]["value"]) - 0.080).abs() <= 0.006,
        "{found}"
    );
    assert!(number(&found["rmse"]["value"]) <= 0.017, "{found}");
}

#[test]
fn prop_all_propellers_in_one_command() {
    let Some(folder) = data("thrust-5in-props-static") else {
        return;
    };
    let mut logs: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "csv"))
        .collect();
    logs.sort();
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("out");
    let mut args = words(
        &["identify", "thrust", "--map"],
        &[&map("thrust-5in-props-static.toml")],
    );
    args.extend(logs.iter().map(OsString::from));
    args.extend(words(&["--out"], &[&out]));
    let found = json(0, args);
    let all = found.as_array().unwrap();
    assert_eq!((all.len(), logs.len()), (96, 96));
    for one in all {
        // Held-out points decide between the root and the thrust; a table of eleven points shows no lag.
        let form = one["form"].as_str().unwrap();
        assert!(["static_sqrt", "static_thrust"].contains(&form), "{one}");
        assert!(one["lag_s"].is_null());
        let of = |f: &serde_json::Value| f["held_out_rmse_n"].as_f64();
        let forms = one["forms"].as_array().unwrap();
        let best = forms.iter().filter_map(of).fold(f64::INFINITY, f64::min);
        let chosen: Vec<_> = forms.iter().filter(|f| f["chosen"] == true).collect();
        // The rule of the choice.
        assert!(
            chosen.len() == 1 && of(chosen[0]).unwrap() <= 1.05 * best,
            "{one}"
        );
        // A quadratic in throttle leaves 0.01 √N where the supply holds; the worst file's supply gives in at 70 %.
        assert!(number(&one["rmse"]["value"]) < 0.12, "{one}");
        let card = Card::read(Path::new(one["card"].as_str().unwrap())).unwrap();
        // The log, and the map.
        assert_eq!(card.provenance.inputs.len(), 2);
    }
    let summary = std::fs::read_to_string(out.join("summary.csv")).unwrap();
    assert_eq!(summary.lines().count(), 97, "one table, a line a file");
    let limited: Vec<&str> = summary
        .lines()
        .filter(|l| l.contains("falls at the highest throttles: supply limit"))
        .collect();
    // By eye in the data: at 1.81 ms c3_11 gives 417.6 gf, at 2 ms 376.9 gf; c3_7 rises to the end.
    assert!(limited.iter().any(|l| l.starts_with("c3_11.csv")));
    assert!(
        !limited.iter().any(|l| l.contains("_7.csv")),
        "{limited:#?}"
    );
    // 97 fits, each with its figures.
    page(&out, 5 * LARGE_PAGE);
}

#[test]
fn prop_battery_voltage_explains_some_of_the_sag() {
    let Some(log) = data("thrust-crazyflie21-scale/cf2.1-stock-prop.csv") else {
        return;
    };
    let map = map("thrust-crazyflie21-scale.toml");
    let args = ["identify", "thrust", "--form", "static_thrust", "--map"];
    let without = json(0, words(&args, &[&map, &log]));
    let args = [
        "identify",
        "thrust",
        "--form",
        "static_thrust",
        "--battery",
        "--map",
    ];
    let with = json(0, words(&args, &[&map, &log]));
    assert!(with["coefficients"]["T:s*u"]["value"].is_number());
    // One more term cannot fit worse; that it leaves a tenth less is what the data say.
    assert!(number(&with["rmse"]["value"]) < 0.9 * number(&without["rmse"]["value"]));
    assert!(with["lag_s"].is_null(), "rows without a clock show no lag");
}

#[test]
fn analytic_rotor_is_found_from_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let (log, card) = (
        folder.path().join("rotor.csv"),
        folder.path().join("thrust.toml"),
    );
    write_log(&log, 3000, rotor_row);
    let mut args = words(&["identify", "thrust"], &[&log]);
    args.extend(words(&["--out"], &[&card]));
    let found = json(0, args);
    assert_eq!(found["form"], "first_order");
    for (name, expected) in [("T_m", 0.1), ("c0", 2.0), ("c1", 1.0)] {
        // Noise-free: what is left is the free run's linear interpolation of the throttle between rows, some 1e-4.
        let value = number(&found["coefficients"][name]["value"]);
        assert!(
            (value - expected).abs() < 2e-3 * expected,
            "{name} = {value}"
        );
    }
    assert_eq!(found["card"], card.display().to_string());
    assert_eq!(
        Card::read(&card).unwrap().provenance.inputs[0].name,
        "rotor.csv"
    );
}

#[test]
fn prop_a_library_is_fitted_to_one_log_as_well() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("rotor.csv");
    write_log(&log, 3000, rotor_row);
    let found = json(
        0,
        words(&["identify", "thrust", "--form", "library"], &[&log]),
    );
    // The library holds the truth: what it leaves is the smoothing's error.
    assert!(number(&found["rmse"]["value"]) < 0.01, "{found}");
}

#[test]
fn prop_logs_apart_go_on_past_one_that_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("good.csv"), 3000, rotor_row);
    write_log(&path("still.csv"), 3000, |i| {
        format!("{},0.5,4", 0.01 * i as f64)
    });
    std::fs::write(path("empty.csv"), "").unwrap();
    let out = path("out");
    let mut args = words(
        &["identify", "thrust"],
        &[&path("still.csv"), &path("good.csv"), &path("empty.csv")],
    );
    args.extend(words(&["--out"], &[&out]));
    let found = json(3, args);
    assert!(
        found[0]["error"]
            .as_str()
            .unwrap()
            .contains("a throttle that moves"),
        "{found}"
    );
    assert_eq!(found[1]["form"], "first_order");
    assert!(
        found[2]["error"].as_str().unwrap().contains("empty file"),
        "{found}"
    );
    assert!(out.join("good.toml").exists() && !out.join("still.toml").exists());
    fails(
        1,
        words(
            &["identify", "thrust"],
            &[&path("still.csv"), &path("empty.csv")],
        ),
    );
}

#[test]
fn prop_bad_input_is_one_error_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("good.csv"), 3000, rotor_row);
    write_log(&path("three.csv"), 3, rotor_row);
    write_log(&path("gaps.csv"), 3000, |i| {
        format!("{},nan,nan", 0.01 * i as f64)
    });
    write_log(&path("reversed.csv"), 3000, |i| {
        format!("{},{},-4", 0.01 * i as f64, i % 7)
    });
    write_log(&path("huge.csv"), 3000, |i| {
        format!("{},0.{},{}e300", 0.01 * i as f64, i % 7, 1 + i % 7)
    });
    write_log(&path("header.csv"), 0, rotor_row);
    std::fs::write(path("empty.csv"), "").unwrap();
    std::fs::write(path("numbers.csv"), "0,1\n1,2\n").unwrap();
    let card = path("card.toml");
    let fit = |log: &str, more: &[&str]| {
        let mut args = words(&["identify", "thrust"], &[&path(log)]);
        args.extend(words(&["--out"], &[&card]));
        args.extend(words(more, &[]));
        args
    };
    for (log, what) in [
        ("missing.csv", "missing.csv: cannot be read"),
        (".", "cannot be read"),
        ("empty.csv", "found an empty file"),
        ("header.csv", "no usable rows"),
        ("three.csv", "found 3 points at 3 levels"),
        ("gaps.csv", "gaps only"),
        ("reversed.csv", "is its sign reversed?"),
        ("huge.csv", "a finite fit"),
    ] {
        let error = fails(1, fit(log, &[]));
        assert!(error.contains(what), "{log}: {error}");
    }
    // Columns without names are read, and need a map.
    let error = fails(2, fit("numbers.csv", &[]));
    assert!(
        error.contains("found the columns \"c1\", \"c2\""),
        "{error}"
    );
    for (name, content, what) in [
        (
            "key.toml",
            "schema = 1\nkey = 2\n[channels]\ntime_s = 'time_s'\n",
            "key.toml, line 2",
        ),
        (
            "column.toml",
            "schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = 'throttel'\n",
            "line 4, channels.throttle: ",
        ),
        (
            "mass.toml",
            "schema = 1\n[channels]\ntime_s = 'time_s'\n[vehicle]\nmass_kg = -1\n",
            "expected a finite number above 0, found -1",
        ),
    ] {
        std::fs::write(path(name), content).unwrap();
        let error = fails(
            2,
            fit("good.csv", &["--map", &path(name).display().to_string()]),
        );
        assert!(error.contains(what), "{name}: {error}");
    }
    for (content, what) in [
        ("[thrust]\ndegre = 3\n", "degre"),
        ("[thrust]\ndegree = 0\n", "expected 1 to 6, found 0"),
        ("[smoothing]\nwindow = 4\n", "found 4"),
    ] {
        std::fs::write(path("settings.toml"), content).unwrap();
        let settings = path("settings.toml").display().to_string();
        let error = fails(2, fit("good.csv", &["--settings", &settings]));
        assert!(
            error.contains(what) && error.contains("settings.toml"),
            "{error}"
        );
    }
    let left: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|n| n.starts_with('.') || n == "card.toml")
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn prop_losses_are_told_by_the_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    let stamps = |every: usize| {
        write_log(&log, 3000, |i| {
            let row = rotor_row(i);
            let (_, rest) = row.split_once(',').unwrap();
            let t = 0.01 * if i % every == every - 1 { i - 1 } else { i } as f64;
            format!("{t},{rest}")
        });
    };
    // 10 of 3000 rows repeat a stamp: warned of; 60 of them: lost.
    stamps(300);
    let found = json(0, words(&["identify", "thrust"], &[&log]));
    assert_eq!(found["rows_dropped"], 10);
    assert!(
        text(&run(words(&["identify", "thrust"], &[&log])).stderr)
            .contains("warning: 10 of 3000 rows")
    );
    stamps(50);
    assert_eq!(
        json(3, words(&["identify", "thrust"], &[&log]))["rows_dropped"],
        60
    );
    // The last record breaks off.
    write_log(&log, 3000, rotor_row);
    let whole = std::fs::read_to_string(&log).unwrap();
    std::fs::write(&log, whole.trim_end().rsplit_once(',').unwrap().0).unwrap();
    assert_eq!(
        json(3, words(&["identify", "thrust"], &[&log]))["rows_dropped"],
        1
    );
}

#[test]
fn prop_ground_effect_needs_a_thrust_card_and_its_channels() {
    let folder = tempfile::tempdir().unwrap();
    let (log, card) = (
        folder.path().join("log.csv"),
        folder.path().join("thrust.toml"),
    );
    write_log(&log, 3000, rotor_row);
    let mut args = words(&["identify", "thrust"], &[&log]);
    args.extend(words(&["--out"], &[&card]));
    assert!(run(args).status.success());
    let ground = |thrust: &Path, more: &[&str]| {
        let mut args = words(&["identify", "ground-effect"], &[&log]);
        args.extend(words(&["--thrust"], &[thrust]));
        args.extend(words(more, &[]));
        args
    };
    assert!(fails(2, ground(&card, &[])).contains("height_m"));
    assert!(fails(2, ground(&folder.path().join("none.toml"), &[])).contains("none.toml"));
    fails(2, ground(&log, &[]));
    let published = folder.path().join("eq12.toml");
    std::fs::write(&published, touchdown_model::published::EQ_12).unwrap();
    assert!(fails(2, ground(&published, &[])).contains("expected `thrust`"));
    let other = folder.path().join("other.toml");
    let schema = std::fs::read_to_string(&card)
        .unwrap()
        .replace("schema = 1", "schema = 7");
    std::fs::write(&other, schema).unwrap();
    assert!(fails(2, ground(&other, &[])).contains("key `schema`: expected 1, found 7"));
}

/// Ctrl-C while files are written leaves whole files and no temporary ones, and says that some are missing.
#[cfg(unix)]
#[test]
fn prop_an_interrupted_identification_says_what_is_missing() {
    if common::ignores_interrupts() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let logs: Vec<PathBuf> = (0..8)
        .map(|k| folder.path().join(format!("log{k}.csv")))
        .collect();
    for (k, log) in logs.iter().enumerate() {
        write_log(log, 600 + 10 * k, rotor_row);
    }
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_touchdown"))
        .args(["--json", "identify", "thrust"])
        .args(&logs)
        .arg("--out")
        .arg(&out)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Cards come first, then the figures, whose images take a while.
    while !out.join("log7.toml").exists() && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    let signal = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signal.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{errors}");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["outcome"], "interrupted");
    let expected = format!(
        "interrupted: the files in {} are complete, but some are missing",
        out.display()
    );
    assert!(errors.contains(&expected), "{errors}");
    assert!(!out.join("results.json").exists());
    for k in 0..8 {
        Card::read(&out.join(format!("log{k}.toml"))).unwrap();
    }
    for folder in [&out, &out.join("figures")] {
        let names = std::fs::read_dir(folder).into_iter().flatten();
        let names = names.map(|entry| entry.unwrap().file_name());
        let temporary = |name: &OsString| name.to_string_lossy().starts_with(".touchdown-");
        assert_eq!(names.into_iter().find(temporary), None);
    }
}
