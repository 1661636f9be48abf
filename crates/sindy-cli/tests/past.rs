//! Past states as candidates: `sindy fit --past`, and running what it finds.

use crate::common::{csv, fails, json, number, says, words, write};
use serde_json::Value;

fn coefficients(object: &Value, state: &str) -> Vec<(String, f64)> {
    let terms = object["equations"][state].as_array().unwrap();
    let pair = |t: &Value| {
        (
            t["term"].as_str().unwrap().to_owned(),
            number(&t["coefficient"]),
        )
    };
    let mut all: Vec<(String, f64)> = terms.iter().map(pair).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

#[track_caller]
fn assert_close(found: &[(String, f64)], truth: &[(&str, f64)], tolerance: f64) {
    let names: Vec<&str> = found.iter().map(|f| f.0.as_str()).collect();
    let expected: Vec<&str> = truth.iter().map(|t| t.0).collect();
    assert_eq!(names, expected, "{found:?}");
    for ((name, found), (_, truth)) in found.iter().zip(truth) {
        assert!(
            (found - truth).abs() < tolerance,
            "{name}: {found}, not {truth}"
        );
    }
}

/// The Hénon map as one equation: x[k+1] = 1 - 1.4 x[k]^2 + 0.3 x[k-1].
fn henon(rows: usize) -> Vec<f64> {
    let mut x = vec![0.3, 0.2];
    for k in 1..rows - 1 {
        x.push(1.0 - 1.4 * x[k] * x[k] + 0.3 * x[k - 1]);
    }
    x
}

#[test]
fn analytic_a_map_of_second_order_is_found_and_run() {
    let folder = tempfile::tempdir().unwrap();
    let x = henon(400);
    let data = write(
        folder.path(),
        "henon.csv",
        &csv("t,x", 400, |i| vec![i as f64, x[i]]),
    );
    let model = folder.path().join("model.json");
    let object = json(
        0,
        &words(
            "fit {} --states x --discrete --past x@1 --test {} --model {}",
            &[&data, &data, &model],
        ),
    );
    let truth = [("1", 1.0), ("x^2", -1.4), ("x_ago1", 0.3)];
    assert_close(&coefficients(&object, "x"), &truth, 1e-9);
    assert_close(&coefficients(&object, "x_ago1"), &[("x", 1.0)], 1e-15);
    assert!(
        number(&object["test"]["derivative"]["x"]["rmse"]) < 1e-9,
        "{object:#}"
    );
    // Beside the data, the start's past comes from the rows before; alone, from the argument.
    let beside = json(0, &words("simulate {} --data {}", &[&model, &data]));
    assert_eq!(beside["runs"][0]["rows"], 399);
    let out = folder.path().join("run.csv");
    says(&words(
        "simulate {} --start x=0.2,x_ago1=0.3 --until 10 --output {} --quiet",
        &[&model, &out],
    ));
    let table = std::fs::read_to_string(out).unwrap();
    let last: Vec<f64> = table
        .lines()
        .last()
        .unwrap()
        .split(',')
        .map(|c| c.parse().unwrap())
        .collect();
    assert!((last[1] - x[11]).abs() < 1e-6, "{last:?}, {}", x[11]);
}

/// Hutchinson's equation x' = 1.5 x (1 - x(t - 1.2)), x = 0.5 before 0, by the method of steps with Runge-Kutta steps
/// of `h` (a whole number of them in the delay): rows `every` steps apart.
fn hutchinson(h: f64, rows: usize, every: usize) -> Vec<f64> {
    let back = (1.2 / h).round() as usize;
    let mut x = vec![0.5; back + 1];
    let f = |x: f64, past: f64| 1.5 * x * (1.0 - past);
    while x.len() < back + 1 + rows * every {
        let k = x.len() - 1;
        let (a, c) = (x[k - back], x[k - back + 1]);
        let b = match k > back {
            true => (9.0 * (a + c) - x[k - back - 1] - x[k - back + 2]) / 16.0,
            false => 0.5 * (a + c),
        };
        let k1 = f(x[k], a);
        let k2 = f(x[k] + 0.5 * h * k1, b);
        let k3 = f(x[k] + 0.5 * h * k2, b);
        let k4 = f(x[k] + h * k3, c);
        x.push(x[k] + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
    }
    x[back..]
        .iter()
        .step_by(every)
        .copied()
        .take(rows)
        .collect()
}

#[test]
fn analytic_a_delay_in_time_is_found_and_run() {
    let folder = tempfile::tempdir().unwrap();
    let x = hutchinson(0.01, 600, 4);
    let table = csv("t,x", 600, |i| vec![0.04 * i as f64, x[i]]);
    let data = write(folder.path(), "a.csv", &table);
    let model = folder.path().join("model.json");
    let figure = folder.path().join("fit.html");
    let object = json(
        0,
        &words(
            "fit {} --states x --past x@1.2s --library poly(2) --test {} --model {} --figure {}",
            &[&data, &data, &model, &figure],
        ),
    );
    // Thirty rows of 0.04.
    let truth = [("x", 1.5), ("x*x_ago30", -1.5)];
    assert_close(&coefficients(&object, "x"), &truth, 1e-3);
    let free = &object["test"]["free_run"][0];
    // The run feeds itself, from the first row that has a past to the end: an error of the delayed state would grow.
    assert!(
        (number(&free["length"]) - (599.0 - 30.0) * 0.04).abs() < 1e-9,
        "{free:#}"
    );
    assert!(number(&free["rmse"]["x"]) < 2e-3, "{free:#}");
    assert!(figure.exists());
    // From a constant past, as the data were made.
    let out = folder.path().join("run.csv");
    let said = says(&words(
        "simulate {} --start x=0.5 --until 20 --step 0.04 --output {} --quiet",
        &[&model, &out],
    ));
    assert!(said.contains("where x_ago30 is x(t - 1.2"), "{said}");
    let table = std::fs::read_to_string(&out).unwrap();
    for (row, line) in table.lines().skip(1).enumerate() {
        let found: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        // Coefficients of the fit are good to 1e-4; over three periods that shifts the phase by as much.
        assert!((found - x[row]).abs() < 5e-3, "{row}: {found} {}", x[row]);
    }
}

#[test]
fn prop_pasts_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let x = henon(100);
    let data = write(
        folder.path(),
        "a.csv",
        &csv("t,x", 100, |i| vec![0.1 * i as f64, x[i]]),
    );
    for (options, part) in [
        ("--past w@1", "found `w`"),
        ("--past x", "a delay such as"),
        ("--past x@0", "--past"),
        ("--past x@0.25s", "a whole number of periods"),
        ("--past x@1,x@1", "x_ago1"),
        ("--past x@200", "too few samples"),
        ("--past x@1 --stream", "--stream"),
    ] {
        let args = words(
            &format!("fit {{}} --states x --discrete {options}"),
            &[&data],
        );
        let error = fails(2, &args);
        assert!(error.contains(part), "{options}: {error}");
    }
}
