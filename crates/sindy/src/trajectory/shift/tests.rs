//! Known answers: recursions found again from their samples, rows counted by hand.

use super::*;
use crate::library::Library;
use crate::model::{Limits, Model, Time};
use crate::{Gram, Solver, Stlsq};
use proptest::prelude::*;

fn samples(names: &[&str], groups: &[Vec<Vec<f64>>]) -> Samples {
    let mut samples = Samples::new(names);
    for group in groups {
        samples.push_group(group.clone()).unwrap();
    }
    samples
}

fn ramp(rows: usize, period: f64) -> Vec<f64> {
    (0..rows).map(|k| period * k as f64).collect()
}

fn delays(text: &str) -> Vec<Delay> {
    Delay::parse(text).unwrap()
}

/// Coefficients of a sparse fit of `target`.
fn fit(library: &Library, target: &str, samples: &Samples) -> Vec<f64> {
    let gram = Gram::total(&Gram::accumulate(library, target, samples).unwrap());
    let solver = Stlsq::new(0.05, 0.0).unwrap();
    solver.fit(&gram).unwrap().coefficients.as_slice().to_vec()
}

#[test]
fn analytic_rows_before_and_after() {
    let x = vec![10.0, 11.0, 12.0, 13.0, 14.0];
    let two = samples(&["x"], &[vec![x], vec![vec![20.0, 21.0]]]);
    let found = past(&two, &delays("x@1..2"), None).unwrap();
    assert_eq!(found.added, ["x_ago1", "x_ago2"]);
    assert_eq!(found.samples.groups(), 1);
    let columns = [[12.0, 13.0, 14.0], [11.0, 12.0, 13.0], [10.0, 11.0, 12.0]];
    assert_eq!(found.samples.group(0), columns);
    // Two rows of the first group, both of the second.
    assert_eq!((found.dropped, found.gaps, found.origin), (4, 0, vec![0]));

    let found = next(&two, &["x"], None, None).unwrap();
    assert_eq!((found.dropped, found.origin), (2, vec![0, 1]));
    assert_eq!(found.samples.group(1), [[20.0], [21.0]]);
    assert_eq!(found.samples.group(0)[1], [11.0, 12.0, 13.0, 14.0]);
}

#[test]
fn analytic_gaps_are_never_bridged() {
    let nan = f64::NAN;
    let time = vec![0.0, 0.1, 0.2, 0.7, 0.8, 0.9, nan, 1.1, 1.2];
    let x = ramp(9, 1.0);
    let gappy = samples(&["t", "x"], &[vec![time, x]]);
    let found = next(&gappy, &["x"], Some("t"), None).unwrap();
    assert_eq!((found.gaps, found.origin), (1, vec![0, 0, 0]));
    let pairs = |g: usize| [1, 2].map(|c| found.samples.group(g)[c].clone());
    assert_eq!(pairs(0), [vec![0.0, 1.0], vec![1.0, 2.0]]);
    assert_eq!(pairs(1), [vec![3.0, 4.0], vec![4.0, 5.0]]);
    assert_eq!(pairs(2), [vec![7.0], vec![8.0]]);
    // The last row of each stretch, and the row without a time.
    assert_eq!(found.dropped, 4);
    assert!((found.period.unwrap() - 0.1).abs() < 1e-12);

    let found = past(&gappy, &delays("x@0.2s"), Some("t")).unwrap();
    assert_eq!(found.added, ["x_ago2"]);
    let rows = |g: usize| found.samples.group(g)[2].clone();
    assert_eq!((rows(0), rows(1)), (vec![0.0], vec![3.0]));
    assert_eq!(found.dropped, 7);
}

#[test]
fn prop_times_without_one_period_are_refused() {
    let with = |time: Vec<f64>| samples(&["t", "x"], &[vec![time.clone(), time]]);
    let refused = |time: Vec<f64>, words: &str| {
        let samples = with(time);
        let first = past(&samples, &delays("x@1"), Some("t")).unwrap_err();
        let second = next(&samples, &["x"], Some("t"), None).unwrap_err();
        for error in [first, second] {
            assert!(error.to_string().contains(words), "{error}");
        }
    };
    refused(
        vec![0.0, 0.1, 0.2, 0.32, 0.42],
        "before sample 3 of trajectory 1",
    );
    refused(vec![0.0, 0.1, 0.1], "does not increase at sample 2");
    refused(vec![0.0, f64::INFINITY], "not a finite");
    refused(vec![0.0], "too few");
    refused(vec![], "too few");
    // A tenth of the tolerance is no reason.
    assert!(next(&with(vec![0.0, 0.1, 0.20001, 0.3]), &["x"], Some("t"), None).is_ok());
    // A period that is not that of the data, and a group of another one.
    let error = next(&with(ramp(5, 0.1)), &["x"], Some("t"), Some(0.05)).unwrap_err();
    assert!(
        error.to_string().contains("a step of 0.1 before sample 1"),
        "{error}"
    );
    let group = |period: f64| vec![ramp(5, period), ramp(5, 1.0)];
    let mixed = samples(&["t", "x"], &[group(0.1), group(0.1), group(0.2)]);
    let error = next(&mixed, &["x"], Some("t"), None).unwrap_err();
    assert!(error.to_string().contains("trajectory 3"), "{error}");
    // A delay in time that is no whole number of periods, or has none to be compared with.
    let error = past(&with(ramp(5, 0.1)), &delays("x@0.25s"), Some("t")).unwrap_err();
    assert!(error.to_string().contains("2.500 of them"), "{error}");
    assert!(past(&with(ramp(5, 0.1)), &delays("x@0.2s"), None).is_err());
}

#[test]
fn prop_bad_input_is_refused() {
    for text in [
        "x",
        "@3",
        "x@0",
        "x@-1",
        "x@1.5",
        "x@3..1",
        "x@0s",
        "x@infs",
        "x@",
        "x@9999999999",
    ] {
        assert!(Delay::parse(text).is_err(), "{text}");
    }
    let one = samples(&["x", "x_ago1", "x_next"], &[vec![vec![1.0; 4]; 3]]);
    assert!(past(&one, &[], None).is_err());
    assert!(past(&one, &delays("w@1"), None).is_err());
    assert!(
        past(&one, &delays("x@1"), None).is_err(),
        "the name is taken"
    );
    assert!(next(&one, &["x"], None, None).is_err(), "the name is taken");
    assert!(next(&one, &[], None, None).is_err());
    assert!(next(&one, &["x_ago1"; 2], None, None).is_err());
    assert!(next(&one, &["x_ago1"], None, Some(-1.0)).is_err());
    assert!(next(&one, &["x_ago1"], Some("t"), None).is_err());
    let short = past(&one, &delays("x@4"), None).unwrap_err();
    assert_eq!(
        short,
        SindyError::TooShort {
            needed: 5,
            found: 4
        }
    );
    assert!(next(&Samples::new(&["x"]), &["x"], None, None).is_err());
    assert!(chain(&delays("x@0.1s")).is_err());
    let read: Result<Delay, _> = serde_json::from_str("\"x@1..2\"");
    assert!(read.is_err());
}

#[test]
fn analytic_delayed_logistic_map() {
    // x[k+1] = r x[k] (1 - x[k-1]): aperiodic at r = 2.27, found exactly from its samples.
    let r = 2.27;
    let mut x = vec![0.3, 0.35];
    for k in 1..300 {
        x.push(r * x[k] * (1.0 - x[k - 1]));
    }
    let one = samples(&["x"], &[vec![x]]);
    let with_past = past(&one, &delays("x@1"), None).unwrap();
    let pairs = next(&with_past.samples, &["x"], None, None).unwrap();
    let library = Library::specification("poly(3)", &["x", "x_ago1"]).unwrap();
    let found = fit(&library, "x_next", &pairs.samples);
    for (name, c) in library.names().iter().zip(found) {
        let truth = match name.as_str() {
            "x" => r,
            "x*x_ago1" => -r,
            _ => 0.0,
        };
        // 300 exact samples; rounding times the library's condition (squared in the Gram) of some 1e3.
        assert!((c - truth).abs() < 1e-9, "{name}: {c}");
    }
}

#[test]
fn analytic_driven_recursion_found_and_run_again() {
    // x[k+1] = 1.2 x[k] - 0.5 x[k-1] + 0.3 u[k-2], and the run of the model found is the data.
    let u: Vec<f64> = (0..200)
        .map(|k| (0.9 * f64::from(k)).sin() + (0.23 * f64::from(k)).cos())
        .collect();
    let mut x = vec![1.0, 0.4, -0.2];
    for k in 2..199 {
        x.push(1.2 * x[k] - 0.5 * x[k - 1] + 0.3 * u[k - 2]);
    }
    let time = ramp(200, 0.01);
    let data = samples(&["t", "x", "u"], &[vec![time, x.clone(), u.clone()]]);
    let delays = [delays("x@1"), delays("u@1..2")].concat();
    let with_past = past(&data, &delays, Some("t")).unwrap();
    let pairs = next(&with_past.samples, &["x"], Some("t"), Some(0.01)).unwrap();
    assert_eq!((with_past.dropped, pairs.dropped, pairs.gaps), (2, 1, 0));
    let columns = ["x", "u", "x_ago1", "u_ago1", "u_ago2"];
    let library = Library::specification("poly(1)", &columns).unwrap();
    let found = fit(&library, "x_next", &pairs.samples);
    let truth = [0.0, 1.2, 0.0, -0.5, 0.0, 0.3];
    for (c, truth) in found.iter().zip(truth) {
        // Exact samples of order one; rounding times the condition of some 1e2, squared.
        assert!((c - truth).abs() < 1e-10, "{c} {truth}");
    }

    let (older, shifts) = chain(&delays).unwrap();
    assert_eq!(older, ["x_ago1", "u_ago1", "u_ago2"]);
    let states = [vec!["x".to_string()], older].concat();
    let equations = [vec![Term::of_library(&library, &found).unwrap()], shifts].concat();
    let period = pairs.period.unwrap();
    let model = Model::new(
        Time::Discrete { period },
        &states,
        &["u".to_string()],
        equations,
    )
    .unwrap();
    let start = [x[2], x[1], u[1], u[0]];
    let run = model
        .iterate(&start, 197, &[&u[2..]], &Limits::default())
        .unwrap();
    for (found, x) in run.states[0].iter().zip(&x[2..]) {
        // The recursion is stable (poles of modulus 0.7): errors of 1e-10 in coefficients do not grow.
        assert!((found - x).abs() < 1e-8, "{found} {x}");
    }
}

proptest! {
    #[test]
    fn prop_every_row_is_kept_or_counted(
        lengths in prop::collection::vec(0..12_usize, 1..5),
        holes in prop::collection::vec(any::<bool>(), 12),
        by in 1..4_usize,
    ) {
        let groups: Vec<Vec<Vec<f64>>> = lengths
            .iter()
            .map(|&n| {
                let time: Vec<f64> = holes[..n].iter().scan(0.0, |t, &hole| {
                    *t += if hole { 4.0 } else { 1.0 };
                    Some(*t)
                }).collect();
                vec![time.clone(), time]
            })
            .collect();
        let data = samples(&["t", "x"], &groups);
        if let Ok(found) = past(&data, &delays(&format!("x@{by}")), Some("t")) {
            prop_assert_eq!(found.samples.rows() + found.dropped, data.rows());
            for g in 0..found.samples.groups() {
                let [time, _, ago] = found.samples.group(g) else { panic!("three columns") };
                for (t, ago) in time.iter().zip(ago) {
                    // Times here are whole numbers and x is the time.
                    prop_assert_eq!(t - ago, by as f64 * found.period.unwrap());
                }
            }
        }
    }
}
