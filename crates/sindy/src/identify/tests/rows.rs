//! Rows that are left out, weighed, or late.

use super::*;

#[test]
fn prop_weights_that_differ_are_said_to_count_in_part() {
    let problem = problems::lotka_volterra();
    let record = problem.noisy(1.0, 3).unwrap().remove(0);
    let rows = 1500;
    let fit = |weight: &dyn Fn(usize) -> f64, discrete: bool| {
        let mut data = Dataset::new(&problem.states, &[]).unwrap();
        let columns = record.states.iter().map(|c| c[..rows].to_vec()).collect();
        let weights = (0..rows).map(weight).collect();
        data.push("run", record.time[..rows].to_vec(), columns, Some(weights))
            .unwrap();
        let settings = Settings {
            method: Method::Regression,
            discrete,
            ..Settings::default()
        };
        let found = Identify::new(problem.library().unwrap())
            .settings(settings)
            .unwrap()
            .run(&data, &mut quiet())
            .unwrap();
        found.warnings.iter().any(|w| w.contains("weights differ"))
    };
    let differ = |k: usize| if k.is_multiple_of(3) { 4.0 } else { 1.0 };
    assert!(fit(&differ, false));
    // No smoothing and no weak form in discrete time.
    assert!(!fit(&differ, true));
    assert!(!fit(&|k| if k == 70 { 0.0 } else { 2.0 }, false));
}

#[test]
fn prop_rows_too_short_to_use_are_reported() {
    let problem = problems::van_der_pol();
    let record = problem.noisy(1.0, 1).unwrap().remove(0);
    let mut columns: Vec<Vec<f64>> = record.states.iter().map(|c| c[..1200].to_vec()).collect();
    // Four rows in succession are not bridged.
    columns[0][700..704].fill(f64::NAN);
    columns[1][706..710].fill(f64::NAN);
    let mut data = Dataset::new(&problem.states, &[]).unwrap();
    data.push("run", record.time[..1200].to_vec(), columns, None)
        .unwrap();
    let settings = Settings {
        method: Method::Regression,
        ..Settings::default()
    };
    let found = Identify::new(problem.library().unwrap())
        .settings(settings)
        .unwrap()
        .run(&data, &mut quiet())
        .unwrap();
    let said = found.warnings.iter().any(|w| {
        w.contains("into 2 stretches: 8 rows with missing")
            && w.contains("2 rows in stretches too short")
    });
    assert!(said, "{:?}", found.warnings);
}

#[test]
fn prop_when_time_began_means_nothing() {
    // Times of day in seconds since 1970 have a rounding of 2e-7, which is what they may differ by.
    let problem = problems::lotka_volterra();
    let record = problem.noisy(2.0, 4).unwrap().remove(0);
    let fit = |start: f64| {
        let mut data = Dataset::new(&problem.states, &[]).unwrap();
        let time = record.time[..2000].iter().map(|t| t + start).collect();
        let columns = record.states.iter().map(|c| c[..2000].to_vec()).collect();
        data.push("run", time, columns, None).unwrap();
        assert!(data.report().uniform);
        Identify::new(problem.library().unwrap())
            .run(&data, &mut quiet())
            .unwrap()
    };
    let (plain, late) = (fit(0.0), fit(1.7e9));
    assert_eq!(plain.choice.method, late.choice.method);
    assert_eq!(plain.model.terms(), late.model.terms());
    for (a, b) in plain.model.equations().iter().zip(late.model.equations()) {
        for (a, b) in a.iter().zip(b) {
            assert_eq!(a.expression, b.expression);
            // Steps of 0.01 rounded to 2e-7: 2e-5 of each, which averages out.
            assert!(
                (a.coefficient / b.coefficient - 1.0).abs() < 1e-5,
                "{a:?} {b:?}"
            );
        }
    }
}
