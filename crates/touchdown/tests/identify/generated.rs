//! Logs of known truth, and several logs in one command.

use super::words;
use crate::common::{fails, json, number, rotor_row, write_log};
use touchdown_model::Card;

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
        // The log has no noise. The free run interpolates the throttle between rows, which errs by about 1e-4.
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
