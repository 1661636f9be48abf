//! `sindy simulate` as a command.

use std::path::{Path, PathBuf};

use crate::common::{csv, fails, files, json, number, run, says, text, words, write};

/// A model file of one state `x` from its equation as JSON.
fn model(folder: &Path, inputs: &str, equations: &str) -> PathBuf {
    let text = format!(
        r#"{{ "schema": 1, "time": "continuous", "states": ["x"], "inputs": [{inputs}], "equations": {{ {equations} }} }}"#
    );
    write(folder, "model.json", &text)
}

/// x' = -2 x.
fn decay(folder: &Path) -> PathBuf {
    model(
        folder,
        "",
        r#""x": [ { "term": "x", "coefficient": -2.0 } ]"#,
    )
}

/// x' = u.
fn integrator(folder: &Path) -> PathBuf {
    model(
        folder,
        r#""u""#,
        r#""x": [ { "term": "u", "coefficient": 1.0 } ]"#,
    )
}

#[test]
fn analytic_decay_from_a_start() {
    let folder = tempfile::tempdir().unwrap();
    let model = decay(folder.path());
    let out = folder.path().join("runs/run.csv");
    let args = words(
        "simulate {} --start x=3 --until 1 --step 0.1 --output {}",
        &[&model, &out],
    );
    let object = json(0, &args);
    let run = &object["runs"][0];
    assert_eq!(run["outcome"], "finished");
    assert_eq!(run["rows"], 11);
    // The relative tolerance of the integrator is 1e-8.
    let expected = 3.0 * (-2.0_f64).exp();
    assert!(
        (number(&run["final"]["x"]) / expected - 1.0).abs() < 1e-7,
        "{run}"
    );
    assert!(run.get("rmse").is_none(), "nothing was measured");
    let table = std::fs::read_to_string(&out).unwrap();
    assert_eq!(table.lines().next(), Some("t,x"));
    assert_eq!(table.lines().nth(1), Some("0,3"));
    assert_eq!(table.lines().count(), 12);
}

#[test]
fn analytic_inputs_as_formulas_and_as_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let model = integrator(folder.path());
    let mut args = words("simulate {} --start x=0 --until 1", &[&model]);
    args.extend(["--input".into(), "u = 2*t".into()]);
    let end = |object: serde_json::Value| number(&object["runs"][0]["final"]["x"]);
    // The integral of 2 t is t^2; the method is exact for polynomials of this degree.
    assert!((end(json(0, &args)) - 1.0).abs() < 1e-12);

    let table = csv("time (s),u (N)", 11, |i| {
        let t = 5.0 + 0.1 * i as f64;
        vec![t, f64::from(u8::from(i < 5))]
    });
    let inputs = write(folder.path(), "inputs.csv", &table);
    let base = "simulate {} --start x=0 --inputs-from {} --between";
    // 1 for half a second; a line falls from 1 to 0 between the samples at 5.4 and 5.5 s.
    for (how, expected) in [("hold", 0.5), ("linear", 0.45)] {
        let args = words(&format!("{base} {how}"), &[&model, &inputs]);
        assert!((end(json(0, &args)) - expected).abs() < 1e-9, "{how}");
    }
}

#[test]
fn analytic_beside_measured_trajectories() {
    let folder = tempfile::tempdir().unwrap();
    let model = decay(folder.path());
    // Two runs told apart by text, measured 1 too high after the start of the second.
    let mut table = String::from("run,t,x\n");
    for i in 0..50 {
        let t = 0.02 * f64::from(i);
        let x = (-2.0 * t).exp();
        table.push_str(&format!("up,{t},{x}\n"));
        let high = if i == 0 { x } else { x + 1.0 };
        table.push_str(&format!("down,{t},{high}\n"));
    }
    let data = write(folder.path(), "data.csv", &table);
    let figure = folder.path().join("figure.svg");
    let args = words(
        "simulate {} --data {} --trajectory run --figure {}",
        &[&model, &data, &figure],
    );
    let object = json(0, &args);
    let runs = object["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    assert!(runs[0]["name"].as_str().unwrap().ends_with("data.csv, up"));
    assert!(number(&runs[0]["rmse"]["x"]) < 1e-7, "{object}");
    let expected = (49.0_f64 / 50.0).sqrt();
    assert!(
        (number(&runs[1]["rmse"]["x"]) - expected).abs() < 1e-6,
        "{object}"
    );
    assert!(number(&runs[1]["relative"]["x"]) > 1.0);
    let svg = std::fs::read_to_string(&figure).unwrap();
    assert!(svg.starts_with("<svg"));
    let page = folder.path().join("figure.html");
    let args = words(
        "simulate {} --data {} --trajectory run --figure {}",
        &[&model, &data, &page],
    );
    assert!(says(&args).contains("RMSE"));
    let page = std::fs::read_to_string(&page).unwrap();
    assert!(page.contains("Figure 2"), "every run is on the page");
    // The second run is more than a standard deviation off.
    let at = |part: &str| page.find(part).unwrap_or_else(|| panic!("{part}"));
    assert!(at("class=\"verdict warning\"") < at("<figure class=\"chart\""));
    assert!(at("<figure class=\"chart\"") < at("<h2"));
    assert!(page.len() < 1_700_000, "{}", page.len());
}

#[test]
fn prop_gaps_split_and_blow_ups_are_outcomes() {
    let folder = tempfile::tempdir().unwrap();
    let model = model(
        folder.path(),
        "",
        r#""x": [ { "term": "x^2", "coefficient": 1.0 } ]"#,
    );
    // x = 1/(1 - t) is infinite at t = 1.
    let args = words("simulate {} --start x=1 --until 2", &[&model]);
    let object = json(0, &args);
    assert_eq!(object["runs"][0]["outcome"], "blew_up");
    // Near the pole the run crosses 1e12, at a time within the tolerance of the integrator.
    assert!(number(&object["runs"][0]["end"]) < 1.001);
    let warning = object["warnings"][0].as_str().unwrap();
    assert!(warning.contains("blew up at time 1"), "{warning}");

    let rows = csv("t,x", 40, |i| {
        vec![0.01 * i as f64, 1.0 / (1.0 - 0.01 * i as f64)]
    });
    let rows: Vec<&str> = rows.lines().collect();
    let table = [&rows[..11], &["0.1,"], &rows[12..]].concat().join("\n");
    let data = write(folder.path(), "gap.csv", &table);
    let object = json(0, &words("simulate {} --data {}", &[&model, &data]));
    let runs = object["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    assert_eq!(
        (&runs[0]["rows"], &runs[1]["rows"]),
        (&10.into(), &29.into())
    );
    assert!(
        runs.iter().all(|r| number(&r["rmse"]["x"]) < 1e-7),
        "{object}"
    );
    assert!(
        object["warnings"][0]
            .as_str()
            .unwrap()
            .contains("gaps split")
    );
}

#[test]
fn analytic_discrete_models_step_by_their_period() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(
        folder.path(),
        "discrete.json",
        r#"{ "schema": 1, "time": { "discrete": { "period": 0.5 } }, "states": ["x"], "inputs": ["u"],
             "equations": { "x": [ { "term": "x", "coefficient": 0.5 }, { "term": "u", "coefficient": 1.0 } ] } }"#,
    );
    let mut args = words("simulate {} --start x=8 --until 1.5 --output -", &[&path]);
    args.extend(["--input".into(), "u=t".into()]);
    assert_eq!(says(&args), "t,x\n0,8\n0.5,4\n1,2.5\n1.5,2.25\n");
    let wrong = words(
        "simulate {} --start x=8 --until 1.5 --input u=0 --step 0.1",
        &[&path],
    );
    assert!(fails(2, &wrong).contains("period 0.5"));
    let data = write(folder.path(), "data.csv", "t,x,u\n0,8,1\n0.25,5,1\n");
    let error = fails(2, &words("simulate {} --data {}", &[&path, &data]));
    assert!(
        error.contains("rows 0.5 apart") && error.contains("0.25"),
        "{error}"
    );
}

#[test]
fn prop_bad_arguments_teach_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let model = decay(folder.path());
    let driven = folder.path().join("driven");
    std::fs::create_dir(&driven).unwrap();
    let driven = integrator(&driven);
    let out = folder.path().join("run.csv");
    let data = write(folder.path(), "data.csv", "t,y\n0,1\n1,2\n");
    let before = files(folder.path());
    for (args, says) in [
        ("--start x=1 --output {}", "--until"),
        (
            "--start y=1 --until 1 --output {}",
            "no `y` in the model; it has x",
        ),
        (
            "--start x=one --until 1 --output {}",
            "finite number, found \"one\"",
        ),
        ("--start x=1,x=2 --until 1 --output {}", "stands twice"),
        (
            "--start x=1 --until 1 --step 1e-12 --output {}",
            "found 1e12",
        ),
        (
            "--start x=1 --until 1 --input u=1 --output {}",
            "no `u` in the model; it has none",
        ),
        ("--start x=1 --until -1 --output {}", "positive number"),
        ("--output {}", "--data"),
    ] {
        let error = fails(2, &words(&format!("simulate {{}} {args}"), &[&model, &out]));
        assert!(error.contains(says), "{args}: {error}");
    }
    let error = fails(2, &words("simulate {} --start x=1 --until 1", &[&driven]));
    assert!(error.contains("found none for `u`"), "{error}");
    let error = fails(2, &words("simulate {} --data {}", &[&model, &data]));
    assert!(
        error.contains("a column `x` (a state of the model)") && error.contains("t, y"),
        "{error}"
    );
    let pdf = folder.path().join("run.pdf");
    let args = words(
        "simulate {} --start x=1 --until 1 --figure {}",
        &[&model, &pdf],
    );
    let error = fails(2, &args);
    assert!(error.contains(".svg, .png or .html"), "{error}");
    let missing = folder.path().join("missing.json");
    fails(2, &words("simulate {} --start x=1 --until 1", &[&missing]));
    let error = fails(2, &words("simulate {} --start x=1 --until 1", &[&data]));
    assert!(error.contains("model in JSON"), "{error}");
    assert_eq!(files(folder.path()), before);
}

#[test]
fn prop_corrupt_rows_are_a_loss() {
    let folder = tempfile::tempdir().unwrap();
    let model = decay(folder.path());
    let rows = csv("t,x", 30, |i| {
        let t = 0.1 * i as f64;
        vec![t, (-2.0 * t).exp()]
    });
    let data = write(
        folder.path(),
        "data.csv",
        &rows.replace("\n0.5,", "\n0.5,7,"),
    );
    let output = run(words("simulate {} --data {}", &[&model, &data]));
    assert_eq!(output.status.code(), Some(3));
    let error = text(&output.stderr);
    assert!(
        error.contains("warning: ") && error.contains("line 7: expected 2 cells, found 3"),
        "{error}"
    );
}
