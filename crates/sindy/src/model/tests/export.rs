//! Models as text and as code; the code is compiled, run and compared.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use super::model;
use crate::model::{Model, Term, Time};
use crate::problems;

#[test]
fn analytic_text_shows_every_term() {
    let model = model(
        &["x", "height (m)"],
        &["u"],
        &[
            &[
                ("x", -12.3456),
                ("x*u", 1e-9),
                ("1", 1.0),
                ("x + u", -0.00031),
            ],
            &[],
        ],
    );
    assert_eq!(
        format!("{model:.3}"),
        "x' = -12.3*x + 1.00e-9*x*u + 1.00 - 0.000310*(x + u)\n\"height (m)\"' = 0\n"
    );
    assert_eq!(
        model.to_string(),
        "x' = -12.3456*x + 1e-9*x*u + 1 - 0.00031*(x + u)\n\"height (m)\"' = 0\n"
    );
    // Digits are limited to what is sensible.
    assert!(format!("{model:.0}").starts_with("x' = -1e1*x"));
    assert!(format!("{model:.99}").starts_with("x' = -12.345599999999999*x"));
    let sure = vec![vec![Term::parse("x", 2.0).unwrap().with_std_error(0.0123)]];
    let sure = Model::new(Time::Discrete { period: 1.0 }, &["x"], &[], sure).unwrap();
    assert_eq!(format!("{sure:#.3}"), "x[k+1] = (2.00 ± 0.012)*x\n");
    assert_eq!(format!("{sure:.3}"), "x[k+1] = 2.00*x\n");
}

#[test]
fn analytic_latex() {
    let model = model(
        &["v_q", "σ"],
        &[],
        &[&[("v_q^2*σ", -1.5e-7), ("1", 2.0), ("2^σ", 1.0)], &[]],
    );
    assert_eq!(
        model.to_latex(Some(2)),
        "\\begin{aligned}\n\\dot{v_{q}} &= -1.5 \\cdot 10^{-7}\\,v_{q}^{2}\\,\\sigma + 2.0 + 1.0 \\cdot 2^{\\sigma} \\\\\n\
         \\dot{\\sigma} &= 0\n\\end{aligned}\n"
    );
}

/// Every kind of term, odd names, no terms; and a published model.
fn samples() -> Vec<(Model, Vec<f64>)> {
    let equation = |terms: &[(&str, f64)]| -> Vec<Term> {
        terms
            .iter()
            .map(|(text, c)| Term::parse(text, *c).unwrap())
            .collect()
    };
    let odd = vec![
        equation(&[
            ("\"*/ end\"^3*\"min\"", -1.0 / 3.0),
            ("if(\"min\" < 0, exp(-\"min\"), sqrt(2))", 1e-9),
            ("abs(\"*/ end\") + sign(\"min\")", 7.0),
        ]),
        vec![],
        equation(&[("1", -2.5), ("1/(1 + (\"min\"/0.2)^2)", 3.0)]),
    ];
    let odd = Model::new(
        Time::Discrete { period: 0.5 },
        &["*/ end", "y", "z"],
        &["min"],
        odd,
    );
    vec![
        (problems::lorenz().model().unwrap(), vec![-8.0, 7.0, 27.0]),
        (
            problems::propeller_thrust().model().unwrap(),
            vec![2.8, 0.4],
        ),
        (odd.unwrap(), vec![1.25, 0.0, -0.75, -0.3]),
    ]
}

fn run(command: &mut Command) -> String {
    let output = command.output().expect("the tool starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && errors.is_empty(),
        "{command:?}: {errors}"
    );
    String::from_utf8(output.stdout).expect("text")
}

fn compare(output: &str) {
    let found: Vec<f64> = output
        .lines()
        .map(|line| f64::from_bits(u64::from_str_radix(line, 16).expect("bits")))
        .collect();
    let mut expected = Vec::new();
    for (model, row) in samples() {
        let n = model.states().len();
        let mut out = vec![0.0; n];
        model.evaluator().eval(&row[..n], &row[n..], &mut out);
        expected.extend(out);
    }
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        // exp and sin of another library may differ in the last place of terms of about 10.
        assert!(
            (a - b).abs() <= 1e-14 * b.abs().max(10.0),
            "{a} against {b}"
        );
    }
}

fn in_directory(test: impl FnOnce(&Path)) {
    let directory = tempfile::tempdir().expect("a directory");
    test(directory.path());
}

/// Truth: the system's C compiler (any that rustc itself links with), with warnings as errors.
#[cfg(unix)]
#[test]
fn xval_c_code_computes_the_same() {
    in_directory(|directory| {
        let mut main =
            String::from("#include <stdio.h>\n#include <string.h>\n#include <stdint.h>\n");
        let mut body = String::new();
        let mut sources = Vec::new();
        for (k, (model, row)) in samples().iter().enumerate() {
            let path = directory.join(format!("f{k}.c"));
            std::fs::write(&path, model.to_c(&format!("f{k}")).unwrap()).unwrap();
            sources.push(path);
            let n = model.states().len();
            let list = |v: &[f64]| {
                v.iter()
                    .map(|x| format!("{x:?}"))
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            let has_inputs = row.len() > n;
            let parameter = if has_inputs { "const double *, " } else { "" };
            let _ = writeln!(main, "void f{k}(const double *, {parameter}double *);");
            // The output over the state: allowed.
            let _ = writeln!(body, "{{ double x[] = {{{}}};", list(&row[..n]));
            if has_inputs {
                let _ = writeln!(body, "double u[] = {{{}}}; f{k}(x, u, x);", list(&row[n..]));
            } else {
                let _ = writeln!(body, "f{k}(x, x);");
            }
            let _ = writeln!(
                body,
                "for (int i = 0; i < {n}; i++) {{ uint64_t b; memcpy(&b, &x[i], 8); \
                 printf(\"%llx\\n\", (unsigned long long)b); }} }}"
            );
        }
        let _ = writeln!(main, "int main(void) {{\n{body}return 0; }}");
        let main_path = directory.join("main.c");
        std::fs::write(&main_path, main).unwrap();
        let program = directory.join("program");
        run(Command::new("cc")
            .args([
                "-std=c99",
                "-O1",
                "-ffp-contract=off",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-o",
            ])
            .arg(&program)
            .arg(main_path)
            .args(sources)
            .arg("-lm"));
        compare(&run(&mut Command::new(&program)));
    });
}

/// Truth: rustc, with warnings as errors.
#[test]
fn xval_rust_code_computes_the_same() {
    in_directory(|directory| {
        let mut main = String::new();
        let mut body = String::new();
        for (k, (model, row)) in samples().iter().enumerate() {
            let code = model.to_rust(&format!("f{k}")).unwrap();
            let _ = writeln!(main, "mod m{k} {{\n{code}\n}}");
            let (state, input) = row.split_at(model.states().len());
            let input = if input.is_empty() {
                String::new()
            } else {
                format!(", &{input:?}")
            };
            let _ = writeln!(
                body,
                "for v in m{k}::f{k}(&{state:?}{input}) {{ println!(\"{{:x}}\", v.to_bits()); }}"
            );
        }
        let _ = writeln!(main, "fn main() {{\n{body}}}");
        let source = directory.join("main.rs");
        std::fs::write(&source, main).unwrap();
        let program = directory.join("program");
        run(Command::new("rustc")
            .args(["--edition", "2021", "-Dwarnings", "-o"])
            .arg(&program)
            .arg(source));
        compare(&run(&mut Command::new(&program)));
    });
}

#[test]
fn function_names_are_checked() {
    let model = problems::lorenz().model().unwrap();
    for name in ["", "double", "2x", "a b", "x;", "σ", "fn"] {
        assert!(
            model.to_c(name).unwrap_err().to_string().contains("`name`"),
            "{name}"
        );
        assert!(model.to_rust(name).is_err());
    }
}
