//! Models as wholes; each file tests one part.

mod equilibria;
mod export;
mod input;
mod json;
mod simulate;

use proptest::prelude::*;

use super::{Model, Term, Time};
use crate::data::samples::Samples;
use crate::error::SindyError;
use crate::library::Library;

/// A continuous-time model from texts: for each state, terms and coefficients.
fn model(states: &[&str], inputs: &[&str], equations: &[&[(&str, f64)]]) -> Model {
    let equations = equations
        .iter()
        .map(|e| e.iter().map(|(t, c)| Term::parse(t, *c).unwrap()).collect())
        .collect();
    Model::new(Time::Continuous, states, inputs, equations).unwrap()
}

fn one(text: &str, c: f64) -> Vec<Vec<Term>> {
    vec![vec![Term::parse(text, c).unwrap()]]
}

/// Any model, odd names and extreme coefficients included.
fn any_model() -> impl Strategy<Value = Model> {
    const NAMES: [&str; 6] = ["x", "sin", "ESC \"signal\" (µs)", "motor.m1", "σ_0", "e"];
    const SHAPES: [&str; 7] = [
        "1",
        "a",
        "a^3*b",
        "exp(-a)*b",
        "if(a < b, a, 2*b)",
        "a/(1 + b^2)",
        "-a",
    ];
    let term = || {
        let certainty = (
            prop::option::of(0.0..1e300_f64),
            prop::option::of(0.0..=1.0_f64),
        );
        (
            0..SHAPES.len(),
            0..6_usize,
            0..6_usize,
            prop::num::f64::ANY,
            certainty,
        )
    };
    let equation = prop::collection::vec(term(), 0..6);
    let period = prop::option::of(1e-9..1e9_f64);
    (1..4_usize, prop::collection::vec(equation, 3), period).prop_map(|(n, equations, period)| {
        let equations = equations[..n].iter().map(|terms| {
            let mut built: Vec<Term> = Vec::new();
            for (shape, a, b, c, (std_error, inclusion)) in terms {
                let shape = sindy_expr::Expr::parse(SHAPES[*shape]).unwrap();
                let named = |name: &str| sindy_expr::Expr::variable(name);
                // In two steps, so that a name put in is not replaced again.
                let expression = shape
                    .substitute("a", &named("first"))
                    .substitute("b", &named("second"))
                    .substitute("first", &named(NAMES[*a]))
                    .substitute("second", &named(NAMES[*b]));
                if built.iter().all(|t| t.expression != expression) {
                    let coefficient = if c.is_finite() { *c } else { -0.0 };
                    let (std_error, inclusion) = (*std_error, *inclusion);
                    built.push(Term {
                        expression,
                        coefficient,
                        std_error,
                        inclusion,
                    });
                }
            }
            built
        });
        let time = period.map_or(Time::Continuous, |period| Time::Discrete { period });
        Model::new(time, &NAMES[..n], &NAMES[n..], equations.collect()).unwrap()
    })
}

#[test]
fn analytic_prediction_with_a_library_per_equation() {
    let first = Library::parse(&["1", "x", "x*u"]).unwrap();
    let second = Library::parse(&["y^2", "u"]).unwrap();
    let model = Model::new(
        Time::Continuous,
        &["x", "y"],
        &["u"],
        vec![
            Term::of_library(&first, &[0.5, 0.0, -2.0]).unwrap(),
            Term::of_library(&second, &[3.0, 1.0]).unwrap(),
        ],
    )
    .unwrap();
    assert_eq!(model.terms(), 4);
    let out = model
        .predict(&[&[1.0, 2.0], &[0.5, -1.0], &[4.0, 0.25]])
        .unwrap();
    // Small binary fractions: exact.
    assert_eq!(out, [[0.5 - 8.0, 0.5 - 1.0], [0.75 + 4.0, 3.0 + 0.25]]);
    assert_eq!(model.expression(0).to_string(), "0.5*1 + -2*(x*u)");
}

#[test]
fn analytic_prediction_over_a_source_finds_columns_by_name() {
    let model = model(&["x"], &["u"], &[&[("x", 2.0), ("u", 1.0)]]);
    let mut samples = Samples::new(&["u", "time", "x"]);
    samples
        .push_group(vec![vec![1.0], vec![0.0], vec![10.0]])
        .unwrap();
    samples
        .push_group(vec![vec![3.0], vec![0.0], vec![20.0]])
        .unwrap();
    let mut seen = Vec::new();
    model
        .predict_source(&samples, &mut |block, out| {
            seen.push((block.group, out[0][0]));
        })
        .unwrap();
    assert_eq!(seen, [(0, 21.0), (1, 43.0)]);
    let without = Samples::new(&["x"]);
    let error = model.predict_source(&without, &mut |_, _| {}).unwrap_err();
    assert_eq!(error.to_string(), "no column named `u`; the columns are: x");
}

#[test]
fn bad_input_is_refused_with_the_offending_value() {
    let c = Time::Continuous;
    let text = |r: Result<Model, SindyError>| r.unwrap_err().to_string();
    let none: [&str; 0] = [];
    assert!(text(Model::new(c, &none, &[], vec![])).contains("at least one name"));
    assert!(text(Model::new(c, &["x", "x"], &[], vec![vec![], vec![]])).contains("`x` twice"));
    assert!(text(Model::new(c, &["x"], &["x"], vec![vec![]])).contains("`x` twice"));
    assert!(text(Model::new(c, &[""], &[], vec![vec![]])).contains("an empty name"));
    assert!(text(Model::new(c, &["x"], &[], vec![])).contains("expected 1, found 0"));
    assert!(text(Model::new(c, &["x"], &[], one("y", 1.0))).contains("unknown name `y`"));
    assert!(text(Model::new(c, &["x"], &[], one("x", f64::NAN))).contains("NaN for the term `x`"));
    let bad_error = vec![vec![Term::parse("x", 1.0).unwrap().with_std_error(-1.0)]];
    assert!(text(Model::new(c, &["x"], &[], bad_error)).contains("`std_error`"));
    let bad_inclusion = vec![vec![Term::parse("x", 1.0).unwrap().with_inclusion(1.5)]];
    assert!(text(Model::new(c, &["x"], &[], bad_inclusion)).contains("found 1.5"));
    let twice = vec![vec![
        Term::parse("x", 1.0).unwrap(),
        Term::parse("x", 2.0).unwrap(),
    ]];
    assert!(text(Model::new(c, &["x"], &[], twice)).contains("`x` occurs twice"));
    let still = Time::Discrete { period: 0.0 };
    assert!(text(Model::new(still, &["x"], &[], vec![vec![]])).contains("`period`"));
    // Sixty doublings of an expression that shares its parts: its text would not fit in memory.
    let mut huge = sindy_expr::Expr::variable("x");
    for _ in 0..60 {
        huge = &huge + &huge;
    }
    let huge = vec![vec![Term::new(huge, 1.0)]];
    assert!(text(Model::new(c, &["x"], &[], huge)).contains("bytes of text"));
    let library = Library::parse(&["x"]).unwrap();
    let short = Model::from_library(c, &["x"], &[], &library, &[vec![]]);
    assert!(text(short).contains("expected 1, found 0"));
    let good = model(&["x"], &["u"], &[&[("x", 1.0)]]);
    assert!(good.predict(&[&[1.0]]).is_err());
    assert!(good.predict(&[&[1.0], &[]]).is_err());
    assert_eq!(good.predict(&[&[], &[]]), Ok(vec![vec![]]));
}

#[test]
fn analytic_jacobian_of_states_and_inputs() {
    let model = model(
        &["x", "y"],
        &["u"],
        &[
            &[("x^2*y", 3.0), ("u", 2.0)],
            &[("exp(-x)*u", 1.0), ("y", -1.0), ("1", 5.0)],
        ],
    );
    let jacobian = model.jacobian().unwrap();
    let (x, y, u) = (0.5_f64, -2.0, 4.0);
    let (a, b) = jacobian.at(&[x, y], &[u]).unwrap();
    let e = (-x).exp();
    // Few operations on numbers near 1: a few roundings of 1e-16.
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14);
    close(a[(0, 0)], 6.0 * x * y);
    close(a[(0, 1)], 3.0 * x * x);
    close(a[(1, 0)], -e * u);
    close(a[(1, 1)], -1.0);
    close(b[(0, 0)], 2.0);
    close(b[(1, 0)], e);
    let text: Vec<String> = jacobian
        .expressions()
        .iter()
        .flatten()
        .map(ToString::to_string)
        .collect();
    assert_eq!(text, ["6*x*y", "3*x^2", "2", "-u*exp(-x)", "-1", "exp(-x)"]);
    assert!(jacobian.at(&[x], &[u]).is_err());
    assert!(jacobian.at(&[x, y], &[]).is_err());
}

proptest! {
    #[test]
    fn prop_columns_and_rows_agree_bit_for_bit(
        model in any_model(),
        // Across the boundary of a chunk.
        rows in prop::sample::select(vec![1_usize, 2, 511, 512, 513, 1100]),
    ) {
        let width = model.states().len() + model.inputs().len();
        let columns: Vec<Vec<f64>> = (0..width)
            .map(|c| (0..rows).map(|r| ((r * 7 + c * 13) % 19) as f64 * 0.3 - 2.0).collect())
            .collect();
        let views: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let blocks = model.predict(&views).unwrap();
        let mut evaluator = model.evaluator();
        let n = model.states().len();
        let mut out = vec![0.0; n];
        for r in 0..rows {
            let row: Vec<f64> = columns.iter().map(|c| c[r]).collect();
            evaluator.eval(&row[..n], &row[n..], &mut out);
            for (i, value) in out.iter().enumerate() {
                let same = value.to_bits() == blocks[i][r].to_bits();
                prop_assert!(same || (value.is_nan() && blocks[i][r].is_nan()));
            }
        }
    }
}
