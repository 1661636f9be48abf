//! Maps: what they do and what is said of a wrong one.

use touchdown_log::{ErrorKind, Findings, LogError, Map, apply, parse_csv};
use touchdown_trial::{Source, Trial};

const TABLE: &str = "Time (s),ESC signal (µs),note,rpm\n0,1000,a,10\n1,1500,b,11\n2,2000,c,0\n3,1500,d,13\n4,1000,e,14\n";

fn parse(text: &str) -> Result<Map, LogError> {
    Map::parse("m.toml", text)
}

fn run_on(path: &str, map: &str) -> Result<(Trial, Findings), LogError> {
    let (table, _) = parse_csv(path, TABLE.as_bytes())?;
    apply(&table, &parse(map)?)
}

fn run(rest: &str) -> (Trial, Findings) {
    run_on("dir/log10.csv", &with_channels(rest)).unwrap()
}

fn with_channels(rest: &str) -> String {
    format!(
        "schema = 1\n[channels]\ntime_s = '\"Time (s)\"'\nthrottle = '(\"ESC signal (µs)\" - 1000) / 1000'\nrotor_rpm = 'rpm'\n{rest}"
    )
}

fn fault(text: &str) -> String {
    let error = run_on("t.csv", text).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::BadInput, "{error}");
    error.to_string()
}

#[test]
fn analytic_expressions_make_channels_in_the_maps_order() {
    let (trial, findings) = run("");
    let names: Vec<&str> = trial.channels().map(|(name, _)| name).collect();
    assert_eq!(names, ["throttle", "rotor_rpm"]);
    assert_eq!(
        trial.require("throttle").unwrap(),
        [0.0, 0.5, 1.0, 0.5, 0.0]
    );
    assert_eq!((trial.name(), findings.rows_used), ("log10", 5));
    let Source::File { path, sha256 } = &trial.provenance().source else {
        panic!("not from a file");
    };
    assert_eq!((path.as_str(), sha256.len()), ("dir/log10.csv", 64));
    assert_eq!(trial.provenance().notes, ["mapped by m.toml"]);
}

#[test]
fn regress_what_a_definition_names_is_not_taken_for_a_later_one() {
    // The column rpm in `turns`, the definition rpm in the channels.
    let (trial, _) = run("");
    let columns = trial.require("rotor_rpm").unwrap().to_vec();
    let (trial, _) = run("sum = 'turns + rpm'\n[define]\nturns = 'rpm'\nrpm = '1000'\n");
    let sums: Vec<f64> = columns.iter().map(|rpm| rpm + 1000.0).collect();
    assert_eq!(trial.require("sum").unwrap(), sums);
    assert_eq!(trial.require("rotor_rpm").unwrap(), [1000.0; 5]);
    // What a definition misses is not made up for by a later one.
    let text = with_channels("sum = 'turns'\n[define]\nturns = 'rpms'\nrpms = '1000'\n");
    let found = fault(&text);
    assert!(
        found.contains("channels.sum") && found.contains("no column \"rpms\""),
        "{found}"
    );
}

#[test]
fn analytic_filter_and_median() {
    let (trial, findings) = run("[filter]\nkeep = 'rpm > 0'\n");
    assert_eq!(trial.time_s(), [0.0, 1.0, 3.0, 4.0]);
    assert_eq!(findings.rows_filtered, 1);
    assert!(!findings.is_lossy()); // on purpose
    let (trial, _) = run("[filter]\nmedian = { rotor_rpm = 3 }\n");
    assert_eq!(
        trial.require("rotor_rpm").unwrap(),
        [10.0, 10.0, 11.0, 13.0, 14.0]
    );
}

#[test]
fn analytic_windows_hold_for_their_file() {
    let windows = "[[windows]]\nfile = 'log10.csv'\nfrom_s = 1\nto_s = 2\n[[windows]]\nfile = 'log15.csv'\nfrom_s = 4\nto_s = 5\n";
    let (trial, findings) = run(windows);
    assert_eq!(trial.time_s(), [1.0, 2.0]);
    assert_eq!((findings.rows_outside_windows, findings.rows_used), (3, 2));
    let (trial, findings) = run_on("log20.csv", &with_channels(windows)).unwrap();
    assert_eq!(trial.len(), 5);
    assert_eq!(
        findings.warnings,
        ["no window of the map names this file; it is used whole"]
    );
    // Overlapping windows are one, out of order or not.
    let (trial, _) = run("[[windows]]\nfrom_s = 2\nto_s = 3\n[[windows]]\nfrom_s = 1\nto_s = 2\n");
    assert_eq!(trial.time_s(), [1.0, 2.0, 3.0]);
    let error = run_on(
        "t.csv",
        &with_channels("[[windows]]\nfrom_s = 50\nto_s = inf\n"),
    );
    assert!(matches!(error, Err(LogError::NoUsableRows { .. })));
}

#[test]
fn analytic_resampling_is_apart_in_each_window() {
    let (trial, findings) = run(
        "[[windows]]\nfrom_s = 0\nto_s = 1\n[[windows]]\nfrom_s = 3\nto_s = 4\n[resample]\nperiod_s = 0.5\n",
    );
    assert_eq!(trial.time_s(), [0.0, 0.5, 1.0, 3.0, 3.5, 4.0]);
    assert_eq!(
        trial.require("throttle").unwrap(),
        [0.0, 0.25, 0.5, 0.5, 0.25, 0.0]
    );
    assert_eq!(findings.rows_used, 4);
}

#[test]
fn analytic_row_number_mass_and_constants_are_known() {
    let map = "schema = 1\n[channels]\ntime_s = '0.5 * row'\nthrust_n = 'mass_kg * rpm'\nthrottle = '0.25'\n[vehicle]\nmass_kg = 2\n";
    let (trial, _) = run_on("t.csv", map).unwrap();
    assert_eq!(trial.time_s(), [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(trial.require("thrust_n").unwrap()[4], 28.0);
    assert_eq!(trial.require("throttle").unwrap(), [0.25; 5]);
    // A dropped row leaves its place in the numbering.
    let (table, _) = parse_csv("t.csv", b"a,b\n1,2\nx,y,z\n3,4\n").unwrap();
    let map = parse("schema = 1\n[channels]\ntime_s = 'row'\n").unwrap();
    assert_eq!(apply(&table, &map).unwrap().0.time_s(), [0.0, 2.0]);
}

#[test]
fn analytic_implausible_values_are_asked_about_and_kept() {
    let map = "schema = 1\n[channels]\ntime_s = '1000 * \"Time (s)\"'\nthrottle = '\"ESC signal (µs)\"'\n";
    let (trial, findings) = run_on("t.csv", map).unwrap();
    assert_eq!(trial.require("throttle").unwrap()[0], 1000.0);
    assert_eq!(
        findings.warnings,
        [
            "time_s: the median step is 1000 s; is it in milliseconds?",
            "throttle: 5 values lie outside 0 to 1 (from 1000 to 2000)"
        ]
    );
}

#[test]
fn analytic_unknown_columns_are_named() {
    assert_eq!(
        fault(
            "schema = 1\n[channels]\ntime_s = '\"Time (s)\"'\nthrottle = '\"ESC signal (us)\" / 2'\n"
        ),
        "m.toml, line 4, channels.throttle: t.csv has no column \"ESC signal (us)\" (did you mean \"ESC signal (µs)\"?); it has \"Time (s)\", \"ESC signal (µs)\", \"note\", \"rpm\""
    );
    let text =
        fault("schema = 1\n[channels]\ntime_s = '\"Time (s)\"'\n[filter]\nkeep = 'Time > 1'\n");
    assert!(
        text.starts_with(
            "m.toml, line 5, filter.keep: t.csv has no column \"Time\" (did you mean \"Time (s)\"?)"
        ),
        "{text}"
    );
    let text = fault("schema = 1\n[channels]\ntime_s = 'row'\nx = 'mass_kg'\n");
    assert!(text.contains("no column \"mass_kg\"; it has"), "{text}");
    assert_eq!(
        fault("schema = 1\n[channels]\ntime_s = 'row'\nx = 'note'\n"),
        "m.toml, line 4, channels.x: column \"note\" of t.csv holds text, such as \"a\", not numbers"
    );
}

#[test]
fn analytic_wrong_maps_tell_line_key_expected_and_found() {
    for (text, expected) in [
        (
            "schema = 2\n[channels]\ntime_s = 'row'\n",
            "m.toml, line 1, schema: expected 1, the only version of maps that this program knows, found 2",
        ),
        // Whatever else another version has or lacks.
        (
            "# newer\nschema = 2\n[signals]\nt = 'row'\n",
            "m.toml, line 2, schema: expected 1, the only version of maps that this program knows, found 2",
        ),
        (
            "[channels]\ntime_s = 'row'\n",
            "expected the key `schema`, found none",
        ),
        (
            "schema = 1\n[channels]\nx = 'row'\n",
            "channels.time_s: expected an expression for the time in seconds",
        ),
        (
            "schema = 1\n[channel]\ntime_s = 'row'\n",
            "m.toml, line 2, channel: unknown key; the nearest known key is `channels`",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 3\n",
            "m.toml, line 3, channels.time_s: expected a string or a list of strings, found integer `3`",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row +'\n",
            "m.toml, line 3, channels.time_s: ",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n'a b' = 'row'\n",
            "m.toml, line 4, channels: expected a channel name of letters, digits, _ and ., found \"a b\"",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[filter]\nmedian = { x = 3 }\n",
            "m.toml, line 5, filter.median.x: expected one of the channels",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\nx = 'rpm'\n[filter]\nmedian = { x = 4 }\n",
            "m.toml, line 6, filter.median.x: expected an odd number of samples, 1 to 1001, found 4",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[[windows]]\nfrom_s = 3\nto_s = 1\n",
            "m.toml, line 6, windows.to_s: expected a number above from_s = 3, found 1",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[[windows]]\nfrom_s = 3\n",
            "windows: expected the key `to_s`, found none",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[resample]\nperiod_s = 0\n",
            "m.toml, line 5, resample.period_s: expected a finite number above 0, found 0",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[vehicle]\nmass_kg = -1.5\n",
            "m.toml, line 5, vehicle.mass_kg: expected a finite number above 0, found -1.5",
        ),
        (
            "schema = 1\n[channels]\ntime_s = 'row'\n[vehicle]\nmass = 1\n",
            "m.toml, line 5, vehicle.mass: unknown key; the nearest known key is `mass_kg`",
        ),
        ("schema = 1\n[channels\n", "m.toml, line 2"),
    ] {
        let found = fault(text);
        assert!(
            found.contains(expected),
            "{text}\nexpected {expected}\nfound    {found}"
        );
    }
}

#[test]
fn analytic_our_own_names_need_no_map() {
    let (table, _) = parse_csv("t.csv", b"height_m,time_s,who\n1,0,a\n2,1,b\n").unwrap();
    let map = Map::identity_for(&table).unwrap();
    assert_eq!(map.channels().collect::<Vec<_>>(), ["height_m", "time_s"]);
    let (trial, _) = apply(&table, &map).unwrap();
    assert_eq!(trial.require("height_m").unwrap(), [1.0, 2.0]);
    assert!(trial.provenance().notes.is_empty());
}

#[test]
fn analytic_a_foreign_table_needs_a_map_and_gets_one_suggested() {
    let (table, _) = parse_csv("t.csv", TABLE.as_bytes()).unwrap();
    let error = Map::identity_for(&table).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::BadInput);
    let LogError::NeedsMap {
        suggested, columns, ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(columns.len(), 4);
    assert_eq!(
        suggested,
        "schema = 1\n\n[channels]\ntime_s = '\"Time (s)\"'\nthrottle = '(\"ESC signal (µs)\" - 1000) / 1000'\nrotor_rpm = '\"rpm\"'\n# \"note\", text such as \"a\"\n"
    );
    let (trial, _) = apply(&table, &parse(&suggested).unwrap()).unwrap();
    assert_eq!(trial.require("throttle").unwrap()[2], 1.0);
}

#[test]
fn analytic_times_of_which_one_is_left_are_refused_as_such() {
    let refused = |text: &str| {
        let (table, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
        let error = apply(&table, &Map::identity_for(&table).unwrap()).unwrap_err();
        error.to_string()
    };
    let text = refused("time_s,throttle\n1.0,0.1\n1.0,0.2\n1.0,0.3\n");
    assert!(
        text.contains("of 3 rows 2 repeat a stamp and 0 have"),
        "{text}"
    );
    assert!(text.contains("count them by a map"), "{text}");
    let text = refused("time_s,throttle\n3.0,0.1\n2.0,0.2\n1.0,0.3\n");
    assert!(
        text.contains("0 repeat a stamp and 2 have one before"),
        "{text}"
    );
    assert!(text.ends_with("sort the rows by time"), "{text}");
    // One row is a table of one point.
    let (table, _) = parse_csv("t.csv", b"time_s,throttle\n1.0,0.1\n").unwrap();
    assert!(apply(&table, &Map::identity_for(&table).unwrap()).is_ok());
}

#[test]
fn analytic_steps_of_time_name_the_unit_that_makes_them_short() {
    for (step, unit) in [
        (20.0, "milliseconds"),
        (1e4, "microseconds"),
        (1e7, "nanoseconds"),
    ] {
        let rows: String = (0..50)
            .map(|i| format!("{},0.5\n", step * f64::from(i)))
            .collect();
        let text = format!("time_s,throttle\n{rows}");
        let (table, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
        let (_, findings) = apply(&table, &Map::identity_for(&table).unwrap()).unwrap();
        let asked = format!("is it in {unit}?");
        assert!(
            findings.warnings.iter().any(|w| w.ends_with(&asked)),
            "{findings:?}"
        );
    }
}
