//! What happens with each kind of defect in the data: read silently, dropped and warned of, or
//! stated as lost.

use std::fmt::Write;
use touchdown_log::{ErrorKind, Findings, LogError, Map, apply, parse_csv};
use touchdown_trial::Trial;

const MAP: &str = "schema = 1\n[channels]\ntime_s = 't'\nheight_m = 'h'\n";

fn rows(stamps: impl IntoIterator<Item = f64>) -> String {
    stamps.into_iter().fold("t,h\n".to_owned(), |mut text, t| {
        writeln!(text, "{t},{}", 2.0 * t).unwrap();
        text
    })
}

fn even(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / 8.0).collect()
}

fn read(text: &[u8]) -> Result<(Trial, Findings), LogError> {
    let (table, read) = parse_csv("t.csv", text)?;
    let (trial, applied) = apply(&table, &Map::parse("m.toml", MAP)?)?;
    Ok((trial, read.then(applied)))
}

fn ok(text: &str) -> (Trial, Findings) {
    read(text.as_bytes()).unwrap()
}

/// Whatever was dropped, no row that is left is wrong.
fn all_rows_are_true(trial: &Trial) {
    let height = trial.require("height_m").unwrap();
    assert!(
        trial
            .time_s()
            .iter()
            .zip(height)
            .all(|(t, h)| *h == 2.0 * t || h.is_nan())
    );
}

#[test]
fn analytic_gaps_are_kept_without_a_word() {
    let (trial, findings) = ok("\u{feff}t,h\r\n0,0\r\n1,\r\n2,nan\r\n3,6\r\n");
    assert_eq!((trial.len(), findings.rows_used), (4, 4));
    assert!(trial.require("height_m").unwrap()[1].is_nan());
    assert!(findings.warnings.is_empty() && !findings.is_lossy());
    assert_eq!(findings.loss(), None);
}

#[test]
fn analytic_few_duplicate_and_backward_stamps_are_dropped_and_warned_of() {
    let mut stamps = even(400);
    stamps.insert(100, stamps[99]);
    stamps.insert(200, stamps[150]);
    stamps.insert(300, 10.03);
    let (trial, findings) = ok(&rows(stamps));
    assert_eq!(trial.len(), 400);
    assert_eq!(findings.duplicate_stamps, 2);
    assert_eq!(findings.backward_stamps, 1);
    assert_eq!(findings.rows_read, 403);
    assert_eq!(
        findings.warnings,
        [
            "2 of 403 rows repeat a stamp and were dropped",
            "1 of 403 rows have a stamp out of order and were dropped"
        ]
    );
    assert!(!findings.is_lossy());
    all_rows_are_true(&trial);
}

#[test]
fn analytic_one_percent_is_tolerated_and_more_is_loss() {
    for (bad, lossy) in [(2, false), (3, true)] {
        let mut stamps = even(200 - bad);
        let last = stamps[stamps.len() - 1];
        stamps.extend(std::iter::repeat_n(last, bad));
        let (_, findings) = ok(&rows(stamps));
        assert_eq!(findings.rows_read, 200);
        assert_eq!(findings.duplicate_stamps, bad);
        assert_eq!(findings.is_lossy(), lossy, "{bad} of 200");
        assert_eq!(findings.loss().is_some(), lossy);
    }
}

#[test]
fn analytic_a_stray_late_stamp_costs_one_row() {
    let mut stamps = even(400);
    stamps[10] = 1e9;
    let (trial, findings) = ok(&rows(stamps));
    assert_eq!((trial.len(), findings.backward_stamps), (399, 1));
    all_rows_are_true(&trial);
}

#[test]
fn analytic_absent_stamps_are_dropped_and_counted() {
    let (trial, findings) = ok("t,h\n0,0\n,1\n1,2\nnan,9\n2,4\n");
    assert_eq!((trial.len(), findings.absent_stamps), (3, 2));
    assert!(findings.is_lossy()); // 2 of 5 rows
    all_rows_are_true(&trial);
}

#[test]
fn analytic_a_truncated_last_record_is_stated() {
    for tail in ["99.5", "99.5,", "99.5,\"1", "99.5,199e", "99.5,199e+"] {
        let (trial, findings) = ok(&(rows(even(50)) + tail));
        assert_eq!(trial.len(), 50, "{tail}");
        assert!(findings.truncated && findings.is_lossy(), "{tail}");
        assert_eq!(findings.corrupt_rows, 0, "{tail}");
        assert_eq!(findings.rows_read, 51, "{tail}");
        assert!(
            findings.warnings[0].contains("(line 52) breaks off"),
            "{tail}"
        );
        all_rows_are_true(&trial);
    }
    // A whole last row without a line end is nothing to speak of.
    let whole = rows(even(50));
    let (trial, findings) = ok(whole.trim_end());
    assert!(trial.len() == 50 && !findings.is_lossy() && findings.warnings.is_empty());
}

#[test]
fn analytic_a_corrupt_section_costs_its_own_rows() {
    let garbage: [&[u8]; 6] = [
        b"\x00\xff\xfe\x80\n",
        b"0.25,0.5,17\n",
        b"\"0.25,0.5\n",
        b"0.25,\"0.5\"x\n",
        b"0.25,oops\n",
        b"2@5,0.5\n",
    ];
    let text = rows(even(40)).into_bytes();
    let half = text
        .iter()
        .enumerate()
        .filter(|(_, b)| **b == b'\n')
        .nth(20)
        .unwrap()
        .0
        + 1;
    for bad in garbage {
        let bytes = [&text[..half], bad, &text[half..]].concat();
        let (trial, findings) = read(&bytes).unwrap();
        assert_eq!((trial.len(), findings.corrupt_rows), (40, 1), "{bad:?}");
        assert!(findings.is_lossy() && !findings.truncated, "{bad:?}");
        assert!(
            findings.warnings[0].contains("line 22"),
            "{:?}",
            findings.warnings
        );
        all_rows_are_true(&trial);
    }
}

#[test]
fn analytic_infinite_values_become_gaps() {
    let text = "schema = 1\n[channels]\ntime_s = 't'\nx = '1 / h'\n";
    let (table, _) = parse_csv("t.csv", b"t,h\n0,0\n1,2\n").unwrap();
    let (trial, findings) = apply(&table, &Map::parse("m.toml", text).unwrap()).unwrap();
    let x = trial.require("x").unwrap();
    assert!(x[0].is_nan() && x[1] == 0.5);
    assert_eq!(findings.infinite_values, 1);
    assert_eq!(findings.warnings, ["x: 1 infinite values became gaps"]);
}

#[test]
fn analytic_stamps_of_centuries_apart_are_their_seconds() {
    let text = "schema = 1\n[channels]\ntime_s = '-t'\nx = 'x'\n";
    let rows = b"t,x\n2200-01-01 00:00:00,1\n1700-01-01 00:00:00,2\n";
    let (table, _) = parse_csv("t.csv", rows).unwrap();
    let (trial, _) = apply(&table, &Map::parse("m.toml", text).unwrap()).unwrap();
    // 500 years of the Gregorian calendar, 121 of them leap years: more nanoseconds than 63 bits count.
    assert_eq!(trial.duration_s(), (500.0 * 365.0 + 121.0) * 86_400.0);
}

#[test]
fn analytic_no_usable_rows_is_an_error() {
    let error = read(b"t,h\nnan,1\n,2\n").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unreadable);
    assert!(error.to_string().contains("of 2 rows"), "{error}");
}
