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

/// The data with rows at random that hold no states, and inputs only if `driven`; and without these rows.
fn with_lost_rows(of: &Dataset, share: f64, driven: bool) -> [Dataset; 2] {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(6);
    let empty = || Dataset::new(of.states(), of.inputs()).unwrap();
    let mut out = [empty(), empty()];
    for t in of.trajectories() {
        let lost: Vec<bool> = t.time.iter().map(|_| rng.random_bool(share)).collect();
        let kept: Vec<usize> = (0..lost.len()).filter(|&row| !lost[row]).collect();
        let pick = |c: &Vec<f64>| -> Vec<f64> { kept.iter().map(|&row| c[row]).collect() };
        let left = t.columns.iter().map(pick).collect();
        out[1].push("run", pick(&t.time), left, None).unwrap();
        let mut columns = t.columns.clone();
        let measured = if driven {
            of.states().len()
        } else {
            columns.len()
        };
        for column in &mut columns[..measured] {
            for (v, lost) in column.iter_mut().zip(&lost) {
                *v = if *lost { f64::NAN } else { *v };
            }
        }
        out[0].push("run", t.time.clone(), columns, None).unwrap();
    }
    out
}

#[test]
fn analytic_rows_without_values_cost_what_rows_cost_that_are_not_there() {
    let known = ["outliers", "gaps", "not white", "heavy tails", "correlated"];
    for (problem, share, driven) in [
        (problems::van_der_pol(), 0.3, false),
        (problems::van_der_pol(), 0.5, false),
        (problems::duffing(), 0.03, false),
        (problems::duffing(), 0.5, false),
        (problems::duffing(), 0.4, true),
    ] {
        let all = data_of(&problem, 2.0, 11);
        let [lost, left] = with_lost_rows(&all, share, driven);
        let library = problem.library().unwrap();
        let run = |data| {
            let identify = Identify::new(library.clone());
            identify.run(data, &mut quiet()).unwrap()
        };
        let (with, without) = (run(&lost), run(&left));
        let said = with.warnings.join("; ");
        let name = format!("{}, {share}: {said}", problem.name);
        let false_ones = known.iter().filter(|w| said.contains(**w)).count();
        assert_eq!(false_ones, 0, "{name}");
        if driven {
            // The same rows are compared. Only starts, and inputs between rows, are others.
            let [a, b] = [&with, &without].map(|f| against_truth(&problem, &f.model));
            assert!(a.1 && a.0 < 1.5 * b.0, "{name}: {a:?} {b:?}");
        } else {
            let equations = |of: &Identification| of.model.equations().to_vec();
            assert_eq!(equations(&with), equations(&without), "{name}");
            assert_eq!(with.data.rows, all.report().rows, "{name}");
        }
    }
}

#[test]
fn prop_a_map_that_ends_on_a_curve_has_terms_with_probabilities() {
    // On the curve all ten terms depend on each other nearly. Probabilities that are none would be an error of the model.
    for seed in 0..12 {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let (mut x, mut y, mut drift) = (0.4_f64, 0.4_f64, [0.0; 2]);
        let mut columns = vec![Vec::new(); 2];
        for _ in 0..300 {
            for (column, (value, drift)) in
                columns.iter_mut().zip([x, y].into_iter().zip(&mut drift))
            {
                *drift += 1e-3 * rng.random_range(-1.0..1.0);
                column.push(value + *drift);
            }
            (x, y) = (x * (2.2 * (1.0 - x - 0.4 * y)).exp(), 0.6 * y + 0.3 * x);
        }
        let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
        data.push("map", (0..300).map(f64::from).collect(), columns, None)
            .unwrap();
        let settings = Settings {
            discrete: true,
            ..Settings::default()
        };
        let library = Library::polynomial(&["x", "y"], 3).unwrap();
        let identify = Identify::new(library).settings(settings).unwrap();
        let found = identify.run(&data, &mut quiet()).unwrap();
        let terms = found.model.equations().iter().flatten();
        let inclusions = terms.filter_map(|t| t.inclusion);
        assert!(
            inclusions.clone().count() > 0 && inclusions.clone().all(|p| (0.0..=1.0).contains(&p))
        );
    }
}
