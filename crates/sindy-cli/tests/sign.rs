//! Signs of coefficients: `sindy fit --sign`.

use crate::common::{csv, fails, says, words, write};
use std::ffi::OsString;

/// Damped oscillation, x'' = -x - 0.2 x', with errors within 0.5 %: position and velocity at row i.
fn swing(i: usize) -> Vec<f64> {
    let (t, rate) = (0.05 * i as f64, 0.99_f64.sqrt());
    let (c, s) = ((rate * t).cos(), (rate * t).sin());
    let decay = (-0.1 * t).exp();
    let off = 0.005 * ((12.9898 * i as f64).sin() * 43758.5453).fract();
    vec![t, decay * c + off, decay * (-0.1 * c - rate * s) - off]
}

fn with(args: &[OsString], more: &[&str]) -> Vec<OsString> {
    let more = more.iter().map(OsString::from);
    args.iter().cloned().chain(more).collect()
}

#[test]
fn analytic_signs_are_kept_and_false_ones_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let settings = write(
        folder.path(),
        "s.toml",
        "[identify]\nsigns = [\"v': x < 0\"]\n",
    );
    let fit = words("fit {} --states x,v", &[&data]);
    let said = says(&with(&fit, &["--sign", "v': v < 0", "--sign", "v': x<=0"]));
    assert!(
        said.starts_with("x' = ") && !said.contains("contradict"),
        "{said}"
    );
    let false_one = with(
        &fit,
        &[
            "--sign",
            "v': v > 0",
            "--settings",
            settings.to_str().unwrap(),
        ],
    );
    let out = crate::common::run(&false_one);
    let warned = crate::common::text(&out.stderr);
    assert!(
        warned.contains("contradict the sign of v in v'"),
        "{warned}"
    );
    // A setting and an argument against each other.
    let settings = with(
        &fit,
        &[
            "--sign",
            "v': x > 0",
            "--settings",
            settings.to_str().unwrap(),
        ],
    );
    let error = fails(2, &settings);
    assert!(error.contains("nothing against `v': x < 0`"), "{error}");
}

#[test]
fn prop_commands_without_signs_refuse_them() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let settings = write(
        folder.path(),
        "s.toml",
        "[identify]\nsigns = [\"v': x < 0\"]\n",
    );
    let fit = words("fit {} --states x,v --stream", &[&data]);
    let error = fails(2, &with(&fit, &["--sign", "v': v < 0"]));
    assert!(
        error.contains("--sign") && error.contains("--stream"),
        "{error}"
    );
    let error = fails(2, &with(&fit, &["--settings", settings.to_str().unwrap()]));
    assert!(
        error.contains("`signs`: expected none in a stream"),
        "{error}"
    );
    let implicit = words("implicit {} --states x,v", &[&data]);
    let error = fails(2, &with(&implicit, &["--sign", "v': v < 0"]));
    assert!(error.contains("--sign"), "{error}");
}
