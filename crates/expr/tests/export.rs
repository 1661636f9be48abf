//! C, Rust and LaTeX: the exported code is compiled, run and compared.

mod common;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use common::{same, value};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use sindy_expr::{C_SUPPORT, Expr, RUST_SUPPORT, code_identifier};

const NAMES: [&str; 5] = common::NAMES;
const POINT: [f64; 5] = [0.375, -1.25, 2.0, f64::NAN, -0.0];

/// Expressions that use every operation, and random ones from a fixed seed.
fn samples() -> Vec<Expr> {
    let fixed = [
        "x^2 + x^3 - x^-2/x^0.5 + (x + 1)^7 - x^0 + σ^1",
        "(x < σ)/(x > σ) + (x <= 1 and σ >= 1 or not x == 0)*2",
        "if(if(x, 1, 0) < 2, -(-x), --σ - -2)/if(x != σ, 3, 4)",
        "sqrt(x) + exp(x) + log(x) + sin(x) + cos(x) + tan(x) + asin(x) + acos(x) + atan(x)",
        "tanh(x) + abs(σ) + sign(σ) + floor(σ) + hypot(x, σ) + atan2(x, σ) + min(x, σ) + max(x, σ)",
        "isnan(nan) + isnan(x) - isnan(\"ESC \"\"signal\"\" (µs)\")",
        "min(\"ESC \"\"signal\"\" (µs)\", 1)",
        "1/\"min\" + inf",
        "1e-300*1e300 + 1e17 + 123456789",
        "motor.m1 - (x - (σ - 1))/(2*(x/3))",
    ];
    let mut runner = TestRunner::deterministic();
    let strategy = common::any_text();
    let random = (0..150).map(|_| strategy.new_tree(&mut runner).expect("a text").current());
    fixed
        .into_iter()
        .map(str::to_owned)
        .chain(random)
        .map(|text| Expr::parse(&text).expect(&text))
        .collect()
}

fn run(command: &mut Command) -> String {
    let output = command.output().expect("the tool starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {errors}");
    String::from_utf8(output.stdout).expect("text")
}

/// Each line of output is the bits of one value.
fn compare(output: &str, exprs: &[Expr]) {
    let lines: Vec<&str> = output.lines().collect();
    assert_eq!(lines.len(), exprs.len());
    for (line, e) in lines.into_iter().zip(exprs) {
        let found = f64::from_bits(u64::from_str_radix(line, 16).expect("bits"));
        let expected = value(e, &NAMES, &POINT);
        // The compiler may fold a call of a mathematical function with another
        // library than the one linked: allow some units in the last place.
        let close = (found - expected).abs() <= 1e-13 * expected.abs();
        assert!(
            same(found, expected) || close,
            "{e}: {found} against {expected}"
        );
    }
}

fn in_directory(test: impl FnOnce(&Path)) {
    let directory = tempfile::tempdir().expect("a directory");
    test(directory.path());
}

/// Truth: the system's C compiler (any that rustc itself links with).
#[cfg(unix)]
#[test]
fn xval_c_code_computes_the_same() {
    let exprs = samples();
    let mut source = format!("{C_SUPPORT}\n#include <stdio.h>\n#include <string.h>\n");
    for (k, e) in exprs.iter().enumerate() {
        let parameters: Vec<String> = NAMES
            .iter()
            .map(|name| format!("double {}", code_identifier(name)))
            .collect();
        let _ = writeln!(
            source,
            "double f{k}({}) {{ return {}; }}",
            parameters.join(", "),
            e.to_c()
        );
    }
    source.push_str("int main(void) {\n");
    for k in 0..exprs.len() {
        let _ = writeln!(
            source,
            "{{ double v = f{k}(0.375, -1.25, 2.0, NAN, -0.0); unsigned long long b; memcpy(&b, &v, 8); printf(\"%llx\\n\", b); }}"
        );
    }
    source.push_str("return 0; }\n");
    in_directory(|directory| {
        let file = directory.join("t.c");
        std::fs::write(&file, source).expect("written");
        let program = directory.join("t");
        run(Command::new("cc")
            .args(["-std=c99", "-O0", "-ffp-contract=off", "-o"])
            .args([&program, &file])
            .arg("-lm"));
        compare(&run(&mut Command::new(&program)), &exprs);
    });
}

/// Truth: rustc on the exported text.
#[test]
fn xval_rust_code_computes_the_same() {
    let exprs = samples();
    let mut source = format!(
        "#![deny(warnings)]\n#![allow(unused, non_snake_case, invalid_nan_comparisons)]\n{RUST_SUPPORT}\n"
    );
    for (k, e) in exprs.iter().enumerate() {
        let parameters: Vec<String> = NAMES
            .iter()
            .map(|name| format!("{}: f64", code_identifier(name)))
            .collect();
        let _ = writeln!(
            source,
            "fn f{k}({}) -> f64 {{ {} }}",
            parameters.join(", "),
            e.to_rust()
        );
    }
    source.push_str("fn main() {\n");
    for k in 0..exprs.len() {
        let _ = writeln!(
            source,
            "println!(\"{{:x}}\", f{k}(0.375, -1.25, 2.0, f64::NAN, -0.0).to_bits());"
        );
    }
    source.push_str("}\n");
    in_directory(|directory| {
        let file = directory.join("t.rs");
        std::fs::write(&file, source).expect("written");
        let program = directory.join("t");
        run(Command::new("rustc")
            .args(["--edition", "2024", "-o"])
            .args([&program, &file]));
        compare(&run(&mut Command::new(&program)), &exprs);
    });
}

#[test]
fn regress_exported_text() {
    let e = Expr::parse("0.804 - 3.912*s + x^3*\"Thrust (gf)\" + (x < 1)").expect("valid");
    assert_eq!(
        e.to_c(),
        "0.804 - 3.912*s + sindy_powi(x, 3)*Thrust_u20__u28_gf_u29_ + (double)(x < 1.0)"
    );
    let indexed = Expr::parse("a + b^2")
        .expect("valid")
        .to_c_with(|name| format!("in_{name}[0]"));
    assert_eq!(indexed, "in_a[0] + in_b[0]*in_b[0]");
    assert_eq!(
        Expr::parse("if(a < b, a, -b)").expect("valid").to_rust(),
        "if a < b { a } else { -b }"
    );
}

#[test]
fn regress_latex() {
    for (text, latex) in [
        (
            "0.804 - 0.088*f + 4.854*s^2",
            r"0.804 - 0.088\,f + 4.854\,s^{2}",
        ),
        ("(a + b)/(c*d)", r"\frac{a + b}{c\,d}"),
        ("(a/b)^2", r"\left(\frac{a}{b}\right)^{2}"),
        ("2*3*x*2^x", r"2 \cdot 3\,x \cdot 2^{x}"),
        ("-x*-y", r"-x\,\left(-y\right)"),
        ("1e-9*height_m", r"1 \cdot 10^{-9}\,\mathrm{height}_{m}"),
        (
            "sin(omega*t)^2 + exp(-x)",
            r"\left(\sin\left(\omega\,t\right)\right)^{2} + e^{-x}",
        ),
        ("\"A & B\"", r"\text{A \& B}"),
        (
            "if(z > 0, z, 0)",
            r"\begin{cases}z & \text{if } z > 0 \\ 0 & \text{otherwise}\end{cases}",
        ),
        (
            "1 + if(z, 1, 2)",
            r"1 + \left(\begin{cases}1 & \text{if } z \\ 2 & \text{otherwise}\end{cases}\right)",
        ),
        ("σ_1 + x_12 + pi_k", r"\sigma_{1} + x_{12} + \pi_{k}"),
    ] {
        assert_eq!(Expr::parse(text).expect(text).to_latex(), latex, "{text}");
    }
}
