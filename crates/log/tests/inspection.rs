//! What is told of a table's and a trial's columns.

use touchdown_log::{inspect, inspect_trial, parse_csv};
use touchdown_trial::Trial;

#[test]
fn analytic_columns_at_different_rates() {
    let mut text = "Time (ms),force (N),on,who\n".to_owned();
    for row in 0..41 {
        let force = if row % 4 == 0 {
            format!("{row}")
        } else {
            String::new()
        };
        text += &format!("{},{force},7,a\n", 10 * row);
    }
    let (table, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
    let seen = inspect(&table, None);
    let time = seen.time.unwrap();
    assert_eq!((time.column.as_str(), time.unit_s), ("Time (ms)", 1e-3));
    assert!(time.unit_stated && time.bad_stamps == 0);
    // Differences of multiples of 10 ms near 0.4 s: rounding is far below 1e-12 s.
    assert!((time.duration_s - 0.4).abs() < 1e-12);
    assert!((time.period_s.unwrap() - 0.01).abs() < 1e-12);
    assert!(time.jitter_s.unwrap() < 1e-12);
    let force = &seen.columns[1];
    assert_eq!((force.count, force.gaps, force.constant), (11, 30, false));
    assert_eq!(
        (force.min, force.median, force.max),
        (Some(0.0), Some(20.0), Some(40.0))
    );
    assert!((force.rate_hz.unwrap() - 25.0).abs() < 1e-9); // inverse of 0.04 s
    assert!(seen.columns[2].constant);
    assert!((seen.columns[2].rate_hz.unwrap() - 100.0).abs() < 1e-9);
    let who = &seen.columns[3];
    assert_eq!(
        (who.text.as_deref(), who.count, who.min),
        (Some("a"), 0, None)
    );
    assert_eq!(
        seen.suggested_map.unwrap(),
        "schema = 1\n\n[channels]\ntime_s = '1e-3 * \"Time (ms)\"'\nthrust_n = '\"force (N)\"'\n# \"on\"\n# \"who\", text such as \"a\"\n"
    );
}

#[test]
fn analytic_a_table_without_time() {
    let (table, _) = parse_csv("t.csv", b"pwm,weight[g]\n1,2\n3,4\n").unwrap();
    let seen = inspect(&table, None);
    assert!(seen.time.is_none() && seen.columns[0].rate_hz.is_none());
    assert_eq!(seen.warnings, ["no time column was found"]);
    assert!(
        seen.suggested_map
            .unwrap()
            .contains("thrust_n = '9.80665e-3 * \"weight[g]\"'")
    );
    let named = inspect(&table, Some("pwm"));
    assert_eq!(named.time.unwrap().period_s, Some(2.0));
    assert_eq!(
        named.warnings,
        [
            "\"pwm\" does not state its unit, and a median step of 2 may be s or ms; rates assume seconds. A map needs your answer"
        ]
    );
    assert_eq!(inspect(&table, Some("nothing")).warnings.len(), 2);
}

#[test]
fn analytic_a_trial_tells_its_units() {
    let trial = Trial::new("t", vec![0.0, 0.5, 1.0])
        .unwrap()
        .with_channel("thrust_n", vec![1.0, f64::NAN, 3.0])
        .unwrap();
    let seen = inspect_trial(&trial);
    let units: Vec<_> = seen
        .columns
        .iter()
        .map(|c| c.unit.as_deref().unwrap())
        .collect();
    assert_eq!(units, ["s", "N"]);
    assert_eq!(seen.columns[1].rate_hz, Some(1.0));
    assert_eq!(seen.time.as_ref().unwrap().period_s, Some(0.5));
    // Absent figures are null.
    let json = serde_json::to_value(&seen).unwrap();
    assert!(json["sha256"].is_null() && json["suggested_map"].is_null());
    assert_eq!(json["columns"][1]["gaps"], 1);
    assert!(
        inspect_trial(&Trial::new("none", vec![]).unwrap())
            .time
            .is_none()
    );
}
