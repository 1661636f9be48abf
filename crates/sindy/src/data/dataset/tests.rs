use super::*;

fn ramp(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.1 * i as f64).collect()
}

#[test]
fn prop_gaps_split_and_are_counted() {
    let mut data = Dataset::new(&["x"], &["u"]).unwrap();
    let mut x = ramp(20);
    x[7] = f64::NAN;
    let mut time = ramp(20);
    time[15..].iter_mut().for_each(|t| *t += 5.0);
    data.push("a", time, vec![x, vec![0.0; 20]], None).unwrap();
    let lengths: Vec<usize> = data.stretches().iter().map(|s| s.time.len()).collect();
    assert_eq!(lengths, [7, 7, 5]);
    let report = data.report();
    assert_eq!(
        (
            report.missing_rows,
            report.holes,
            report.rows,
            report.stretches
        ),
        (1, 1, 20, 3)
    );
    assert!(report.uniform && (report.period - 0.1).abs() < 1e-12);
}

#[test]
fn prop_bad_input_is_refused_and_nothing_added() {
    assert!(Dataset::new::<&str>(&[], &[]).is_err());
    assert!(Dataset::new(&["x"], &["x"]).is_err());
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    type Case = (Vec<f64>, Vec<Vec<f64>>, Option<Vec<f64>>, &'static str);
    let cases: Vec<Case> = vec![
        (vec![], vec![vec![]], None, "too few"),
        (ramp(3), vec![], None, "columns"),
        (ramp(3), vec![ramp(2)], None, "expected 3, found 2"),
        (
            ramp(3),
            vec![vec![0.0, f64::INFINITY, 0.0]],
            None,
            "column `x`",
        ),
        (vec![0.0, 0.2, 0.1], vec![ramp(3)], None, "time"),
        (ramp(3), vec![ramp(3)], Some(vec![1.0]), "weights"),
        (
            ramp(3),
            vec![ramp(3)],
            Some(vec![1.0, -1.0, 1.0]),
            "weights",
        ),
    ];
    for (time, columns, weights, says) in cases {
        let error = data
            .push("a", time, columns, weights)
            .unwrap_err()
            .to_string();
        assert!(error.contains(says), "{error}");
    }
    assert_eq!(data.report().trajectories, 0);
}

#[test]
fn prop_rows_without_weight_are_bridged_or_missing() {
    let mut x = ramp(60);
    let mut weights = vec![4.0; 60];
    x[10] = 1e6;
    weights[10] = 0.0;
    for k in 30..40 {
        x[k] = -1e6;
        weights[k] = 0.0;
    }
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    data.push("a", ramp(60), vec![x], Some(weights)).unwrap();
    assert_eq!(
        (data.stretches().len(), data.report().missing_rows),
        (2, 10)
    );
    // A straight line is bridged exactly, up to rounding.
    assert!((data.stretches()[0].columns[0][10] - 1.0).abs() < 1e-12);
    assert_eq!(data.stretches()[0].weights.unwrap()[9], 1.0);
    assert_eq!(data.stretches()[0].weights.unwrap()[10], 0.0);
    let none = data.push("b", ramp(4), vec![ramp(4)], Some(vec![0.0; 4]));
    assert!(none.unwrap_err().to_string().contains("weights"));
}

#[test]
fn prop_random_and_changing_rates_are_no_gaps() {
    // Two rates in one record, and a stray row after a pause: only the pause is a gap.
    let mut time = ramp(200);
    time.extend((0..150).map(|i| 20.0 + 0.5 * f64::from(i)));
    time.push(200.0);
    let n = time.len();
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    data.push("a", time, vec![ramp(n)], None).unwrap();
    let report = data.report();
    assert_eq!(
        (report.stretches, report.holes, report.short_rows),
        (1, 1, 1)
    );
}

#[test]
fn prop_uneven_time_is_said() {
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    let time: Vec<f64> = ramp(50)
        .iter()
        .map(|t| t + 0.02 * (9.0 * t).sin())
        .collect();
    data.push("a", time, vec![ramp(50)], None).unwrap();
    assert!(!data.report().uniform);
    assert_eq!(data.stretches().len(), 1);
}
