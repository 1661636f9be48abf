//! Coefficients of all rows, for terms that were chosen on a part of them.

use super::*;

/// An oscillator with noise of 0.02, by its exact solution; from row 3000 on with another stiffness.
fn oscillator(stiffness: [f64; 2]) -> Dataset {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
    let mut normal =
        || -> f64 { rand_distr::Distribution::sample(&rand_distr::StandardNormal, &mut rng) };
    let mut columns = vec![Vec::new(), Vec::new()];
    let (mut x, mut v) = (1.0_f64, 0.0_f64);
    for row in 0..6000 {
        columns[0].push(x + 0.02 * normal());
        columns[1].push(v + 0.02 * normal());
        let omega = stiffness[row / 3000].sqrt();
        let (sin, cos) = (0.05 * omega).sin_cos();
        (x, v) = (x * cos + v / omega * sin, v * cos - x * omega * sin);
    }
    let time = (0..6000).map(|k| 0.05 * f64::from(k)).collect();
    let mut data = Dataset::new(&["x", "v"], &[]).unwrap();
    data.push("run", time, columns, None).unwrap();
    data
}

fn fit(library: Library, data: &Dataset, rows: usize, constraints: &[&str]) -> Identification {
    let settings = Settings {
        rows,
        constraints: constraints.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    };
    let identify = Identify::new(library).settings(settings).unwrap();
    identify.run(data, &mut quiet()).unwrap()
}

#[test]
fn analytic_terms_chosen_on_a_part_have_coefficients_of_all_rows() {
    refined(&[]);
}

#[test]
fn analytic_terms_under_a_relation_have_coefficients_of_all_rows() {
    refined(&["[y': y] = -[y': x^2*y]"]);
}

fn refined(constraints: &[&str]) {
    let mut problem = problems::van_der_pol();
    problem.rows = 6000;
    let data = data_of(&problem, 2.0, 5);
    let part = fit(problem.library().unwrap(), &data, 1000, constraints);
    let whole = fit(problem.library().unwrap(), &data, 50_000, constraints);
    assert!(
        part.choice.reason.contains("on the 1000 rows"),
        "{}",
        part.choice.reason
    );
    assert!(
        !whole.choice.reason.contains("rows on which"),
        "{}",
        whole.choice.reason
    );
    let (error, exact) = against_truth(&problem, &part.model);
    // Four standard errors of the largest of the terms.
    assert!(exact && error < 2e-3, "{error}");
    for (a, b) in part.equations.iter().zip(&whole.equations) {
        assert_eq!(a.intervals.len(), b.intervals.len());
        for (a, b) in a.intervals.iter().zip(&b.intervals) {
            let ([a, c], [b, d]) = (a.unwrap(), b.unwrap());
            // Parts of 2000 rows lose a little at their ends; a sixth of the rows alone would give 2.4 times the width.
            let ratio = (c - a) / (d - b);
            assert!((0.8..1.25).contains(&ratio), "{ratio}");
            // The same noise: half of an interval apart at most.
            assert!(
                (a + c - b - d).abs() / 2.0 < 0.25 * (d - b),
                "{a} to {c}, {b} to {d}"
            );
        }
    }
}

#[test]
fn prop_coefficients_that_change_beyond_the_rows_of_the_choice_are_said_to() {
    let library = Library::polynomial(&["x", "v"], 2).unwrap();
    // The first sixth of the rows is looked at, on which both are one system.
    for (stiffness, changes) in [([4.0, 4.0], false), ([4.0, 4.02], true), ([4.0, 4.4], true)] {
        let found = fit(library.clone(), &oscillator(stiffness), 1000, &[]);
        let said = found.warnings.iter().any(|w| w.contains("all rows"));
        assert_eq!(said, changes, "{:?}", found.warnings);
    }
}
