//! Derivatives, simplification, substitution, operators.

mod common;

use common::{smooth_text, text_value, value};
use proptest::prelude::*;
use sindy_expr::Expr;

fn parse(text: &str) -> Expr {
    Expr::parse(text).expect(text)
}

#[test]
fn analytic_derivatives() {
    for (text, derivative) in [
        ("7", "0"),
        ("y", "0"),
        ("x", "1"),
        ("x^3", "3*x^2"),
        ("x^2*y + 4*x", "2*x*y + 4"),
        ("1/x", "-1/x^2"),
        ("x^-2", "-2/x^3"),
        ("sin(2*x)", "2*cos(2*x)"),
        ("cos(x)", "-sin(x)"),
        ("exp(-x)*s", "-s*exp(-x)"),
        ("log(x)", "1/x"),
        ("sqrt(x)", "0.5/sqrt(x)"),
        ("tanh(x)", "1 - tanh(x)^2"),
        ("atan(x)", "1/(1 + x^2)"),
        ("abs(x)", "sign(x)"),
        ("2^x", "0.6931471805599453*2^x"),
        ("x^y", "y*x^(y - 1)"),
        ("min(x, y)", "if(x < y, 1, 0)"),
        ("if(x > 0, x^2, -x)", "if(x > 0, 2*x, -1)"),
        ("(x > 3) + floor(x) + sign(x) + isnan(x)", "0"),
        ("hypot(x, 3)", "x/hypot(x, 3)"),
        ("atan2(x, y)", "y/(x^2 + y^2)"),
        ("atan2(y, x)", "-y/(y^2 + x^2)"),
    ] {
        assert_eq!(
            parse(text).derivative("x").to_string(),
            derivative,
            "d/dx of {text}"
        );
    }
}

#[test]
fn paper_derivative_of_printed_thrust_model() {
    // x' of the printed thrust model, eq. (11); its slope in x is the eigenvalue of
    // the rest state. Reference values: -2.926 at throttle 0.3, where the rest
    // thrust is x^2 = 8.088 N; -4.913 at 0.5 and 13.768 N; -7.225 at 0.8, 19.268 N.
    let model = parse(
        "0.215 - 0.650*x + 13.882*s + 11.815*s^2 - 0.123*x^3 - 12.825*s^3 \
         - 16.647*exp(-x)*s - 1.457*sin(x)*s",
    );
    let slope = model.derivative("x");
    for (s, thrust, eigenvalue) in [
        (0.3, 8.088, -2.926),
        (0.5, 13.768, -4.913),
        (0.8, 19.268, -7.225),
    ] {
        let found = value(&slope, &["x", "s"], &[f64::sqrt(thrust), s]);
        // Printed to three decimals, from a thrust printed to three decimals.
        assert!((found - eigenvalue).abs() < 1.5e-3, "{found} at {s}");
        let rest = value(&model, &["x", "s"], &[f64::sqrt(thrust), s]);
        // Half a digit of the printed thrust times the eigenvalue, below 1e-3.
        assert!(rest.abs() < 1e-3, "{rest} at {s}");
    }
}

#[test]
fn analytic_simplification() {
    for (text, simple) in [
        ("0*x + 1*y", "y"),
        ("x + 0", "x"),
        ("x - x", "0"),
        ("x*y + y*x", "2*x*y"),
        ("2*3*x*x*x", "6*x^3"),
        ("x^2*x^3", "x^5"),
        ("(x^2)^3", "x^6"),
        ("(2*x*y)^2", "4*x^2*y^2"),
        ("x/x", "x/x"),
        ("x/x^3", "1/x^2"),
        ("x^3*y/x", "x^3*y/x"),
        ("1/(1/x)", "x"),
        ("x/2/4", "0.125*x"),
        ("a - (b - c)", "a - b + c"),
        ("-(a + b)*-1", "a + b"),
        ("-x*y", "-x*y"),
        ("c + -1*(a + b)", "c - a - b"),
        ("x^0 + x^1", "1 + x"),
        ("sin(0) + cos(0)*z", "z"),
        ("if(1 < 2, a, b)", "a"),
        ("if(q, a, a)", "a"),
        ("sqrt(x)^2", "sqrt(x)^2"),
        ("x^0.5*x^0.5", "(x^0.5)^2"),
        ("log(-1)*x", "x*log(-1)"),
        ("1/0 + x", "1/0 + x"),
        ("1e200*1e200*x", "1e200*x*1e200"),
        ("3 + x + 4", "7 + x"),
        ("--x", "x"),
        ("2^10", "1024"),
        ("not 0", "1"),
    ] {
        assert_eq!(parse(text).simplify().to_string(), simple, "{text}");
    }
}

#[test]
fn analytic_operators_and_substitution() {
    let (x, y) = (Expr::variable("x"), Expr::variable("y"));
    let e = (x.powi(2) * y.clone() - Expr::constant(-1.5)) / -(&x + &y);
    assert_eq!(e.to_string(), "(x^2*y - -1.5)/-(x + y)");
    assert_eq!(e, parse(&e.to_string()));
    assert_eq!(
        Expr::monomial(&[("x", 2), ("z", 0), ("y", 1)]).to_string(),
        "x^2*y"
    );
    assert_eq!(Expr::monomial(&[]).to_string(), "1");
    assert_eq!(
        Expr::sum([x.clone(), y.clone(), x.clone()]).to_string(),
        "x + y + x"
    );
    assert_eq!(Expr::sum([]).to_string(), "0");
    let swapped = parse("x*(x + y)").substitute("x", &parse("x - y"));
    assert_eq!(swapped.to_string(), "(x - y)*(x - y + y)");
    assert_eq!(Expr::constant(2.5).as_constant(), Some(2.5));
    assert_eq!(x.as_constant(), None);
    assert_eq!("x + y".parse::<Expr>().ok(), Some(x + y));
}

#[test]
fn prop_deep_shared_expressions_cost_nothing_special() {
    // 2^60 leaves as a tree, 61 nodes as shared.
    let x = Expr::variable("x");
    let mut e = x.clone();
    for _ in 0..60 {
        e = &e + &e;
    }
    assert_eq!(e.simplify().to_string(), "1.152921504606847e18*x");
    assert_eq!(value(&e, &["x"], &[1.0]), 2.0_f64.powi(60));
    // Nested 20 000 deep: no stack is used.
    let program = Expr::product(std::iter::repeat_n(parse("1/(1 + x)"), 20_000));
    assert_eq!(program.simplify().to_string(), "1/(1 + x)^20000");
    assert_eq!(program.derivative("x").variables(), ["x"]);
    drop(program);
}

/// Central difference that has converged, or nothing.
fn numerical_slope(e: &Expr, x: f64, y: f64) -> Option<f64> {
    let f = |x: f64| value(e, &["x", "y"], &[x, y]);
    let central = |h: f64| (f(x + h) - f(x - h)) / (2.0 * h);
    let richardson = |h: f64| (4.0 * central(h / 2.0) - central(h)) / 3.0;
    let [a, b, c] = [2e-3, 1e-3, 4e-4].map(richardson);
    // Only where three step sizes agree: smooth here, and no heavy cancellation.
    // No kink within any step: one-sided slopes agree too.
    let sides = [(f(x + 2e-3) - f(x)) / 2e-3, (f(x) - f(x - 2e-3)) / 2e-3];
    let scale = c.abs().max(1.0);
    let settled = (a - c).abs() < 1e-7 * scale && (b - c).abs() < 1e-7 * scale;
    let smooth = (sides[0] - sides[1]).abs() < 0.05 * scale;
    (settled && smooth && c.is_finite() && scale < 1e6).then_some(c)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, max_global_rejects: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn prop_derivative_agrees_with_differences(text in smooth_text(), x in 0.1..2.0_f64, y in 0.1..2.0_f64) {
        let e = parse(&text);
        if let Some(expected) = numerical_slope(&e, x, y) {
            let found = value(&e.derivative("x"), &["x", "y"], &[x, y]);
            // Ten times the agreement that was asked of the differences themselves.
            let tolerance = 1e-6 * expected.abs().max(1.0);
            prop_assert!((found - expected).abs() < tolerance, "{text}: {found} against {expected}");
        }
    }

    #[test]
    fn prop_simplified_has_the_same_value(text in smooth_text(), x in 0.1..2.0_f64, y in 0.1..2.0_f64) {
        let e = parse(&text);
        let f = |x: f64, y: f64| value(&e, &["x", "y"], &[x, y]);
        let (before, after) = (f(x, y), value(&e.simplify(), &["x", "y"], &[x, y]));
        // Where a change of the inputs by 1e-9 moves the value little, rounding of
        // intermediate results in another order (1e-16, amplified likewise) moves it less.
        let moved = (f(x * (1.0 + 1e-9), y) - before).abs() + (f(x, y * (1.0 + 1e-9)) - before).abs();
        let scale = before.abs().max(1.0);
        if before.is_finite() && scale < 1e6 && moved < 1e-7 * scale {
            prop_assert!((after - before).abs() < 1e-6 * scale, "{text}: {after} against {before}");
        }
    }
}

#[test]
fn analytic_quotient_rule_value() {
    // d/dx x/(1+x^2) = (1-x^2)/(1+x^2)^2 = 0.75/1.5625 = 0.48 at x = 0.5.
    let slope = parse("x/(1 + x^2)").derivative("x").to_string();
    // Three roundings.
    assert!((text_value(&slope, &["x"], &[0.5]) - 0.48).abs() < 1e-15);
}
