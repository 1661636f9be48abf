//! The fields that keep the invariants of known systems, and settings that are refused.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};

use crate::identify::conserve::{Conserved, of};
use crate::identify::settings::Settings;
use crate::model::Time;
use crate::trajectory::output_error::System;
use crate::{Dataset, Library, SindyError};

/// What is looked for under invariants, on data that cover these ranges.
fn found(
    states: &[&str],
    ranges: &[[f64; 2]],
    library: &Library,
    conserve: &[&str],
) -> Result<Conserved, SindyError> {
    let mut data = Dataset::new(states, &[] as &[&str])?;
    let time: Vec<f64> = (0..50).map(f64::from).collect();
    let column = |[low, high]: &[f64; 2]| -> Vec<f64> {
        let along = time.iter().map(|t| low + (high - low) * t / 49.0);
        along.collect()
    };
    let columns = ranges.iter().map(column).collect();
    data.push("box", time.clone(), columns, None)?;
    let settings = Settings {
        conserve: conserve.iter().map(ToString::to_string).collect(),
        ..Settings::default()
    };
    let libraries = vec![library.clone(); states.len()];
    let free = System::new(Time::Continuous, data.states(), &[], &libraries)?;
    let (_, found) = of(&settings, &data, &libraries, &data.stretches(), free)?;
    Ok(found.unwrap())
}

/// Fields as text, one library for all equations.
fn written(found: &Conserved, states: &[&str], library: &Library) -> Vec<String> {
    let part = |&(k, factor): &(usize, f64)| {
        let (i, j) = (k / library.len(), k % library.len());
        format!("{}' {factor:.9} {}", states[i], library.names()[j])
    };
    let fields = found.fields.iter();
    fields
        .map(|f| f.iter().map(part).collect::<Vec<_>>().join(", "))
        .collect()
}

/// The dimension that the fields span.
fn dimension(found: &Conserved) -> usize {
    let mut columns = DMatrix::zeros(found.candidates, found.fields.len());
    for (j, field) in found.fields.iter().enumerate() {
        field.iter().for_each(|&(k, v)| columns[(k, j)] = v);
    }
    // Factors are between 1/100 and 100.
    columns.rank(1e-9)
}

#[test]
fn analytic_fields_of_a_pendulum_and_of_predators_and_prey() {
    let library = Library::specification("poly(3) + sin(x) + cos(x)", &["x", "v"]).unwrap();
    let ranges = [[-2.0, 2.1], [-1.5, 1.4]];
    let states = ["x", "v"];
    let fields = found(&states, &ranges, &library, &["v^2/2 - 9.81*cos(x)"]).unwrap();
    // Hamilton's equations, and no other combination of 24 terms.
    let text = ["x' 1.000000000 v, v' -9.810000000 sin(x)"];
    assert_eq!(written(&fields, &states, &library), text);
    let factor = fields.fields[0][1].1;
    // A few roundings.
    assert!((factor + 9.81).abs() < 1e-13, "{factor:.17}");

    // 1 = sin² + cos² is no field, and alone none at all.
    let sines = "sin(x) + sin(x)^2 + cos(x)^2 + 1";
    let library = Library::specification(&format!("v + {sines}"), &["x", "v"]).unwrap();
    let fields = found(&states, &ranges, &library, &["v^2/2 - 9.81*cos(x)"]).unwrap();
    assert_eq!(written(&fields, &states, &library), text);
    let library = Library::specification(sines, &["x", "v"]).unwrap();
    let fault = found(&states, &ranges, &library, &["v^2/2 - 9.81*cos(x)"]);
    let error = fault.map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("none but zero"), "{error}");

    let library = Library::polynomial(&["x", "y"], 2).unwrap();
    let ranges = [[0.2, 4.1], [0.1, 3.4]];
    let invariant = "0.5*x - 0.25*log(x) + 2*y - 3*log(y)";
    let fields = found(&["x", "y"], &ranges, &library, &[invariant]).unwrap();
    // x' = x (3 - 2 y), y' = y (0.5 x - 0.25), divided by 3.
    let text = "x' 1.000000000 x, x' -0.666666667 x*y, y' -0.083333333 y, y' 0.166666667 x*y";
    assert_eq!(written(&fields, &["x", "y"], &library), [text]);
}

#[test]
fn analytic_fields_of_henon_and_heiles_and_of_a_rigid_body() {
    let states = ["x", "y", "p", "q"];
    let library = Library::polynomial(&states, 2).unwrap();
    let ranges = [[-0.5, 0.4], [-0.3, 0.4], [-0.4, 0.4], [-0.35, 0.44]];
    let energy = "(p^2 + q^2 + x^2 + y^2)/2 + x^2*y - y^3/3";
    let fields = found(&states, &ranges, &library, &[energy]).unwrap();
    // J ∇E with the six constant antisymmetric J, and 1, x, y, p, q times (q, -p) less the one that is among them.
    assert_eq!(dimension(&fields), 10);
    let written = written(&fields, &states, &library);
    for hamilton in [
        "x' 1.000000000 p, p' -1.000000000 x, p' -2.000000000 x*y",
        "y' 1.000000000 q, q' -1.000000000 y, q' -1.000000000 x^2, q' 1.000000000 y^2",
    ] {
        assert!(written.iter().any(|w| w == hamilton), "{written:#?}");
    }

    let states = ["a", "b", "c"];
    let library = Library::polynomial(&states, 2).unwrap();
    let ranges = [[-0.5, 0.4], [-0.3, 0.4], [-0.4, 0.4]];
    let energy = "(a^2 + 2*b^2 + 3*c^2)/2";
    let both = [energy, "a^2 + 4*b^2 + 9*c^2"];
    let fields = found(&states, &ranges, &library, &both).unwrap();
    // Euler's equations: 1 a' = (2 - 3) b c, 2 b' = (3 - 1) a c, 3 c' = (1 - 2) a b, divided by -1.
    let text = "a' 1.000000000 b*c, b' -1.000000000 a*c, c' 0.333333333 a*b";
    assert_eq!(self::written(&fields, &states, &library), [text]);
    // The energy alone: c (2 b, -a, 0), b (3 c, 0, -a), a (0, 3 c, -2 b), of which two are independent, and products of degree 1
    // and with other variables: l (∂E/∂y, -∂E/∂x) for the constants and three linear l of three pairs, less that one.
    let fields = found(&states, &ranges, &library, &[energy]).unwrap();
    assert_eq!(dimension(&fields), 11);
    let one = "b' 1.000000000 a*c, c' -0.666666667 a*b";
    let written = self::written(&fields, &states, &library);
    assert!(written.iter().any(|w| w == one), "{written:#?}");
}

#[test]
fn analytic_the_dimension_is_that_of_factors_of_hamiltons_field() {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(2);
    for (degree, terms) in [(2, 1), (3, 3), (4, 6), (5, 10)] {
        for _ in 0..4 {
            let cubic = [
                "x", "y", "x^2", "x*y", "y^2", "x^3", "x^2*y", "x*y^2", "y^3",
            ];
            let invariant: Vec<String> = cubic
                .iter()
                .map(|t| format!("{:.3}*{t}", rng.random_range(0.2..2.0)))
                .collect();
            let library = Library::polynomial(&["x", "y"], degree).unwrap();
            let ranges = [[-0.8, 1.2], [-1.1, 0.9]];
            let fields = found(&["x", "y"], &ranges, &library, &[&invariant.join(" + ")]).unwrap();
            // g (∂E/∂y, -∂E/∂x) for the polynomials g of the degree that is left: no others, as the derivatives of a cubic
            // drawn at random have no common factor.
            assert_eq!(dimension(&fields), terms, "{degree}");
            let a: Vec<f64> = fields
                .fields
                .iter()
                .map(|_| rng.random_range(-1.0..1.0))
                .collect();
            let shares = fields.shares(&fields.terms(&a));
            // Rounding of sums of up to a hundred terms.
            assert!(shares[0] < 1e-13, "{shares:?}");
        }
    }
}

#[test]
fn prop_states_of_which_the_invariant_does_not_depend_are_free() {
    let library = Library::polynomial(&["x", "y"], 1).unwrap();
    let ranges = [[-1.0, 1.0], [0.5, 0.5]];
    let fields = found(&["x", "y"], &ranges, &library, &["x^2"]).unwrap();
    let written = written(&fields, &["x", "y"], &library);
    // y does not move in these data; that does not make it a constant of the library.
    let all = ["y' 1.000000000 1", "y' 1.000000000 x", "y' 1.000000000 y"];
    assert_eq!(written, all);
}

#[test]
fn prop_invariants_that_make_no_sense_are_refused() {
    let library = Library::polynomial(&["x", "v"], 2).unwrap();
    let refused = |invariant: &str| {
        let ranges = [[-2.0, 2.1], [-1.5, 1.4]];
        let fault = found(&["x", "v"], &ranges, &library, &["v^2 + x^2", invariant]);
        fault.map(|_| ()).unwrap_err().to_string()
    };
    for (invariant, says) in [
        ("v^2/2 -", "expected an expression ("),
        ("v^2/2 = 1", "expected an expression ("),
        ("", "expected an expression ("),
        (
            "v^2 + w",
            "an expression of the states x, v, found `w` in `v^2 + w`",
        ),
        ("3", "an expression that depends on a state, found `3`"),
        (
            "x - x",
            "an expression that depends on a state, found `x - x`",
        ),
        ("log(v - 2)", "finite in the range of the data"),
        ("x", "found none but zero"),
    ] {
        let error = refused(invariant);
        assert!(
            error.starts_with("setting `conserve`: expected") && error.contains(says),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let ranges = [[-2.0, 2.1], [-1.5, 1.4]];
    let fault = found(&["x", "v"], &ranges, &library, &["v^2/2 - cos(x)"]);
    let error = fault.map(|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("Terms of `v` in x' and `sin(x)` in v'"),
        "{error}"
    );
    // sin x differs from x by 1e-11 of it.
    let near = Library::parse(&["x", "v", "sin(x)"]).unwrap();
    let small = [[-1e-5, 1e-5], [-1.5, 1.4]];
    let fault = found(&["x", "v"], &small, &near, &["v^2 + x^2"]);
    let error = fault.map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("depend on each other"), "{error}");
    let large = Library::polynomial(&["x", "v"], 20).unwrap();
    let fault = found(&["x", "v"], &ranges, &large, &["v"]);
    let error = fault.map(|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("at most 400") && error.contains("found 462"),
        "{error}"
    );
}

#[test]
fn prop_settings_that_do_not_go_with_invariants_are_refused() {
    let conserve = vec!["x^2 + v^2".to_owned()];
    let base = Settings {
        conserve,
        ..Settings::default()
    };
    assert!(base.validate().is_ok());
    let texts = |text: &str| vec![text.to_owned()];
    for (settings, says) in [
        (
            Settings {
                discrete: true,
                ..base.clone()
            },
            "none in discrete time",
        ),
        (
            Settings {
                known: texts("x' = v"),
                ..base.clone()
            },
            "none beside `known`",
        ),
        (
            Settings {
                signs: texts("x': v > 0"),
                ..base.clone()
            },
            "none beside `signs`",
        ),
        (
            Settings {
                second_order: texts("x"),
                ..base.clone()
            },
            "none beside `second_order`",
        ),
    ] {
        let error = settings.validate().unwrap_err().to_string();
        assert!(
            error.contains("`conserve`") && error.contains(says) && error.contains("x^2 + v^2"),
            "{error}"
        );
    }
}

#[test]
fn regress_fields_have_finite_factors_for_many_invariants() {
    let library = Library::specification("poly(3) + fourier(1)", &["x", "v"]).unwrap();
    // The range of a noisy pendulum; with it a factor by which the field was divided was zero.
    for ranges in [
        [[-1.28, 1.29], [-1.19, 1.21]],
        [[-1.0, 1.0], [-1.0, 1.0]],
        [[0.0, 2.0], [-1.0, 3.0]],
    ] {
        for invariant in [
            "v^2/2 - x",
            "v",
            "x*v",
            "exp(v)",
            "v^2/2 - 2*cos(x)",
            "x^2/2 + v^2/2",
        ] {
            let fields = found(&["x", "v"], &ranges, &library, &[invariant])
                .unwrap()
                .fields;
            assert!(!fields.is_empty(), "{invariant}");
            let factors = fields.iter().flatten().map(|(_, factor)| *factor);
            assert!(
                factors.into_iter().all(|f| f.is_finite() && f != 0.0),
                "{invariant}"
            );
        }
    }
}
