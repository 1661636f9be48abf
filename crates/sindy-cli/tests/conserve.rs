//! Invariants: `sindy fit --conserve`.

use std::ffi::OsString;

use serde_json::Value;

use crate::common::{csv, fails, files, json, number, run, says, text, words, write};

/// A rotation, x' = 3 v, v' = -3 x, with errors within 0.5 %: position and velocity at row i.
pub(crate) fn swing(i: usize) -> Vec<f64> {
    let t = 0.02 * i as f64;
    let off = 0.005 * ((12.9898 * i as f64).sin() * 43758.5453).fract();
    vec![t, (3.0 * t).cos() + off, -(3.0 * t).sin() - off]
}

/// The same with friction.
fn damped(i: usize) -> Vec<f64> {
    let row = swing(i);
    let decay = (-0.05 * row[0]).exp();
    vec![row[0], decay * row[1], decay * row[2]]
}

pub(crate) fn with(args: &[OsString], more: &[&str]) -> Vec<OsString> {
    let more = more.iter().map(OsString::from);
    args.iter().cloned().chain(more).collect()
}

/// The coefficients of both equations, `x' = a v` and `v' = b x`.
pub(crate) fn coefficients(equations: &Value) -> (f64, f64) {
    let of = |state: &str| {
        let own = equations[state].as_array().unwrap();
        assert_eq!(own.len(), 1, "{equations}");
        number(&own[0]["coefficient"])
    };
    (of("x"), of("v"))
}

#[test]
fn analytic_the_model_keeps_the_invariant_in_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let model = folder.path().join("model.json");
    let settings = "[identify]\nconserve = [\"x^2 + v^2\"]\n";
    let settings = write(folder.path(), "s.toml", settings);
    let fit = words("fit {} --states x,v", &[&data]);
    // From an argument and from a file; the same invariant in other words changes nothing.
    let path = model.to_str().unwrap();
    let argument = with(&fit, &["--conserve", "(x^2 + v^2)/2", "--model", path]);
    let both = [
        "--settings",
        settings.to_str().unwrap(),
        "--conserve",
        "x^2/2 + v^2/2",
    ];
    for args in [&argument, &with(&fit, &both)] {
        let found = json(0, args);
        let (a, b) = coefficients(&found["equations"]);
        // Errors within 0.5 % of 500 rows over 30 radians.
        assert!((a - 3.0).abs() < 0.01, "{a}");
        assert!((a + b).abs() < 1e-14 * a, "{a} {b}");
        assert!(
            !found["warnings"].to_string().contains("contradict"),
            "{found}"
        );
    }
    let written: Value = serde_json::from_slice(&std::fs::read(&model).unwrap()).unwrap();
    let (a, b) = coefficients(&written["equations"]);
    assert!((a + b).abs() < 1e-14 * a, "{a} {b}");
    let said = says(&with(&fit, &["--conserve", "x^2 + v^2"]));
    let numbers: Vec<&str> = said.lines().take(2).collect();
    assert!(
        numbers[0].starts_with("x' = ") && numbers[0].ends_with("*v"),
        "{said}"
    );
    // The numbers are printed alike.
    let print = |line: &str| line.trim_start_matches(|c: char| !c.is_ascii_digit())[..5].to_owned();
    assert_eq!(print(numbers[0]), print(numbers[1]), "{said}");
}

#[test]
fn analytic_friction_contradicts_the_energy() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, damped));
    let fit = words("fit {} --states x,v --conserve x^2+v^2", &[&data]);
    let out = run(&fit);
    let warned = text(&out.stderr);
    assert!(
        warned.contains("the data contradict that `x^2+v^2` is conserved"),
        "{warned}"
    );
}

#[test]
fn prop_invariants_that_make_no_sense_are_refused_and_no_file_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let settings = "[identify]\nconserve = [\"x^2 + v^2\"]\n";
    let settings = write(folder.path(), "s.toml", settings);
    let settings = settings.to_str().unwrap();
    let model = folder.path().join("model.json");
    let path = model.to_str().unwrap();
    let before = files(folder.path());
    let fit = words("fit {} --states x,v", &[&data]);
    for (more, says) in [
        (
            &["--conserve", "x^2 + w"][..],
            "an expression of the states x, v, found `w`",
        ),
        (&["--conserve", "x^2 +"], "expected an expression"),
        (&["--conserve", "1"], "depends on a state"),
        (
            &["--conserve", "v^2/2 - cos(x)"],
            "`sin(x)` in v' are needed",
        ),
        (&["--conserve", "x", "--conserve", "v"], "none but zero"),
        (&["--conserve", "x", "--known", "x' = v"], "--known"),
        (&["--conserve", "x", "--sign", "x': v > 0"], "--sign"),
        (&["--conserve", "x", "--second-order"], "--second-order"),
        (&["--conserve", "x", "--discrete"], "--discrete"),
        (&["--conserve", "x", "--stream"], "--stream"),
        (
            &["--settings", settings, "--stream"],
            "`conserve`: expected none in a stream",
        ),
        (
            &["--settings", settings, "--discrete"],
            "expected none in discrete time",
        ),
        (
            &["--settings", settings, "--known", "x' = v"],
            "expected none beside `known`",
        ),
    ] {
        let error = fails(2, &with(&fit, &[more, &["--model", path]].concat()));
        assert!(error.contains(says), "{more:?}: {error}");
        assert!(error.contains("conserve"), "{more:?}: {error}");
    }
    let implicit = words("implicit {} --states x,v --conserve x", &[&data]);
    assert!(fails(2, &implicit).contains("--conserve"));
    assert_eq!(files(folder.path()), before);
}
