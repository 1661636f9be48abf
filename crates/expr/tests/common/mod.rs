//! Random expressions and evaluation, shared by the tests.
#![allow(dead_code, unreachable_pub)] // each test binary uses its own part

use proptest::prelude::*;
use sindy_expr::{Expr, Program, Scratch};

/// Variables of the random expressions; two of them need quotes.
pub const NAMES: [&str; 5] = ["x", "σ", "motor.m1", "ESC \"signal\" (µs)", "min"];

/// The value at one point.
pub fn value(expr: &Expr, names: &[&str], at: &[f64]) -> f64 {
    let mut out = [0.0];
    Program::compile(std::slice::from_ref(expr), names)
        .expect("known names")
        .eval_row(at, &mut out, &mut Scratch::new());
    out[0]
}

/// The value of a text at one point.
pub fn text_value(text: &str, names: &[&str], at: &[f64]) -> f64 {
    value(&Expr::parse(text).expect(text), names, at)
}

/// Equal bits, all NaN alike (IEEE 754 leaves their bits open).
pub fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// Fully parenthesised text of any expression of the language.
pub fn any_text() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        any::<f64>()
            .prop_filter("finite", |v| v.is_finite())
            .prop_map(|v| format!("({v:e})")),
        (-4_i32..5).prop_map(|v| format!("({v})")),
        prop::sample::select(&NAMES[..]).prop_map(quoted),
        prop::sample::select(&["pi", "inf", "nan", "-0"][..]).prop_map(|s| format!("({s})")),
    ];
    leaf.prop_recursive(6, 60, 3, |inner| {
        let unary = &[
            "-", "not ", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh",
            "abs", "sign", "floor", "isnan",
        ][..];
        let infix = &[
            "+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!=", " and ", " or ",
        ][..];
        let binary = &["min", "max", "hypot", "atan2"][..];
        prop_oneof![
            (prop::sample::select(unary), inner.clone()).prop_map(|(f, a)| format!("({f}({a}))")),
            (inner.clone(), prop::sample::select(infix), inner.clone())
                .prop_map(|(a, f, b)| format!("({a}{f}{b})")),
            (prop::sample::select(binary), inner.clone(), inner.clone())
                .prop_map(|(f, a, b)| format!("{f}({a},{b})")),
            (inner.clone(), -9_i32..10).prop_map(|(a, n)| format!("({a}^({n}))")),
            (inner.clone(), inner.clone(), inner).prop_map(|(c, a, b)| format!("if({c},{a},{b})")),
        ]
    })
}

/// Fully parenthesised text of an expression of x and y that is finite, with finite
/// slopes of all its parts, wherever it has no kink: arguments are kept inside the
/// domains, `q` below, or bounded, `b`.
pub fn smooth_text() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        (1_i32..6).prop_map(|v| format!("{v}")),
        (-30_i32..30).prop_map(|v| format!("({})", f64::from(v) / 8.0)),
        Just("x".to_owned()),
        Just("y".to_owned()),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        let q = |a: &str| format!("(0.5+{a}^2)");
        let b = |a: &str| format!("(0.9*tanh({a}))");
        let plain = prop::sample::select(&["-", "sin", "cos", "atan", "tanh", "abs"][..]);
        let positive = prop::sample::select(&["sqrt", "log"][..]);
        let bounded = prop::sample::select(&["exp", "tan", "asin", "acos"][..]);
        let infix = prop::sample::select(&["+", "-", "*"][..]);
        let two = prop::sample::select(&["min", "max"][..]);
        let apart = prop::sample::select(&["hypot", "atan2"][..]);
        let pair = || (inner.clone(), inner.clone());
        prop_oneof![
            (plain, inner.clone()).prop_map(|(f, a)| format!("({f}({a}))")),
            (positive, inner.clone()).prop_map(move |(f, a)| format!("{f}({})", q(&a))),
            (bounded, inner.clone()).prop_map(move |(f, a)| format!("{f}({})", b(&a))),
            (pair(), infix).prop_map(|((a, c), f)| format!("({a}{f}{c})")),
            pair().prop_map(move |(a, c)| format!("({a}/{})", q(&c))),
            (pair(), two).prop_map(|((a, c), f)| format!("{f}({a},{c})")),
            (pair(), apart.clone()).prop_map(move |((a, c), f)| format!("{f}({a},{})", q(&c))),
            (pair(), apart).prop_map(move |((a, c), f)| format!("{f}({},{c})", q(&a))),
            pair().prop_map(move |(a, c)| format!("({}^{})", q(&a), b(&c))),
            (inner.clone(), 0_i32..4).prop_map(|(a, n)| format!("({a}^{n})")),
            (inner.clone(), 1_i32..4).prop_map(move |(a, n)| format!("({}^-{n})", q(&a))),
            (pair(), inner.clone()).prop_map(|((c, a), e)| format!("if({c}<1,{a},{e})")),
        ]
    })
}

/// Fully parenthesised text of a polynomial of x, y and z with whole coefficients
/// small enough to be exact.
pub fn polynomial_text() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        (-3_i32..4).prop_map(|v| format!("({v})")),
        prop::sample::select(&["x", "y", "z"][..]).prop_map(str::to_owned),
    ];
    leaf.prop_recursive(4, 16, 2, |inner| {
        prop_oneof![
            (
                inner.clone(),
                prop::sample::select(&["+", "-", "*"][..]),
                inner.clone()
            )
                .prop_map(|(a, f, b)| format!("({a}{f}{b})")),
            inner.clone().prop_map(|a| format!("(-{a})")),
            (inner, 0_i32..3).prop_map(|(a, n)| format!("({a}^{n})")),
        ]
    })
}
