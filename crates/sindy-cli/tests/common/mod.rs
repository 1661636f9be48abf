//! What the tests of the command share.
#![allow(dead_code, unreachable_pub)]

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

/// Runs the command.
pub fn run<S: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = S>) -> Output {
    Command::cargo_bin("sindy")
        .unwrap()
        .args(args)
        .output()
        .unwrap()
}

/// Words and paths as arguments, in order: `{}` in the words stands for the next path.
pub fn words(text: &str, paths: &[&Path]) -> Vec<OsString> {
    let mut paths = paths.iter();
    text.split_whitespace()
        .map(|word| match word {
            "{}" => paths.next().unwrap().into(),
            _ => word.into(),
        })
        .collect()
}

/// Runs the command with `--json`, expects the exit status and gives the object.
pub fn json(status: i32, args: &[OsString]) -> Value {
    let output = run(args.iter().cloned().chain(["--json".into()]));
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {error}");
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", text(&output.stdout)))
}

/// Runs the command, expects that it succeeds and gives what it printed on standard output.
pub fn says(args: &[OsString]) -> String {
    let output = run(args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {error}");
    text(&output.stdout)
}

/// Runs the command, expects that it fails with the status and one clear error, and gives that.
pub fn fails(status: i32, args: &[OsString]) -> String {
    let output = run(args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {error}");
    assert!(
        error.contains("error: ") && !error.contains("panicked"),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    error
}

/// Bytes as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A number in an object.
pub fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number, not {value}"))
}

/// Writes a file into a folder and gives its path.
pub fn write(folder: &Path, name: &str, content: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, content).unwrap();
    path
}

/// A table of a header and rows.
pub fn csv(header: &str, rows: usize, row: impl Fn(usize) -> Vec<f64>) -> String {
    let mut out = format!("{header}\n");
    for i in 0..rows {
        let cells: Vec<String> = row(i).iter().map(f64::to_string).collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

/// The files in a folder, hidden ones too.
pub fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
