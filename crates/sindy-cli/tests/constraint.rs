//! Relations between coefficients: `sindy fit --constraint`.

use std::ffi::OsString;

use serde_json::Value;

use crate::common::{csv, fails, files, json, number, run, text, words, write};

/// A rotation, x' = 3 v, v' = -3 x, with errors within 0.5 %: position and velocity at row i.
fn swing(i: usize) -> Vec<f64> {
    let t = 0.02 * i as f64;
    let off = 0.005 * ((12.9898 * i as f64).sin() * 43758.5453).fract();
    vec![t, (3.0 * t).cos() + off, -(3.0 * t).sin() - off]
}

fn with(args: &[OsString], more: &[&str]) -> Vec<OsString> {
    let more = more.iter().map(OsString::from);
    args.iter().cloned().chain(more).collect()
}

/// The coefficients of both equations, `x' = a v` and `v' = b x`.
fn coefficients(equations: &Value) -> (f64, f64) {
    let of = |state: &str| {
        let own = equations[state].as_array().unwrap();
        assert_eq!(own.len(), 1, "{equations}");
        number(&own[0]["coefficient"])
    };
    (of("x"), of("v"))
}

#[test]
fn analytic_a_relation_holds_to_rounding_from_arguments_and_settings() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let settings = "[identify]\nconstraints = [\"[x': v] = -[v': x]\"]\n";
    let settings = write(folder.path(), "s.toml", settings);
    let fit = words("fit {} --states x,v", &[&data]);
    let argument = with(&fit, &["--constraint", "-2*[v': x] - 2*[x': v] = 0"]);
    let file = with(&fit, &["--settings", settings.to_str().unwrap()]);
    for args in [&argument, &file] {
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
    let wrong = run(with(&fit, &["--constraint", "[x': v] = [v': x]"]));
    let warned = text(&wrong.stderr);
    assert!(
        warned.contains("the data contradict `[x': v] = [v': x]`"),
        "{warned}"
    );
}

#[test]
fn prop_relations_that_make_no_sense_are_refused_and_no_file_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let model = folder.path().join("model.json");
    let before = files(folder.path());
    let fit = words("fit {} --states x,v", &[&data]);
    for (more, says) in [
        (&["x' = v"][..], "a relation such as"),
        (&["[x': v] = 3"], "without a constant"),
        (&["[x': w] = 0"], "a candidate term of x'"),
        (&["[w': v] = 0"], "one of x', v'"),
        (&["[x': v] = 0", "--sign", "x': v > 0"], "--sign"),
        (&["[x': v] = 0", "--discrete"], "--discrete"),
        (&["[x': v] = 0", "--stream"], "--stream"),
    ] {
        let path = ["--model", model.to_str().unwrap()];
        let more = [&["--constraint"], more, &path].concat();
        let error = fails(2, &with(&fit, &more));
        assert!(
            error.contains(says) && error.contains("constrain"),
            "{more:?}: {error}"
        );
    }
    assert_eq!(files(folder.path()), before);
}
