//! `sindy fit --stream`: the same terms as in memory, in one pass over files of several formats.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{fails, json, number, run, text, words, write};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::Value;
use sindy::problems;

/// Noisy Lotka-Volterra: times, then states, of a few trajectories behind each other.
fn foxes() -> Vec<Vec<f64>> {
    let record = &problems::lotka_volterra().noisy(1.0, 7).unwrap()[0];
    std::iter::once(&record.time)
        .chain(&record.states)
        .cloned()
        .collect()
}

/// A table of labels and numbers in row groups of so many rows.
fn parquet(folder: &Path, columns: &[Vec<f64>], labels: &[&str], group: usize) -> PathBuf {
    let path = folder.join("rows.parquet");
    let schema = "message rows { required binary run (UTF8); required double t; required double x; optional double y; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let n = labels.len();
    for start in (0..n).step_by(group) {
        let rows = start..n.min(start + group);
        let mut out = writer.next_row_group().unwrap();
        let texts: Vec<ByteArray> = labels[rows.clone()].iter().map(|l| (*l).into()).collect();
        let mut next = out.next_column().unwrap().unwrap();
        next.typed::<ByteArrayType>()
            .write_batch(&texts, None, None)
            .unwrap();
        next.close().unwrap();
        for (k, column) in columns.iter().enumerate() {
            let mut next = out.next_column().unwrap().unwrap();
            let values = &column[rows.clone()];
            let there: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
            let levels: Vec<i16> = values.iter().map(|v| i16::from(!v.is_nan())).collect();
            let (values, levels) = match k {
                2 => (there.as_slice(), Some(levels.as_slice())),
                _ => (values, None),
            };
            next.typed::<DoubleType>()
                .write_batch(values, levels, None)
                .unwrap();
            next.close().unwrap();
        }
        out.close().unwrap();
    }
    writer.close().unwrap();
    path
}

/// A table of text with the columns t, x and y, and labels before them.
fn table(columns: &[Vec<f64>], labels: &[&str]) -> String {
    let mut out = "# made by a test\nrun,t,x,y\n".to_owned();
    for (i, label) in labels.iter().enumerate() {
        let cell = |c: &Vec<f64>| match c[i].is_nan() {
            true => String::new(),
            false => c[i].to_string(),
        };
        let cells: Vec<String> = columns.iter().map(cell).collect();
        out.push_str(&format!("{label},{}\n", cells.join(",")));
    }
    out
}

fn terms(object: &Value, state: &str) -> Vec<String> {
    let terms = object["equations"][state].as_array().unwrap();
    let mut names: Vec<String> = terms
        .iter()
        .map(|t| t["term"].as_str().unwrap().to_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn prop_parquet_of_several_row_groups_gives_the_terms_of_the_fit_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let mut columns = foxes();
    let n = columns[0].len();
    columns[2][n / 3] = f64::NAN;
    let labels: Vec<&str> = (0..n)
        .map(|i| if i < n / 2 { "one" } else { "two" })
        .collect();
    let path = parquet(folder.path(), &columns, &labels, 700);
    let args = "fit {} --states x,y --trajectory run";
    let whole = json(0, &words(args, &[&path]));
    let streamed = json(0, &words(&format!("{args} --stream"), &[&path]));
    for state in ["x", "y"] {
        assert_eq!(
            terms(&streamed, state),
            terms(&whole, state),
            "{streamed:#}"
        );
        assert_eq!(terms(&streamed, state).len(), 2);
        let pairs = streamed["equations"][state].as_array().unwrap().iter();
        for (a, b) in pairs.zip(whole["equations"][state].as_array().unwrap()) {
            let (a, b) = (number(&a["coefficient"]), number(&b["coefficient"]));
            // Regression and output error at 1 % of noise both err by less than a percent or two.
            assert!((a - b).abs() < 0.03, "{a} {b}");
        }
    }
    for key in ["rows", "trajectories", "stretches", "missing_rows"] {
        assert_eq!(streamed["data"][key], whole["data"][key], "{key}");
    }
    let file = &streamed["data"]["files"][0];
    assert_eq!(file["rows_read"], n);
    assert_eq!(file["empty_cells"]["y"], 1);
    assert!(file["trajectories"][1].as_str().unwrap().ends_with(", two"));
    assert!(
        streamed["choice"]["reason"]
            .as_str()
            .unwrap()
            .contains("one pass")
    );
}

#[test]
fn prop_text_and_arrays_stream_as_parquet_does() {
    let folder = tempfile::tempdir().unwrap();
    let columns = foxes();
    let n = columns[0].len();
    let labels = vec!["one"; n];
    let parquet = parquet(folder.path(), &columns, &labels, 1000);
    let csv = write(folder.path(), "rows.csv", &table(&columns, &labels));
    let npy = folder.path().join("rows.npy");
    {
        use npyz::WriterBuilder as _;
        let shape = [n as u64, 3];
        let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
        let mut file = File::create(&npy).unwrap();
        let mut writer = options.writer(&mut file).begin_nd().unwrap();
        for i in 0..n {
            writer.extend(columns.iter().map(|c| c[i])).unwrap();
        }
        writer.finish().unwrap();
    }
    let of_parquet = json(0, &words("fit {} --states x,y --stream", &[&parquet]));
    let of_csv = json(0, &words("fit {} --states x,y --stream", &[&csv]));
    let args = "fit {} --columns t,x,y --states x,y --stream";
    let of_npy = json(0, &words(args, &[&npy]));
    assert_eq!(of_csv["equations"], of_parquet["equations"]);
    assert_eq!(of_csv["equations"], of_npy["equations"]);
}

#[test]
fn prop_text_longer_than_a_part_is_read_to_its_end() {
    // 200 000 rows of more than 50 bytes: three parts of 4 MB. x' = y, y' = -x; corrupt rows in the last part.
    let folder = tempfile::tempdir().unwrap();
    let n = 200_000;
    let time: Vec<f64> = (0..n).map(|i| 0.01 * f64::from(i)).collect();
    let wave = |f: fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    let columns = [time.clone(), wave(f64::sin), wave(f64::cos)];
    let labels = vec!["a run"; time.len()];
    let content = table(&columns, &labels);
    assert!(content.len() > 9 << 20);
    let whole = write(folder.path(), "long.csv", &content);
    let args = "fit {} --states x,y --library poly(2) --stream";
    let object = json(0, &words(args, &[&whole]));
    assert_eq!(object["data"]["rows"], n);
    assert_eq!(
        (terms(&object, "x"), terms(&object, "y")),
        (vec!["y".into()], vec!["x".into()])
    );
    let value = number(&object["equations"]["y"][0]["coefficient"]);
    // Noise-free differences at 600 samples a turn.
    assert!((value + 1.0).abs() < 1e-4, "{value}");

    let cut = content.len() - 60_000;
    let cut = cut + content[cut..].find('\n').unwrap() + 1;
    let broken = format!("{}a run,1\n{}", &content[..cut], &content[cut..]);
    let broken = write(folder.path(), "broken.csv", &broken);
    let object = json(3, &words(args, &[&broken]));
    assert_eq!(object["data"]["rows"], n);
    assert_eq!(object["data"]["files"][0]["rows_dropped"], 1);
    let warning = object["warnings"][0].as_str().unwrap();
    assert!(
        warning.contains("broken.csv") && warning.contains("corrupt"),
        "{warning}"
    );
}

#[test]
fn prop_model_test_and_figure_of_a_stream() {
    let folder = tempfile::tempdir().unwrap();
    let columns = foxes();
    let labels = vec!["one"; columns[0].len()];
    let data = write(folder.path(), "rows.csv", &table(&columns, &labels));
    let (model, figure) = (
        folder.path().join("model.json"),
        folder.path().join("fit.svg"),
    );
    let args = "fit {} --states x,y --stream --test {} --model {} --figure {}";
    let object = json(0, &words(args, &[&data, &data, &model, &figure]));
    assert_eq!(object["test"]["free_run"][0]["outcome"], "finished");
    assert!(model.exists() && figure.exists());
    let front = folder.path().join("front.html");
    let args = "fit {} --states x,y --stream --figure {}";
    json(0, &words(args, &[&data, &front]));
    assert!(front.exists());
}

#[test]
fn prop_what_a_stream_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let columns = foxes();
    let n = columns[0].len();
    let mixed: Vec<&str> = (0..n).map(|i| ["one", "two"][i % 2]).collect();
    let data = write(folder.path(), "mixed.csv", &table(&columns, &mixed));
    let args = "fit {} --states x,y --trajectory run --stream";
    let error = fails(2, &words(args, &[&data]));
    for part in [
        "mixed.csv, data row 3",
        "`run`",
        "sort the table",
        "\"one\" again",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let error = fails(2, &words("fit {} --states x,y,z --stream", &[&data]));
    assert!(error.contains("a column `z` (--states)"), "{error}");

    let mut back = columns.clone();
    back[0].reverse();
    let data = write(folder.path(), "back.csv", &table(&back, &mixed));
    let error = fails(2, &words("fit {} --states x,y --stream", &[&data]));
    assert!(
        error.contains("time that increases") && error.contains("data row 2"),
        "{error}"
    );

    let mut infinite = columns.clone();
    infinite[1][5] = f64::INFINITY;
    let data = write(folder.path(), "infinite.csv", &table(&infinite, &mixed));
    let error = fails(2, &words("fit {} --states x,y --stream", &[&data]));
    assert!(
        error.contains("data row 6, column `x`") && error.contains("inf"),
        "{error}"
    );

    let stamps = "t,x\n2019-11-07 18:45:58,1\n2019-11-07 18:45:59,2\n2019-11-07 18:46:00,3\n";
    let data = write(folder.path(), "stamps.csv", stamps);
    let error = fails(2, &words("fit {} --states x --stream", &[&data]));
    assert!(error.contains("date-time stamps"), "{error}");

    let short = write(folder.path(), "short.csv", "t,x\n0,1\n1,2\n");
    let error = fails(2, &words("fit {} --states x --stream", &[&short]));
    assert!(error.contains("short.csv: too few samples"), "{error}");
    let settings = write(
        folder.path(),
        "s.toml",
        "[identify]\nmethod = \"output_error\"\n",
    );
    let data = write(folder.path(), "rows.csv", &table(&columns, &mixed));
    let args = "fit {} --states x,y --stream --settings {}";
    let error = fails(2, &words(args, &[&data, &settings]));
    assert!(error.contains("`method`"), "{error}");
    assert!(text(&run(["fit", "--help"]).stdout).contains("--stream"));
}
