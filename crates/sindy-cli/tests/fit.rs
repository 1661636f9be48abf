//! `sindy fit` as a command, on files that the tests write.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{csv, fails, json, number, run, says, text, words, write};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::Value;
use sindy::problems::{self, Problem, Record};

/// A problem's records with noise in percent, at most so many rows each.
fn records(problem: &Problem, percent: f64, rows: usize) -> Vec<Record> {
    let mut records = problem.noisy(percent, 7).unwrap();
    for record in &mut records {
        record.time.truncate(rows);
        for column in record.states.iter_mut().chain(&mut record.inputs) {
            column.truncate(rows);
        }
    }
    records
}

fn table(problem: &Problem, record: &Record) -> String {
    let names = problem.states.iter().chain(&problem.inputs);
    let header: Vec<&str> = std::iter::once("t").chain(names.copied()).collect();
    csv(&header.join(","), record.time.len(), |i| {
        let columns = record.states.iter().chain(&record.inputs);
        std::iter::once(record.time[i])
            .chain(columns.map(|c| c[i]))
            .collect()
    })
}

/// Terms and coefficients of an equation in an object.
fn equation(object: &Value, state: &str) -> Vec<(String, f64)> {
    let terms = object["equations"][state].as_array().unwrap();
    terms
        .iter()
        .map(|t| {
            (
                t["term"].as_str().unwrap().to_owned(),
                number(&t["coefficient"]),
            )
        })
        .collect()
}

/// The equations of an object are those of the problem, coefficients within a part of the largest of each equation.
#[track_caller]
fn assert_found(object: &Value, problem: &Problem, tolerance: f64) {
    for (state, truth) in problem.states.iter().zip(&problem.truth) {
        let mut found = equation(object, state);
        let mut truth = truth.clone();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        truth.sort_by(|a, b| a.0.cmp(b.0));
        let names: Vec<&str> = found.iter().map(|(n, _)| n.as_str()).collect();
        let expected: Vec<&str> = truth.iter().map(|(n, _)| *n).collect();
        assert_eq!(names, expected, "{object:#}");
        let largest = truth.iter().fold(0.0_f64, |m, (_, c)| m.max(c.abs()));
        for ((name, found), (_, truth)) in found.iter().zip(&truth) {
            assert!(
                (found - truth).abs() <= tolerance * largest,
                "{name} of {state}: {found}, not {truth}"
            );
        }
    }
}

fn lotka_volterra(folder: &Path) -> PathBuf {
    let problem = problems::lotka_volterra();
    let record = &records(&problem, 1.0, 1500)[0];
    write(folder, "foxes.csv", &table(&problem, record))
}

#[test]
fn analytic_lotka_volterra_with_nothing_but_its_states() {
    let folder = tempfile::tempdir().unwrap();
    let data = lotka_volterra(folder.path());
    let object = json(0, &words("fit {} --states x,y", &[&data]));
    // 1 % of noise on 1500 samples leaves the coefficients uncertain by parts in a thousand.
    assert_found(&object, &problems::lotka_volterra(), 0.02);
    for state in ["x", "y"] {
        for term in object["equations"][state].as_array().unwrap() {
            assert!(
                number(&term["std_error"]) > 0.0 && number(&term["std_error"]) < 0.1,
                "{term}"
            );
            assert!((0.0..=1.0).contains(&number(&term["inclusion"])), "{term}");
        }
    }
    for key in ["method", "smoothing", "reason"] {
        assert!(!object["choice"][key].is_null(), "{key}: {object:#}");
    }
    assert!(object["outcome"].is_string() && object["warnings"].is_array());
    assert_eq!(object["data"]["rows"], 1500);
}

#[test]
fn prop_people_read_equations_front_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let data = lotka_volterra(folder.path());
    let output = run(words("fit {} --states x,y", &[&data]));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for part in [
        "x' =",
        "y' =",
        "x*y",
        "±",
        "terms",
        "error",
        "<- chosen",
        "output error:",
        "1500 rows",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // Standard error is no terminal here: no progress, no control characters.
    assert!(!text(&output.stderr).contains('\u{1b}'));
}

#[test]
fn prop_the_same_data_in_three_formats_give_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let problem = problems::van_der_pol();
    let record = &records(&problem, 1.0, 1200)[0];
    let text = write(folder.path(), "a.csv", &table(&problem, record));
    let columns: Vec<&Vec<f64>> = std::iter::once(&record.time)
        .chain(&record.states)
        .collect();

    let parquet = folder.path().join("a.parquet");
    let schema = "message rows { required double t; required double x; required double y; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = File::create(&parquet).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    for rows in [0..700, 700..1200] {
        let mut group = writer.next_row_group().unwrap();
        for column in &columns {
            let mut out = group.next_column().unwrap().unwrap();
            let values = &column[rows.clone()];
            out.typed::<DoubleType>()
                .write_batch(values, None, None)
                .unwrap();
            out.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();

    let npy = folder.path().join("a.npy");
    let mut file = File::create(&npy).unwrap();
    {
        use npyz::WriterBuilder as _;
        let options = npyz::WriteOptions::new().default_dtype().shape(&[1200, 3]);
        let mut writer = options.writer(&mut file).begin_nd().unwrap();
        for i in 0..1200 {
            writer.extend(columns.iter().map(|c| c[i])).unwrap();
        }
        writer.finish().unwrap();
    }
    let of_csv = json(0, &words("fit {} --states x,y", &[&text]));
    let of_parquet = json(0, &words("fit {} --states x,y", &[&parquet]));
    let of_npy = json(0, &words("fit {} --columns t,x,y --states x,y", &[&npy]));
    assert_found(&of_csv, &problem, 0.02);
    assert_eq!(of_csv["equations"], of_parquet["equations"]);
    assert_eq!(of_csv["equations"], of_npy["equations"]);
}

#[test]
fn prop_several_files_or_one_file_with_a_column_of_labels() {
    let folder = tempfile::tempdir().unwrap();
    let problem = problems::damped_oscillator();
    let record = &records(&problem, 0.5, usize::MAX)[0];
    let half = record.time.len() / 2;
    let whole = table(&problem, record);
    let rows: Vec<&str> = whole.lines().skip(1).collect();
    let header = whole.lines().next().unwrap();
    let part = |rows: &[&str]| format!("{header}\n{}\n", rows.join("\n"));
    let first = write(folder.path(), "first.csv", &part(&rows[..half]));
    let second = write(folder.path(), "second.csv", &part(&rows[half..]));
    let labelled: Vec<String> = rows
        .iter()
        .enumerate()
        .map(|(i, row)| format!("{},{row}", if i < half { "left" } else { "right" }))
        .collect();
    let labelled = format!("side,{header}\n{}\n", labelled.join("\n"));
    let both = write(folder.path(), "both.csv", &labelled);
    let states = problem.states.join(",");
    let files = json(
        0,
        &words(
            &format!("fit {{}} {{}} --states {states}"),
            &[&first, &second],
        ),
    );
    let column = json(
        0,
        &words(
            &format!("fit {{}} --trajectory side --states {states}"),
            &[&both],
        ),
    );
    assert_eq!(files["data"]["trajectories"], 2);
    assert_eq!(files["equations"], column["equations"]);
}

#[test]
fn prop_parquet_with_labels_of_text() {
    let folder = tempfile::tempdir().unwrap();
    let problem = problems::lotka_volterra();
    let record = &records(&problem, 1.0, 1000)[0];
    let path = folder.path().join("runs.parquet");
    let schema = "message rows { required binary run (UTF8); required double t; required double x; required double y; }";
    let file = File::create(&path).unwrap();
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let labels: Vec<ByteArray> = (0..1000)
        .map(|i| ByteArray::from(if i < 500 { "one" } else { "two" }))
        .collect();
    let mut out = group.next_column().unwrap().unwrap();
    out.typed::<ByteArrayType>()
        .write_batch(&labels, None, None)
        .unwrap();
    out.close().unwrap();
    for column in std::iter::once(&record.time).chain(&record.states) {
        let mut out = group.next_column().unwrap().unwrap();
        out.typed::<DoubleType>()
            .write_batch(column, None, None)
            .unwrap();
        out.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    let object = json(0, &words("fit {} --trajectory run --states x,y", &[&path]));
    assert_eq!(object["data"]["trajectories"], 2);
    assert!(
        object["data"]["files"][0]["trajectories"][1]
            .as_str()
            .unwrap()
            .ends_with(", two")
    );
}

#[test]
fn analytic_inputs_test_model_and_figures() {
    let folder = tempfile::tempdir().unwrap();
    let problem = problems::duffing();
    let record = &records(&problem, 0.2, usize::MAX)[0];
    let cut = record.time.len() * 3 / 4;
    let whole = table(&problem, record);
    let rows: Vec<&str> = whole.lines().collect();
    let train = write(folder.path(), "train.csv", &rows[..cut].join("\n"));
    let test = [&rows[..1], &rows[cut..]].concat().join("\n");
    let test = write(folder.path(), "test.csv", &test);
    let model = folder.path().join("out/model.json");
    let (states, inputs) = (problem.states.join(","), problem.inputs.join(","));
    let args = format!(
        "fit {{}} --states {states} --inputs {inputs} --test {{}} --model {{}} --figure {{}}"
    );
    for ending in ["svg", "png", "html"] {
        let figure = folder.path().join(format!("fit.{ending}"));
        let object = json(0, &words(&args, &[&train, &test, &model, &figure]));
        assert_found(&object, &problem, 0.05);
        let derivative = &object["test"]["derivative"];
        for state in &problem.states {
            assert!(number(&derivative[state]["relative"]) < 0.2, "{object:#}");
        }
        let free = &object["test"]["free_run"][0];
        assert_eq!(free["outcome"], "finished");
        assert!(
            number(&free["valid_time"]) > 0.1 * number(&free["length"]),
            "{free:#}"
        );
        let bytes = std::fs::read(&figure).unwrap();
        assert!((1000..1_700_000).contains(&bytes.len()), "{}", bytes.len());
        if ending == "html" {
            let page = String::from_utf8(bytes).unwrap();
            let at = |part: &str| page.find(part).unwrap();
            assert!(at("class=\"verdict") < at("<figure class=\"chart\""));
            assert!(at("<figure class=\"chart\"") < at("<h2"));
        }
    }
    // The model's file runs.
    let args = words("simulate {} --data {}", &[&model, &test]);
    assert!(says(&args).contains("finished"));
}

#[test]
fn prop_terms_come_from_libraries_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let data = lotka_volterra(folder.path());
    let terms = write(
        folder.path(),
        "terms.txt",
        "# prey and predator\nx\n\ny\nx*y  # meetings\n",
    );
    let object = json(
        0,
        &words("fit {} --states x,y --terms {}", &[&data, &terms]),
    );
    assert_found(&object, &problems::lotka_volterra(), 0.02);
    // A library without the product cannot hold the truth.
    let object = json(0, &words("fit {} --states x,y --library poly(1)", &[&data]));
    let found = equation(&object, "x");
    assert!(
        found
            .iter()
            .all(|(name, _)| ["1", "x", "y"].contains(&name.as_str())),
        "{found:?}"
    );
    let bad = write(folder.path(), "bad.txt", "x\nx**y\n");
    let error = fails(2, &words("fit {} --states x,y --terms {}", &[&data, &bad]));
    assert!(error.contains("bad.txt, line 2"), "{error}");
    let empty = write(folder.path(), "empty.txt", "# nothing\n");
    let error = fails(
        2,
        &words("fit {} --states x,y --terms {}", &[&data, &empty]),
    );
    assert!(error.contains("expected a term on each line"), "{error}");
    for library in ["poly(3", "poly(-1)", "sin(w)", "poly(99)"] {
        let error = fails(
            2,
            &words(
                &format!("fit {{}} --states x,y --library {library}"),
                &[&data],
            ),
        );
        assert!(error.contains("--library"), "{library}: {error}");
    }
}

#[test]
fn prop_same_data_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let data = lotka_volterra(folder.path());
    let args = words("fit {} --states x,y --json", &[&data]);
    assert_eq!(run(&args).stdout, run(&args).stdout);
}

#[test]
fn analytic_discrete_time() {
    let folder = tempfile::tempdir().unwrap();
    // The logistic map, chaotic at 3.9.
    let mut x = 0.3;
    let mut rows = String::from("t,x\n");
    for k in 0..300 {
        rows.push_str(&format!("{k},{x}\n"));
        x = 3.9 * x * (1.0 - x);
    }
    let data = write(folder.path(), "map.csv", &rows);
    let model = folder.path().join("map.json");
    let object = json(
        0,
        &words("fit {} --states x --discrete --model {}", &[&data, &model]),
    );
    let found = equation(&object, "x");
    let names: Vec<&str> = found.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(names, ["x", "x^2"], "{object:#}");
    // Data without noise to 16 digits.
    assert!((found[0].1 - 3.9).abs() < 1e-9 && (found[1].1 + 3.9).abs() < 1e-9);
    let run = says(&words(
        "simulate {} --start x=0.5 --until 1 --output -",
        &[&model],
    ));
    let next: f64 = run
        .lines()
        .nth(2)
        .unwrap()
        .split(',')
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    assert!((next - 0.975).abs() < 1e-8, "{run}");
}

#[test]
fn prop_settings_print_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let printed = says(&words("settings", &[]));
    let defaults = write(folder.path(), "defaults.toml", &printed);
    let data = lotka_volterra(folder.path());
    let with = json(
        0,
        &words("fit {} --states x,y --settings {}", &[&data, &defaults]),
    );
    let without = json(0, &words("fit {} --states x,y", &[&data]));
    assert_eq!(with, without, "the printed settings are the defaults");
    let changed = write(
        folder.path(),
        "changed.toml",
        "library = { x = [\"x\", \"x*y\"], y = \"poly(2)\" }\n[identify]\nmethod = \"regression\"\nsmoothing = \"spline\"\n",
    );
    let object = json(
        0,
        &words("fit {} --states x,y --settings {}", &[&data, &changed]),
    );
    assert_ne!(object["choice"]["method"], "output_error");
    assert!(
        object["choice"]["smoothing"]
            .as_str()
            .unwrap()
            .contains("spline"),
        "{object:#}"
    );
    assert!(
        equation(&object, "x")
            .iter()
            .all(|(n, _)| n == "x" || n == "x*y")
    );
}

#[test]
fn prop_weights_set_rows_aside() {
    let folder = tempfile::tempdir().unwrap();
    let problem = problems::lotka_volterra();
    let record = &records(&problem, 1.0, 1500)[0];
    let rows = csv("t,x,y,w", 1500, |i| {
        vec![
            record.time[i],
            record.states[0][i],
            record.states[1][i],
            1.0,
        ]
    });
    let data = write(folder.path(), "a.csv", &rows);
    let object = json(0, &words("fit {} --states x,y --weights w", &[&data]));
    assert_found(&object, &problem, 0.02);
}

#[test]
fn prop_the_usual_names_of_time_are_known_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let table = |header: &str| {
        csv(header, 200, |i| {
            let t = 0.05 * i as f64;
            vec![t, t.sin(), t.cos(), 100.0 + t]
        })
    };
    for (header, taken) in [
        ("t_s,x,y,z", "t_s"),
        ("Timestamp [s],x,y,z", "Timestamp [s]"),
        // A stamp of another clock beside a time of the usual name is only a column.
        ("time,x,y,timestamp", "time"),
        ("time_s,x,y,t_s", "time_s"),
    ] {
        let data = write(folder.path(), "a.csv", &table(header));
        let args = words("fit {} --states x,y --library poly(1) --quiet", &[&data]);
        assert_eq!(json(0, &args)["data"]["files"][0]["time"], taken);
        let said = says(&args);
        assert!(said.contains(&format!("time from `{taken}`")), "{said}");
    }
    let data = write(folder.path(), "a.csv", &table("t_s,x,y,timestamp"));
    let error = fails(2, &words("fit {} --states x,y", &[&data]));
    assert!(
        error.contains("t_s and timestamp") && error.contains("--time"),
        "{error}"
    );
}

#[test]
fn prop_text_counts_and_rounds_as_people_do() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(
        folder.path(),
        "a.csv",
        &csv("t,x", 200, |i| {
            let t = 0.05 * i as f64;
            vec![t, (-0.5 * t).exp()]
        }),
    );
    let output = run(words("fit {} --states x --library poly(1)", &[&data]));
    let (said, error) = (text(&output.stdout), text(&output.stderr));
    assert!(
        said.contains("1 term leaves less than 0.01 times"),
        "{said}"
    );
    assert!(said.contains("over 1 arc of"), "{said}");
    // Without noise, what is left is rounding: it is no reason to doubt the errors.
    assert!(!error.contains("correlated"), "{error}");
}
