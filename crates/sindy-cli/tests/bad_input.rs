//! Bad input is one clear error or a stated outcome: never a panic, never a file that is half done.

use crate::common::{csv, fails, files, json, run, says, text, words, write};

/// Fits with every kind of output, expects the status, the words in the error, and that nothing was written.
#[track_caller]
fn refused(status: i32, name: &str, content: &str, options: &str, says: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), name, content);
    let model = folder.path().join("model.json");
    let figure = folder.path().join("figure.svg");
    let args = format!("fit {{}} {options} --model {{}} --figure {{}}");
    let error = fails(status, &words(&args, &[&data, &model, &figure]));
    for part in says {
        assert!(error.contains(part), "expected {part:?} in: {error}");
    }
    assert_eq!(files(folder.path()), [name], "nothing is written");
}

/// A sine and its cosine.
fn waves(rows: usize) -> String {
    csv("t,x,y", rows, |i| {
        let t = 0.05 * i as f64;
        vec![t, t.sin(), t.cos()]
    })
}

#[test]
fn prop_files_without_rows() {
    refused(
        1,
        "empty.csv",
        "",
        "--states x",
        &["empty.csv", "empty file"],
    );
    refused(
        1,
        "header.csv",
        "t,x,y\n",
        "--states x,y",
        &["header.csv", "only a header"],
    );
    let folder = tempfile::tempdir().unwrap();
    let error = fails(
        1,
        &words("fit {} --states x", &[&folder.path().join("none.csv")]),
    );
    assert!(error.contains("none.csv"), "{error}");
    let error = fails(1, &words("fit {} --states x", &[folder.path()]));
    assert!(error.contains(folder.path().to_str().unwrap()), "{error}");
}

#[test]
fn prop_one_or_two_samples() {
    for rows in [1, 2] {
        refused(
            2,
            "short.csv",
            &waves(rows),
            "--states x,y",
            &["short.csv", "at least 3 rows", &format!("found {rows} row")],
        );
    }
}

#[test]
fn prop_tables_that_are_none() {
    let numbers = "0,1,2\n1,2,3\n2,3,4\n";
    // A table without a header is read, with names that its user did not give.
    refused(
        2,
        "bare.csv",
        numbers,
        "--states x",
        &["bare.csv", "c1, c2, c3"],
    );
    refused(
        2,
        "book.xlsx",
        "PK\u{3}\u{4}rest",
        "--states x",
        &["book.xlsx", "ZIP", "CSV"],
    );
    refused(
        1,
        "half.parquet",
        "PAR1 but no more",
        "--states x",
        &["half.parquet"],
    );
    let says = ["text.parquet", "a Parquet file", "found `t,x"];
    refused(2, "text.parquet", "t,x\n0,1\n", "--states x", &says);
}

#[test]
fn prop_names_that_are_not_there() {
    let data = waves(50);
    refused(
        2,
        "a.csv",
        &data,
        "--states x,w",
        &["`w` (--states)", "t, x, y"],
    );
    refused(2, "a.csv", &data, "--states X", &["did you mean `x`?"]);
    let says = ["--time COLUMN", "of which --states takes `t`"];
    refused(2, "a.csv", &data, "--states t,x", &says);
    let says = ["error: --sign: expected an equation", "found `foo`"];
    refused(2, "a.csv", &data, "--states x,y --sign foo", &says);
    refused(
        2,
        "a.csv",
        &data,
        "--states x --inputs w",
        &["`w` (--inputs)"],
    );
    refused(2, "a.csv", &data, "--states x --time s", &["`s` (--time)"]);
    refused(
        2,
        "a.csv",
        &data,
        "--states x --trajectory run",
        &["`run` (--trajectory)"],
    );
    refused(
        2,
        "a.csv",
        &data,
        "--states x --weights w",
        &["`w` (--weights)"],
    );
    refused(
        2,
        "a.csv",
        &data,
        "--states x,y --library sin(w)",
        &["--library", "w"],
    );
    let other = data.replace("t,x", "s,x");
    refused(
        2,
        "a.csv",
        &other,
        "--states x,y",
        &["--time", "--dt", "s, x, y"],
    );
    let both = "t,time,x\n0,0,1\n1,1,2\n";
    refused(2, "a.csv", both, "--states x", &["t and time", "--time"]);
}

#[test]
fn prop_names_that_are_two_things_or_none() {
    let data = waves(50);
    for (options, says) in [
        ("--states x,x", "--states: `x` stands twice"),
        ("--states x --inputs y,y", "--inputs: `y` stands twice"),
        (
            "--states x,y --inputs x",
            "found `x`, which --states names too",
        ),
        ("--states x --weights x", "--weights: expected a column"),
        ("--states x --time x", "--time: expected a column"),
        (
            "--states x --inputs y --trajectory y",
            "which --inputs names too",
        ),
        (
            "--states x,,y",
            "--states <x,y,z>': expected the name of a column",
        ),
        (
            "--states x, --inputs y",
            "--states <x,y,z>': expected the name of a column",
        ),
    ] {
        refused(2, "a.csv", &data, options, &[says]);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.csv", &data);
    let mut args = words("fit {} --states", &[&path]);
    args.push("".into());
    let error = fails(2, &args);
    assert!(
        error.contains("--states") && error.contains("found nothing"),
        "{error}"
    );
    // Spaces after the commas are no part of the names.
    args.pop();
    args.push("x, y".into());
    args.extend(words("--library poly(1) --quiet", &[]));
    assert!(says(&args).contains("y' ="));
}

#[test]
fn prop_json_has_an_object_for_every_failure() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "a.csv", &waves(50));
    let none = folder.path().join("none.csv");
    let cases = [
        (2, words("fit {} --states x,w", &[&data]), "`w` (--states)"),
        (2, words("fit {} --states x,x", &[&data]), "stands twice"),
        (2, words("fit {}", &[&data]), "--states"),
        (
            2,
            words("fit {} --states x --dt -1", &[&data]),
            "expected a positive number",
        ),
        (2, words("fly", &[]), "fly"),
        (1, words("fit {} --states x", &[&none]), "none.csv"),
        (
            2,
            words("simulate {} --start x=1 --until 1", &[&none]),
            "none.csv",
        ),
    ];
    for (status, args, part) in cases {
        let object = json(status, &args);
        assert_eq!(object["outcome"], "refused", "{object}");
        let said = object["error"].as_str().unwrap();
        assert!(said.contains(part) && !said.contains("Usage"), "{said}");
        // The same text for people, and nothing but that without --json.
        let error = fails(status, &args);
        assert!(error.contains(said), "{said} in {error}");
    }
    let help = run(words("fit --json --help", &[]));
    assert!(help.status.success() && text(&help.stdout).contains("Usage"));
}

#[test]
fn prop_values_that_are_no_data() {
    let data = waves(50);
    let infinite = data.replacen("\n0.5,", "\n0.5,inf,0\n0.51,", 1);
    refused(
        2,
        "a.csv",
        &infinite,
        "--states x,y",
        &["a.csv, data row 11, column `x`", "found inf"],
    );
    let words = "t,x\n0,low\n1,high\n2,low\n";
    refused(
        2,
        "a.csv",
        words,
        "--states x",
        &["column `x`", "numbers", "\"low\""],
    );
    let negative = csv("t,x,w", 50, |i| {
        vec![0.1 * i as f64, i as f64, 3.0 - i as f64]
    });
    refused(
        2,
        "a.csv",
        &negative,
        "--states x --weights w",
        &["data row 5, column `w`", "found -1"],
    );
    let gaps = csv("t,x", 50, |i| vec![0.1 * i as f64, f64::NAN]).replace("NaN", "");
    refused(2, "a.csv", &gaps, "--states x", &["a.csv"]);
    // The row that is short is why too few are left.
    let short = "t,x\n0,1\n1,2\n2\n3,4\n";
    let says = ["expected 2 cells, found 1", "line 4", "expected 4, found 3"];
    refused(2, "a.csv", short, "--states x --library poly(2)", &says);
}

#[test]
fn prop_values_too_large_to_reckon_with() {
    let decay = |size: f64| {
        csv("t,x", 200, |i| {
            let t = 0.05 * i as f64;
            vec![t, size * (-t).exp()]
        })
    };
    let says = [
        "column `x` of",
        "a.csv at time 0",
        "values of at most 1e150",
        "found 1e300",
    ];
    refused(2, "a.csv", &decay(1e300), "--states x", &says);
    let says = ["term `x^3`", "give the data another unit"];
    refused(2, "a.csv", &decay(1e60), "--states x", &says);
    // One cell of that kind among others is an outlier.
    let folder = tempfile::tempdir().unwrap();
    let typo = csv("t,x", 200, |i| {
        let t = 0.05 * i as f64;
        vec![t, if i == 50 { 1e300 } else { (-t).exp() }]
    });
    let data = write(folder.path(), "a.csv", &typo);
    let object = json(0, &words("fit {} --states x", &[&data]));
    let warnings = object["warnings"].to_string();
    assert!(
        warnings.contains("1 of 200 values of x") && warnings.contains("at time 2.5"),
        "{warnings}"
    );
    assert_eq!(object["equations"]["x"][0]["term"], "x");
}

#[test]
fn prop_time_that_does_not_increase() {
    // Two runs in one file, which nobody told apart.
    let twice = waves(40) + waves(40).split_once('\n').unwrap().1;
    let says = [
        "data row 41, column `t`",
        "--trajectory",
        "found 0 after 1.95",
        "40 of 80",
    ];
    refused(2, "a.csv", &twice, "--states x,y", &says);
    let still = csv("t,x", 50, |i| vec![1.0, i as f64]);
    refused(2, "a.csv", &still, "--states x", &["49 of 50"]);
    // One stamp that repeats among many is dropped and counted.
    let folder = tempfile::tempdir().unwrap();
    let repeated = waves(400).replacen("\n0.5,", "\n0.45,9,9\n0.5,", 1);
    let data = write(folder.path(), "a.csv", &repeated);
    let object = json(0, &words("fit {} --states x,y --library poly(1)", &[&data]));
    assert_eq!(object["data"]["files"][0]["rows_dropped"], 1);
    let warnings = object["warnings"].to_string();
    assert!(warnings.contains("1 of 401 rows"), "{warnings}");
}

#[test]
fn prop_a_constant_or_collinear_column_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let check = |name: &str, columns: &str, data: String, says: &[&str]| {
        let path = write(folder.path(), name, &data);
        let args = words(
            &format!("fit {{}} {columns} --library poly(2) --json"),
            &[&path],
        );
        let output = run(args);
        let all = text(&output.stdout) + &text(&output.stderr);
        assert!(!all.contains("panicked") && !all.contains("NaN"), "{all}");
        assert!(matches!(output.status.code(), Some(0 | 2)), "{all}");
        for part in says {
            assert!(all.contains(part), "{name}: {part}: {all}");
        }
    };
    let constant = csv("t,x,u", 400, |i| {
        let t = 0.05 * i as f64;
        vec![t, (-t).exp(), 3.0]
    });
    check("constant.csv", "--states x --inputs u", constant, &["u"]);
    let collinear = csv("t,x,u,v", 400, |i| {
        let t = 0.05 * i as f64;
        vec![t, t.sin(), t.cos(), 2.0 * t.cos()]
    });
    check(
        "collinear.csv",
        "--states x --inputs u,v",
        collinear,
        &["u", "v"],
    );
    let still = csv("t,x", 400, |i| vec![0.05 * i as f64, 1.5]);
    check("still.csv", "--states x", still, &["x"]);
}

#[test]
fn prop_a_library_larger_than_the_data() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "a.csv", &waves(20));
    let output = run(words(
        "fit {} --states x,y --library poly(6) --json",
        &[&data],
    ));
    let all = text(&output.stdout) + &text(&output.stderr);
    assert!(!all.contains("panicked"), "{all}");
    assert!(matches!(output.status.code(), Some(0 | 2)), "{all}");
    // 28 monomials of two variables up to degree 6.
    let said = "more than the library has terms): expected 29, found 20";
    assert!(all.contains(said), "{all}");
}

#[test]
fn prop_settings_and_outputs_that_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let data = write(folder.path(), "a.csv", &waves(200));
    let fit = |settings: &str| {
        let settings = write(folder.path(), "s.toml", settings);
        fails(
            2,
            &words("fit {} --states x,y --settings {}", &[&data, &settings]),
        )
    };
    let error = fit("colour = \"red\"\n");
    assert!(
        error.contains("s.toml") && error.contains("colour"),
        "{error}"
    );
    let error = fit("seed = -1\n");
    assert!(
        error.contains("s.toml") && error.contains("seed"),
        "{error}"
    );
    let missing = folder.path().join("none.toml");
    fails(
        2,
        &words("fit {} --states x,y --settings {}", &[&data, &missing]),
    );
    let error = fails(
        2,
        &words("fit {} --states x,y --model {}", &[&data, folder.path()]),
    );
    assert!(error.contains("found a folder"), "{error}");
    // No output takes an input's place, by whatever path, nor another output's.
    let before = std::fs::read(&data).unwrap();
    let detour = folder.path().join(".").join("a.csv");
    let error = fails(
        2,
        &words("fit {} --states x,y --model {}", &[&data, &detour]),
    );
    assert!(error.contains("one of the inputs"), "{error}");
    assert_eq!(std::fs::read(&data).unwrap(), before);
    let one = folder.path().join("one.svg");
    let error = fails(
        2,
        &words(
            "fit {} --states x,y --model {} --figure {}",
            &[&data, &one, &one],
        ),
    );
    assert!(error.contains("two outputs") && !one.exists(), "{error}");
    let error = fails(2, &words("fit {} --states x,y --figure out.pdf", &[&data]));
    assert!(error.contains(".svg, .png or .html"), "{error}");
    fails(2, &words("fit {}", &[&data]));
    fails(2, &words("fit --states x", &[]));
    // A folder that cannot be: a file stands in its place.
    let below = data.join("model.json");
    let error = fails(
        1,
        &words(
            "fit {} --states x,y --library poly(1) --quiet --model {}",
            &[&data, &below],
        ),
    );
    assert!(error.contains("model.json"), "{error}");
    assert!(
        files(folder.path())
            .iter()
            .all(|f| !f.starts_with(".sindy"))
    );
}
