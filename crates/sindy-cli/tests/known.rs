//! Known equations, and equations of second order: `sindy fit --known` and `--second-order`.

use crate::common::{csv, fails, json, number, says, text, words, write};
use std::ffi::OsString;

/// A number between -1 and 1 that looks random.
fn noise(i: usize) -> f64 {
    ((12.9898 * i as f64).sin() * 43758.5453).fract()
}

/// Damped oscillation, x'' = -x - 0.2 x', with errors within 0.5 %: position and velocity at row i.
fn swing(i: usize) -> Vec<f64> {
    let (t, rate) = (0.05 * i as f64, 0.99_f64.sqrt());
    let (c, s) = ((rate * t).cos(), (rate * t).sin());
    let decay = (-0.1 * t).exp();
    let off = 0.005 * noise(i);
    let x = decay * c;
    let v = decay * (-0.1 * c - rate * s);
    vec![t, x + off, v - off]
}

fn with(mut args: Vec<OsString>, more: &[&str]) -> Vec<OsString> {
    args.extend(more.iter().map(Into::into));
    args
}

#[test]
fn analytic_positions_alone_give_the_equation_of_second_order() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let (model, figure) = (folder.path().join("m.json"), folder.path().join("f.svg"));
    let args = words(
        "fit {} --states x --second-order --test {} --model {} --figure {}",
        &[&data, &data, &model, &figure],
    );
    let object = json(0, &args);
    let position = object["equations"]["x"].as_array().unwrap();
    assert_eq!((position.len(), &position[0]["term"]), (1, &"x_dot".into()));
    assert!(position[0]["std_error"].is_null() && position[0]["interval"].is_null());
    let found = object["equations"]["x_dot"].as_array().unwrap();
    let terms: Vec<&str> = found.iter().map(|t| t["term"].as_str().unwrap()).collect();
    assert_eq!(terms, ["x", "x_dot"], "{object:#}");
    for (term, truth) in found.iter().zip([-1.0, -0.2]) {
        // 500 rows with errors of 0.3 % of the first amplitude: ten times the expected error of 0.05 %.
        assert!(
            (number(&term["coefficient"]) - truth).abs() < 5e-3,
            "{term}"
        );
    }
    // The test's velocities come from its positions, and the model runs from a start with a velocity.
    // Beside errors of 0.003 of the data, that of the first velocity counts, which is a slope at the end of a record:
    // some 0.02 of an amplitude of 1, half of it left on average.
    let error = number(&object["test"]["free_run"][0]["rmse"]["x"]);
    assert!(error < 0.02 && figure.exists(), "{error}");
    let said = says(&words(
        "simulate {} --start x=1,x_dot=-0.1 --until 1 --step 0.1",
        &[&model],
    ));
    assert!(said.contains("x_dot"), "{said}");
    let error = fails(2, &words("fit {} --states x --second-order=v", &[&data]));
    assert!(
        error.contains("--second-order: ") && error.contains("`v`"),
        "{error}"
    );
}

#[test]
fn analytic_a_known_equation_is_printed_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "swing.csv", &csv("t,x,v", 500, swing));
    let fit = words("fit {} --states x,v", &[&data]);
    let known = with(
        fit.clone(),
        &["--known", "x' = v", "--known", "v' = -0.2*v + ..."],
    );
    let said = text(&crate::common::run(&known).stdout);
    assert!(
        said.starts_with("x' = 1.0000*v\nv' = -0.20000*v - "),
        "{said}"
    );
    let stream = fails(2, &with(known, &["--stream"]));
    assert!(stream.contains("--stream"), "{stream}");
    let error = fails(2, &with(fit, &["--known", "x = v"]));
    assert!(error.contains("one of x', v' before `=`"), "{error}");
}
