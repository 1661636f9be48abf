//! `sindy fit --stream --partial` and `sindy merge`: many files, divided among processes.

use std::path::{Path, PathBuf};

use crate::common::{fails, files, json, run, says, text, words, write};
use serde_json::Value;
use sindy::problems;

/// Noisy runs of Lotka-Volterra, each in a file; the third with a gap, a corrupt row and one out of order.
fn runs(folder: &Path) -> Vec<PathBuf> {
    (0..5)
        .map(|seed| {
            let record = &problems::lotka_volterra().noisy(1.0, seed).unwrap()[0];
            let mut out = "t,x,y\n".to_owned();
            for (i, t) in record.time.iter().enumerate() {
                let y = match (seed, i) {
                    (2, 100) => String::new(),
                    _ => record.states[1][i].to_string(),
                };
                if (seed, i) == (2, 200) {
                    out.push_str("9.9,1\n");
                }
                let t = if (seed, i) == (2, 300) { 0.0 } else { *t };
                out.push_str(&format!("{t},{},{y}\n", record.states[0][i]));
            }
            write(folder, &format!("run{seed}.csv"), &out)
        })
        .collect()
}

/// Arguments of a fit of all files.
fn fit(runs: &[PathBuf], more: &str, path: &[&Path]) -> Vec<std::ffi::OsString> {
    let mut args: Vec<std::ffi::OsString> = vec!["fit".into()];
    args.extend(runs.iter().map(Into::into));
    args.extend(words("--states x,y --stream", &[]));
    args.extend(words(more, path));
    args
}

#[test]
fn prop_merged_shards_print_what_one_process_prints() {
    let folder = tempfile::tempdir().unwrap();
    let runs = runs(folder.path());
    let whole = json(3, &fit(&runs, "", &[]));
    let printed = text(&run(fit(&runs, "", &[])).stdout);
    for of in [1, 2, 3, 7] {
        let mut parts = Vec::new();
        for number in 1..=of {
            let path = folder.path().join(format!("{number}of{of}.json"));
            let args = fit(
                &runs,
                &format!("--partial {{}} --shard {number}/{of}"),
                &[&path],
            );
            let output = run(args.iter().cloned().chain(["--json".into()]));
            let said: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(said["of"], 5);
            let more = text(&output.stderr).contains("--shard: 7 shards of 5 files");
            assert_eq!(more, of == 7);
            parts.push(path);
        }
        // In whatever order they come.
        parts.reverse();
        let mut args: Vec<std::ffi::OsString> = vec!["merge".into()];
        args.extend(parts.iter().map(Into::into));
        assert_eq!(json(3, &args), whole, "{of}");
        assert_eq!(text(&run(&args).stdout), printed, "{of}");
    }
    let names = |value: &Value| value["data"]["files"].as_array().unwrap().len();
    assert_eq!(names(&whole), 5);
    let (part, model, figure) = (
        folder.path().join("1of1.json"),
        folder.path().join("model.json"),
        folder.path().join("fit.svg"),
    );
    let args = "merge {} --model {} --figure {}";
    run(words(args, &[&part, &model, &figure]));
    assert!(figure.exists());
    let args = "simulate {} --start x=1,y=1 --until 1 --step 0.1";
    assert!(says(&words(args, &[&model])).contains("finished"));
}

#[test]
fn prop_partial_sums_that_do_not_fit_are_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let runs = runs(folder.path());
    let shard = |name: &str, more: &str, runs: &[PathBuf]| {
        let path = folder.path().join(name);
        let output = run(fit(runs, &format!("--partial {{}} {more}"), &[&path]));
        assert!(path.exists(), "{}", text(&output.stderr));
        path
    };
    let one = shard("one.json", "--shard 1/2", &runs);
    let two = shard("two.json", "--shard 2/2", &runs);
    let quadratic = shard("quadratic.json", "--shard 2/2 --library poly(2)", &runs);
    let discrete = shard("discrete.json", "--shard 2/2 --discrete", &runs);
    let fewer = shard("fewer.json", "", &runs[..3]);
    let merge = |a: &Path, b: &Path| fails(2, &words("merge {} {}", &[a, b]));
    let error = fails(2, &words("merge {}", &[&one]));
    assert!(
        error.contains("all 5 sources, found none of 3 of them") && error.contains("run2.csv"),
        "{error}"
    );
    let error = merge(&one, &one);
    assert!(
        error.contains("each source once") && error.contains("run0.csv in two"),
        "{error}"
    );
    let error = merge(&one, &quadratic);
    assert!(
        error.contains("quadratic.json: partial sums: terms: expected"),
        "{error}"
    );
    let error = merge(&one, &discrete);
    assert!(
        error.contains("settings: expected") && error.contains("discrete: true"),
        "{error}"
    );
    let error = merge(&one, &fewer);
    assert!(
        error.contains("fewer.json: partial sums: sources: expected"),
        "{error}"
    );

    let content = std::fs::read_to_string(&two).unwrap();
    let cut = write(folder.path(), "cut.json", &content[..content.len() / 2]);
    let error = merge(&one, &cut);
    assert!(
        error.contains("cut.json: expected partial sums") && error.contains("checksum differs"),
        "{error}"
    );
    let digit = content.rfind("7").unwrap();
    let mut changed = content.clone();
    changed.replace_range(digit..=digit, "8");
    let changed = write(folder.path(), "changed.json", &changed);
    let error = merge(&one, &changed);
    assert!(
        error.contains("changed.json") && error.contains("checksum differs"),
        "{error}"
    );
    let error = merge(&one, &runs[0]);
    assert!(error.contains("run0.csv: expected partial sums"), "{error}");
    let error = merge(&one, &folder.path().join("none.json"));
    assert!(error.contains("none.json: cannot be read"), "{error}");
    let error = fails(2, &words("merge {} --model {}", &[&one, &one]));
    assert!(error.contains("one of the inputs"), "{error}");
}

#[test]
fn prop_a_part_that_fails_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut runs = runs(folder.path());
    runs.push(write(folder.path(), "bad.csv", "t,x\n0,1\n1,2\n"));
    let before = files(folder.path());
    let path = folder.path().join("part.json");
    let error = fails(2, &fit(&runs, "--partial {} --shard 6/6", &[&path]));
    assert!(
        error.contains("bad.csv") && error.contains("`y`"),
        "{error}"
    );
    for (args, says) in [
        ("--partial {} --shard 7/6", "K from 1 to N"),
        ("--partial {} --model m.json", "cannot be used with"),
    ] {
        let error = fails(2, &fit(&runs, args, &[&path]));
        assert!(error.contains(says), "{error}");
    }
    let error = fails(
        2,
        &words("fit {} --states x,y --partial {}", &[&runs[0], &path]),
    );
    assert!(error.contains("--stream"), "{error}");
    assert_eq!(files(folder.path()), before);
}
