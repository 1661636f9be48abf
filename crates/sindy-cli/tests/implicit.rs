//! `sindy implicit`: a rational equation as text, as an object and as a model that runs; clear errors.

use tempfile::TempDir;

use crate::common::{csv, fails, json, number, says, words, write};

/// `x' = 0.6 - 1.5 x/(0.3 + x)` from two starts, by Runge and Kutta's method in steps of 0.002.
fn enzyme() -> String {
    let slope = |x: f64| 0.6 - 1.5 * x / (0.3 + x);
    let runs = [1.5, 0.02].map(|start| {
        let mut x: f64 = start;
        let mut out = Vec::new();
        for _ in 0..200 {
            out.push(x);
            for _ in 0..10 {
                let h = 0.002;
                let a = slope(x);
                let b = slope(x + 0.5 * h * a);
                let c = slope(x + 0.5 * h * b);
                let d = slope(x + h * c);
                x += h / 6.0 * (a + 2.0 * (b + c) + d);
            }
        }
        out
    });
    csv("run,t,x", 400, |i| {
        vec![
            (i / 200) as f64,
            0.02 * (i % 200) as f64,
            runs[i / 200][i % 200],
        ]
    })
}

#[test]
fn analytic_an_enzyme_is_found_printed_and_run() {
    let folder = TempDir::new().unwrap();
    let data = write(folder.path(), "enzyme.csv", &enzyme());
    let model = folder.path().join("model.json");
    let ask = "implicit {} --states x --trajectory run --model {}";
    let text = says(&words(ask, &[&data, &model]));
    assert!(
        text.starts_with("x' = (0.60000 - 3.0000*x)/(1 + 3.3333*x)\n"),
        "{text}"
    );
    assert!(text.contains("x, below  x"), "{text}");
    assert!(text.contains("relations of x"), "{text}");

    let object = json(0, &words(ask, &[&data, &model]));
    let below = &object["equations"]["x"]["denominator"];
    assert_eq!(below[0]["term"], "1");
    assert!(below[0]["std_error"].is_null());
    // Six digits of the states are believed: the standard error is some 1e-5 of the coefficient.
    assert!(
        (number(&below[1]["coefficient"]) / (10.0 / 3.0) - 1.0).abs() < 1e-4,
        "{below}"
    );
    assert!(number(&below[1]["std_error"]) > 0.0);
    assert_eq!(object["warnings"].as_array().unwrap().len(), 0, "{object}");

    // To the state of rest, 0.6 (0.3 + x) = 1.5 x, of which a deviation falls with e^-3: below 1e-6 after 20 units of time.
    let ask = "simulate {} --start x=1.5 --until 20 --step 0.5 --output -";
    let run = says(&words(ask, &[&model]));
    let last = run.lines().last().unwrap().split(',').nth(1).unwrap();
    assert!((last.parse::<f64>().unwrap() - 0.2).abs() < 1e-4, "{last}");
}

#[test]
fn prop_bad_candidates_are_named() {
    let folder = TempDir::new().unwrap();
    let data = write(folder.path(), "enzyme.csv", &enzyme());
    let ask = |rest: &str| words(&format!("implicit {{}} --trajectory run {rest}"), &[&data]);
    let error = fails(2, &ask("--states x --denominator poly(z)"));
    assert!(error.contains("--denominator"), "{error}");
    let error = fails(2, &ask("--states x,x"));
    assert!(error.contains("stands twice"), "{error}");
    let error = fails(2, &ask("--states y"));
    assert!(error.contains('y'), "{error}");
    let mut args = ask("--states x --known");
    args.push("x' = 1 + ...".into());
    let error = fails(2, &args);
    assert!(error.contains("whole equations"), "{error}");
}
