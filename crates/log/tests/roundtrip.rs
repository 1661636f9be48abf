//! What is written reads back to the same bits, and nothing is half written.

use proptest::prelude::*;
use touchdown_log::{ErrorKind, read_trial, write_csv};
use touchdown_trial::Trial;

fn bits(values: &[f64]) -> Vec<u64> {
    // Any NaN is the same gap.
    let gap = |v: &f64| {
        if v.is_nan() {
            f64::NAN.to_bits()
        } else {
            v.to_bits()
        }
    };
    values.iter().map(gap).collect()
}

fn assert_round_trip(trial: &Trial) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trial.csv");
    write_csv(trial, &path).unwrap();
    let (back, findings) = read_trial(&path, None).unwrap();
    assert!(!findings.is_lossy(), "{findings:?}");
    assert_eq!(bits(back.time_s()), bits(trial.time_s()));
    assert_eq!(back.channels().len(), trial.channels().len());
    for ((name, values), (expected_name, expected)) in back.channels().zip(trial.channels()) {
        assert_eq!(name, expected_name);
        assert_eq!(bits(values), bits(expected), "{name}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn analytic_extreme_numbers_and_odd_names() {
    let time_s = vec![-1e300, -0.1, 0.0, 5e-324, 1.0 / 3.0, 1e16, f64::MAX];
    let odd = vec![
        -0.0,
        f64::MIN,
        f64::MIN_POSITIVE,
        f64::EPSILON,
        1e-5,
        123_456_789.123_456_78,
        f64::NAN,
    ];
    let trial = Trial::new("t", time_s)
        .unwrap()
        .with_channel("a \"b\", c;µ", odd)
        .unwrap()
        .with_channel("nothing", vec![f64::NAN; 7])
        .unwrap();
    assert_round_trip(&trial);
    assert_round_trip(&Trial::new("t", vec![0.0, 1.0]).unwrap());
}

#[test]
fn analytic_the_text_is_short_and_gaps_are_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let trial = Trial::new("t", vec![0.0, 0.1, 0.2])
        .unwrap()
        .with_channel("height_m", vec![1.0, f64::NAN, 1e-9])
        .unwrap();
    write_csv(&trial, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "time_s,height_m\n0,1\n0.1,\n0.2,1e-9\n");
    // It replaces what was there.
    write_csv(&trial.window(0.0, 0.0).unwrap(), &path).unwrap();
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        "time_s,height_m\n0,1\n"
    );
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let other = folder.path().join("other");
        std::fs::write(&other, "").unwrap();
        let mode = |p: &std::path::Path| std::fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&other));
    }
}

#[test]
fn analytic_a_failed_write_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let trial = Trial::new("t", vec![0.0]).unwrap();
    let error = write_csv(&trial, folder.path().join("absent/t.csv")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unwritable);
    // A folder stands where the file should go.
    std::fs::create_dir(folder.path().join("t.csv")).unwrap();
    assert!(write_csv(&trial, folder.path().join("t.csv")).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn prop_any_trial_reads_back_to_the_same_bits(
        rows in prop::collection::vec(
            (any::<f64>(), any::<f64>(), prop::option::of(-1e3_f64..1e3)), 1..30),
    ) {
        let mut rows: Vec<_> = rows.into_iter().filter(|(t, ..)| t.is_finite()).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.dedup_by(|a, b| a.0 == b.0);
        prop_assume!(!rows.is_empty());
        let trial = Trial::new("t", rows.iter().map(|r| r.0).collect()).unwrap()
            .with_channel("height_m", rows.iter().map(|r| if r.1.is_finite() { r.1 } else { f64::NAN }).collect()).unwrap()
            .with_channel("throttle", rows.iter().map(|r| r.2.unwrap_or(f64::NAN)).collect()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trial.csv");
        write_csv(&trial, &path).unwrap();
        let (back, _) = read_trial(&path, None).unwrap();
        prop_assert_eq!(bits(back.time_s()), bits(trial.time_s()));
        for (name, values) in trial.channels() {
            prop_assert_eq!(bits(back.require(name).unwrap()), bits(values));
        }
    }
}
