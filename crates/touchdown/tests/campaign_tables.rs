//! What stands in the tables of a campaign: the terminal's, `summary.csv`, `results.json` and the report.

use std::path::Path;

use crate::campaign::{flies, sweep};

/// Flies a sweep; returns what is in `summary.csv`, `results.json` and `report.html`.
fn flown(text: &str) -> [String; 3] {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    flies(&[], &sweep(folder.path(), text), &out);
    let read = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    ["summary.csv", "results.json", "report.html"].map(read)
}

/// One landing whose time is up while it observes the deck.
const SHORT: &str = "trials = 1\n[scenario]\ntimeout_s = 0.2\n";

#[test]
fn regress_both_tilts_have_the_names_of_their_columns() {
    let [table, results, _] = flown(SHORT);
    let header = table.lines().next().unwrap();
    let named = |name: &str| header.split(',').any(|cell| cell == name);
    assert!(
        named("impact_tilt_rad_mean") && named("tilt_rad_mean"),
        "{header}"
    );
    let results: serde_json::Value = serde_json::from_str(&results).unwrap();
    let point = results["points"][0].as_object().unwrap();
    assert!(point.contains_key("impact_tilt_rad") && point.contains_key("tilt_rad"));
}

#[test]
fn regress_go_arounds_out_of_a_hover_are_no_aborted_descents() {
    // The tag is lost before the first descent, and the vehicle lands in it once the tag is back.
    let [_, results, report] = flown(
        "trials = 1\n[scenario]\ntimeout_s = 30.0\n[scenario.faults]\nsince = \"start\"\ntag_lost = [{ from_s = 1.5, to_s = 20.0 }]\n",
    );
    let results: serde_json::Value = serde_json::from_str(&results).unwrap();
    let figures = &results["points"][0];
    assert!(
        !figures["aborts"].as_object().unwrap().is_empty(),
        "{figures}"
    );
    assert_eq!(figures["landed_at_first"]["count"], 1);
    assert!(report.contains("Go-arounds by reason") && !report.contains("borted descent"));
}

#[test]
fn regress_labels_of_points_tell_swept_keys_apart() {
    let grid = "[grid]\n\"sensors.range.schedule.rate_hz\" = [50.0, 25.0]\n\"sensors.tag.schedule.rate_hz\" = [30.0, 15.0]\n";
    let [_, _, report] = flown(&format!("{SHORT}{grid}"));
    let label = "range.schedule.rate_hz 25.0, tag.schedule.rate_hz 30.0";
    assert!(report.contains(label));
}

#[test]
fn regress_the_report_says_how_trials_that_did_not_land_ended() {
    let [_, _, report] = flown(SHORT);
    for part in ["Given up", "Timed out", "1 timed out in phase hold (deck)"] {
        assert!(report.contains(part), "{part}");
    }
}

#[test]
fn regress_who_never_came_to_wait_has_no_waiting_time() {
    let [table, results, _] = flown(SHORT);
    let results: serde_json::Value = serde_json::from_str(&results).unwrap();
    assert_eq!(results["points"][0]["waited_s"]["count"], 0);
    let lines: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    let mean = lines[0]
        .iter()
        .position(|name| *name == "waited_s_mean")
        .unwrap();
    assert_eq!(lines[1][mean], "");
}
