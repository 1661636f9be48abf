//! Terms that no library has.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::quiet;
use crate::identify::{Identification, Identify, Settings};
use crate::{Dataset, Library};

/// Rows of `x' = v`, `v' = acceleration(t, x, v)` with noise, by the rule of the midpoint in twentieths of a row.
fn record(acceleration: &dyn Fn(f64, f64, f64) -> f64, noise: f64, seed: u64) -> Dataset {
    const PERIOD: f64 = 0.08;
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut data = Dataset::new(&["x", "v"], &[]).unwrap();
    let (mut t, mut x, mut v) = (0.0, 2.0, 0.0);
    let mut columns = vec![Vec::new(), Vec::new()];
    for _ in 0..500 {
        columns[0].push(x + noise * normal());
        columns[1].push(v + noise * normal());
        let h = PERIOD / 20.0;
        for _ in 0..20 {
            let a = acceleration(t, x, v);
            let (mid, speed) = (x + 0.5 * h * v, v + 0.5 * h * a);
            (x, v) = (x + h * speed, v + h * acceleration(t + 0.5 * h, mid, speed));
            t += h;
        }
    }
    let time = (0..500).map(|k| PERIOD * f64::from(k)).collect();
    data.push("run", time, columns, None).unwrap();
    data
}

fn fit(data: &Dataset, more: &[&str], known: &[&str]) -> Identification {
    let cubic = Library::polynomial(&["x", "v"], 3).unwrap();
    let mut names = cubic.names().to_vec();
    names.extend(more.iter().map(ToString::to_string));
    let settings = Settings {
        known: known.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    };
    let identify = Identify::new(Library::parse(&names).unwrap()).settings(settings);
    identify.unwrap().run(data, &mut quiet()).unwrap()
}

/// The warnings of the test, which name a term.
fn named(found: &Identification) -> Vec<&String> {
    let all = found.warnings.iter();
    all.filter(|w| w.contains("would explain")).collect()
}

#[test]
fn analytic_a_kink_is_missed_by_name_and_not_where_the_library_has_it() {
    let friction = |_: f64, x: f64, v: f64| -3.0 * x - 0.08 * v - 0.12 * (25.0 * v).tanh();
    let data = record(&friction, 0.01, 1);
    let found = fit(&data, &[], &[]);
    // Without it a cubic imitates the friction, and the residual is accepted as a disturbance.
    let [warning] = named(&found)[..] else {
        panic!("{:?}", found.warnings);
    };
    assert!(
        warning.starts_with("equation of v: tanh("),
        "{warning}: {}",
        found.model
    );
    let found = fit(&data, &["tanh(25*v)"], &[]);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    assert_eq!(found.model.equations()[1].len(), 3, "{}", found.model);
}

#[test]
fn prop_no_term_that_imitates_a_missing_one_is_more_likely_absent_than_not() {
    let quintic = |_: f64, x: f64, v: f64| -x - 0.1 * v - 0.3 * x.powi(5);
    let slack = |_: f64, x: f64, v: f64| -2.0 * x - 0.1 * v - 0.5 * x.abs();
    let drag = |_: f64, x: f64, v: f64| -1.5 * x - 0.25 * v * v.abs();
    let systems: [&dyn Fn(f64, f64, f64) -> f64; 3] = [&quintic, &slack, &drag];
    for (system, seed) in systems.into_iter().flat_map(|s| [(s, 1), (s, 2)]) {
        let found = fit(&record(system, 0.003, seed), &[], &[]);
        let says = |text: &str| found.warnings.iter().any(|w| w.contains(text));
        assert!(says("not in the library"), "{:?}", found.warnings);
        assert!(!says("absent than not"), "{:?}", found.warnings);
        let terms = found.model.equations().iter().flatten();
        let least = terms.filter_map(|t| t.inclusion).fold(1.0, f64::min);
        // Other terms that are as likely take their share, of which a warning tells.
        let shared = says("about as likely");
        assert!(least > if shared { 0.05 } else { 0.5 }, "{}", found.model);
    }
}

#[test]
fn analytic_a_slow_drive_that_is_not_in_the_data_is_missed() {
    let driven = |t: f64, x: f64, v: f64| x - x.powi(3) - 0.3 * v + 0.05 * (0.4 * t).cos();
    let found = fit(&record(&driven, 0.01, 2), &[], &[]);
    let [warning] = named(&found)[..] else {
        panic!("{:?}", found.warnings);
    };
    assert!(warning.contains("*t)"), "{warning}");
}

#[test]
fn analytic_the_lag_of_an_actuator_is_missed() {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut data = Dataset::new(&["x", "v"], &["u"]).unwrap();
    let (mut x, mut v, mut force, mut u) = (0.0, 0.0, 0.0, 0.0);
    let mut columns = vec![Vec::new(), Vec::new(), Vec::new()];
    for k in 0..500 {
        if k % 15 == 0 {
            u = rng.random_range(-1.0..1.0);
        }
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        columns[0].push(x + 0.02 * normal());
        columns[1].push(v + 0.02 * normal());
        columns[2].push(u);
        let h: f64 = 0.1 / 50.0;
        for _ in 0..50 {
            let (a, slope) = (force - 0.5 * v - x, 3.0 * (u - force));
            (x, v, force) = (x + h * v, v + h * a, force + h * slope);
        }
    }
    let time = (0..500).map(|k| 0.1 * f64::from(k)).collect();
    data.push("run", time, columns, None).unwrap();
    let identify = Identify::new(Library::polynomial(&["x", "v", "u"], 2).unwrap());
    let found = identify.run(&data, &mut quiet()).unwrap();
    let [warning] = named(&found)[..] else {
        panic!("{:?}", found.warnings);
    };
    assert!(
        warning.contains("equation of v: \"u after a lag of "),
        "{warning}"
    );
}

#[test]
fn analytic_a_known_part_with_a_wrong_coefficient_is_contradicted() {
    let spring = |_: f64, x: f64, v: f64| -2.0 * x - 0.1 * v - 0.3 * x.powi(3);
    let data = record(&spring, 0.01, 3);
    let found = fit(&data, &[], &["v' = -2.2*x + ..."]);
    let [warning] = named(&found)[..] else {
        panic!("{:?}", found.warnings);
    };
    assert!(
        warning.contains("equation of v: with another coefficient the known term x "),
        "{warning}"
    );
    let found = fit(&data, &[], &["v' = -2*x + ..."]);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
}

#[test]
fn prop_true_models_are_rarely_doubted() {
    let spring = |_: f64, x: f64, v: f64| -2.0 * x - 0.1 * v - 0.3 * x.powi(3);
    let doubted = (0..20)
        .filter(|&seed| !named(&fit(&record(&spring, 0.03, 100 + seed), &[], &[])).is_empty())
        .count();
    // At a level of one in a thousand, two of twenty are doubted in 2 of 10 000 tests.
    assert!(doubted < 2, "{doubted}");
}

#[test]
fn analytic_a_map_that_is_no_polynomial_is_missed() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut data = Dataset::new(&["x"], &[]).unwrap();
    let mut x: f64 = 0.4;
    let step = |_| {
        let noise: f64 = StandardNormal.sample(&mut rng);
        let row = x + 0.005 * noise;
        x = 0.93 * (std::f64::consts::PI * x).sin();
        row
    };
    let rows: Vec<f64> = (0..300).map(step).collect();
    let time = (0..300).map(f64::from).collect();
    data.push("run", time, vec![rows], None).unwrap();
    let names = ["1", "x", "x^2", "x^3"];
    let with_sine = ["1", "x", "x^2", "x^3", "sin(3.141592653589793*x)"];
    for (names, lacks) in [(&names[..], true), (&with_sine[..], false)] {
        let settings = Settings {
            discrete: true,
            ..Settings::default()
        };
        let identify = Identify::new(Library::parse(names).unwrap());
        let identify = identify.settings(settings).unwrap();
        let found = identify.run(&data, &mut quiet()).unwrap();
        assert_eq!(!named(&found).is_empty(), lacks, "{:?}", found.warnings);
    }
}
