//! What texts mean, and how they fail.

mod common;

use common::text_value;
use sindy_expr::{Expr, MAX_NESTING, MAX_TEXT_BYTES};

fn number(text: &str) -> f64 {
    text_value(text, &[], &[])
}

#[test]
fn analytic_precedence_and_association() {
    for (text, value) in [
        ("1 + 2*3", 7.0),
        ("(1 + 2)*3", 9.0),
        ("10 - 4 - 3", 3.0),
        ("16/4/2", 2.0),
        ("2^3^2", 512.0),
        ("(2^3)^2", 64.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-2", 0.25),
        ("2*-3", -6.0),
        ("1 - -1", 2.0),
        ("--3", 3.0),
        ("-2*3 + 1", -5.0),
        ("2^-1*4", 2.0),
        (".5 + 1. + 1e-1 + 1E+1", 11.6),
        ("1 < 2 and 2 < 1 or 1 == 1", 1.0),
        ("1 == 1 or 1 == 1 and 0", 1.0),
        ("not 1 < 2", 0.0),
        ("not 0 and 0", 0.0),
        ("not (0 and 0)", 1.0),
        ("1 + (2 < 3)", 2.0),
        ("if(2 > 1, 10, 20) + if(0, 1, 2)", 12.0),
        ("min(3, -1) + max(3, -1)", 2.0),
        ("hypot(3, 4)", 5.0),
        ("sign(-3) + sign(0) + sign(7)*10", 9.0),
        ("floor(-1.5) + abs(-2)", 0.0),
        ("sqrt(16) + exp(0) + log(1)", 5.0),
        ("isnan(0/0) + isnan(1/0)*10", 1.0),
    ] {
        // The operations are exact here, or within the last digit of a sum.
        assert!((number(text) - value).abs() <= 2e-15, "{text}");
    }
}

#[test]
fn analytic_functions_at_known_points() {
    let pi = std::f64::consts::PI;
    for (text, value) in [
        ("sin(pi/6)", 0.5),
        ("cos(pi/3)", 0.5),
        ("tan(pi/4)", 1.0),
        ("asin(1)", pi / 2.0),
        ("acos(-1)", pi),
        ("atan(1)*4", pi),
        ("atan2(-1, -1)", -0.75 * pi),
        ("tanh(log(2))", 0.6),
        ("log(exp(2))", 2.0),
    ] {
        // A few units in the last place of the platform's functions.
        assert!(
            (number(text) - value).abs() < 1e-15 * 4.0,
            "{text} is {}",
            number(text)
        );
    }
}

#[test]
fn analytic_nan_rules() {
    for comparison in ["<", "<=", ">", ">=", "==", "!="] {
        assert_eq!(number(&format!("nan {comparison} 1")), 0.0);
        assert_eq!(number(&format!("nan {comparison} nan")), 0.0);
    }
    for text in [
        "min(nan, 1)",
        "min(1, nan)",
        "max(nan, 1)",
        "max(1, nan)",
        "log(-1)",
        "sqrt(-1)",
        "asin(2)",
        "sign(nan)",
    ] {
        assert!(number(text).is_nan(), "{text}");
    }
    assert_eq!(number("if(nan, 1, 2)"), 2.0);
    assert_eq!(number("not nan"), 1.0);
    assert_eq!(number("nan or 1"), 1.0);
    assert_eq!(number("1 and nan"), 0.0);
    assert_eq!(number("nan^0"), 1.0);
}

#[test]
fn analytic_names() {
    let e =
        Expr::parse("motor.m1 + σ*v_p - \"ESC signal (µs)\"/x₁ + \"a \"\"b\"\"\" + \"x\" + \"pi\"");
    let names = [
        "ESC signal (µs)",
        "a \"b\"",
        "motor.m1",
        "pi",
        "v_p",
        "x",
        "x₁",
        "σ",
    ];
    assert_eq!(e.expect("valid").variables(), names);
    assert_eq!(Expr::parse("\"x\"").ok(), Some(Expr::variable("x")));
    assert_eq!(Expr::variable("pi").to_string(), "\"pi\"");
    assert_eq!(Expr::variable("throttle.").to_string(), "\"throttle.\"");
}

#[test]
fn regress_canonical_text() {
    for (text, canonical) in [
        ("x ^ 2*y", "x^2*y"),
        ("((a+b)+c)-(d-e)", "a + b + c - (d - e)"),
        ("(a*b)*c/(d*e)", "a*b*c/(d*e)"),
        ("-(x^2)", "-x^2"),
        ("(-x)^2", "(-x)^2"),
        ("-(2*x)", "-(2*x)"),
        ("- 2*x", "-2*x"),
        ("x^(y^z)^-1", "x^(y^z)^-1"),
        ("(x^y)^z", "(x^y)^z"),
        ("not(a)and(b or c)", "not a and (b or c)"),
        ("(a<b)==(c<d)", "(a < b) == (c < d)"),
        ("1.50e0", "1.5"),
        ("1e300*1e-300", "1e300*1e-300"),
        ("\"x\" + \"x y\"", "x + \"x y\""),
    ] {
        assert_eq!(Expr::parse(text).expect(text).to_string(), canonical);
    }
}

#[test]
fn regress_errors_show_the_place() {
    let error = Expr::parse("x + * y").expect_err("two operators");
    assert_eq!((error.position, error.column), (4, 5));
    assert_eq!(
        error.to_string(),
        "column 5: expected a value, found `*`\n  x + * y\n      ^"
    );
    let error = Expr::parse("σ + µ $ 1").expect_err("odd character");
    assert_eq!((error.position, error.column), (8, 7));
}

#[test]
fn regress_errors_say_what_was_expected() {
    for (text, expected, found) in [
        ("", "a value", "the end of the text"),
        ("   ", "a value", "the end of the text"),
        ("2x", "an operator or the end of the text", "`x`"),
        ("(1 + 2", "an operator or `)`", "the end of the text"),
        ("1)", "an operator or the end of the text", "`)`"),
        ("x = 1", "`==` for comparison", "`=`"),
        ("a && b", "`and`", "`&`"),
        ("!a", "`not`, or `!=` for comparison", "`!`"),
        ("x ** 2", "a value", "`*`"),
        ("1 < x < 2", "`and` between two comparisons", "`<`"),
        ("1 + not x", "a value (put `not …` in parentheses)", "`not`"),
        ("sni(x)", "a known function such as `sin`", "`sni`"),
        (
            "qqqq(x)",
            "a known function (or `*` before the parenthesis)",
            "`qqqq`",
        ),
        (
            "sin",
            "`(` after the function `sin` (a variable of that name is written in double quotes)",
            "the end of the text",
        ),
        (
            "min(1)",
            "an operator or `,`: `min` takes 2 arguments",
            "`)`",
        ),
        (
            "sin(1, 2)",
            "an operator or `)`: `sin` takes 1 argument",
            "`,`",
        ),
        (
            "\"abc",
            "a closing `\"` for this quoted name",
            "the end of the text",
        ),
        ("\"\"", "a name between the quotes", "an empty name"),
        ("1e999", "a number of magnitude below 1.8e308", "`1e999`"),
        ("1e", "a number such as 1, .5 or 1e-3", "`1e`"),
        (".", "a number such as 1, .5 or 1e-3", "`.`"),
        ("1 and", "a value", "the end of the text"),
        ("output[0]", "`(`", "`[`"),
    ] {
        let error = Expr::parse(text).expect_err(text);
        assert_eq!(
            (error.expected.as_str(), error.found.as_str()),
            (expected, found),
            "{text}"
        );
    }
}

#[test]
fn prop_hostile_nesting_is_an_error_not_an_overflow() {
    for (open, close) in [
        ("(", ")"),
        ("-", ""),
        ("not ", ""),
        ("sin(", ")"),
        ("2^", ""),
        ("if(1,1,", ")"),
        ("a or b and c < d + e*-(", ")"),
    ] {
        let nested = |n: usize| format!("{}1{}", open.repeat(n), close.repeat(n));
        let levels = if open.ends_with("-(") { 2 } else { 1 };
        assert!(Expr::parse(&nested(MAX_NESTING / levels)).is_ok(), "{open}");
        let error = Expr::parse(&nested(MAX_NESTING / levels + 1)).expect_err(open);
        assert!(error.expected.contains("levels of nesting"), "{error}");
        assert!(Expr::parse(&open.repeat(MAX_TEXT_BYTES / open.len())).is_err());
    }
}

#[test]
fn prop_long_texts_work_up_to_the_limit() {
    // A long chain is deep as a tree but not nested as text.
    let mut text = "x".to_owned();
    while text.len() + 2 <= MAX_TEXT_BYTES {
        text.push_str("+x");
    }
    let e = Expr::parse(&text).expect("within the limit");
    let terms = text.len().div_ceil(2);
    assert_eq!(e.simplify().to_string(), format!("{terms}*x"));
    assert_eq!(e.derivative("x").to_string(), terms.to_string());
    assert_eq!(common::value(&e, &["x"], &[1.0]), terms as f64);
    text.push_str("+xx");
    let error = Expr::parse(&text).expect_err("too long");
    assert!(error.expected.contains("65536 bytes"), "{error}");
}
