//! Measured logs.
//!
//! The reference values of the `xval_` tests come from plain Python (`csv`, `math`, `statistics`), written apart from
//! this code: medians of the plateaus; normal equations by elimination; lags by the exact answer to held commands, on
//! a grid of lags, with Gauss-Newton steps for eq. (7).

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::{LOG10, without_dead_time, words};
use crate::common::{LARGE_PAGE, SMALL_PAGE, data, json, map, number, page};
use touchdown_model::Card;

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
