//! Hostile and careless input: a corpus of small files that ask for much, read with a limit of memory and of work.

mod corpus;
mod parquet;
mod recordings;

use std::path::Path;
use std::process::{Command, Output};

/// Address space of a command, in KiB: 1 GiB. The limits of the readers allow 256 MiB and 64 bytes for each byte of a
/// file; twice that is left for the program, its threads and what it prints. Half of it is too little to start.
const MEMORY_KIB: usize = 1 << 20;
/// Processor time of a command, in s. It bounds work, not speed: what the limits allow takes a fifth of it in a build
/// for tests, and what they exclude took minutes.
const WORK_S: usize = 30;

/// Runs the command with these limits.
fn bounded(args: &[&str]) -> Output {
    let limits = format!("ulimit -v {MEMORY_KIB}; ulimit -t {WORK_S}; exec \"$0\" \"$@\"");
    Command::new("sh")
        .args(["-c", &limits, env!("CARGO_BIN_EXE_touchdown"), "--quiet"])
        .args(args)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Writes the file, inspects it, and gives the exit status and the lines on standard error.
fn inspect(folder: &Path, name: &str, bytes: &[u8], more: &[&str]) -> (Option<i32>, Vec<String>) {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let path = path.display().to_string();
    let output = bounded(&[&["inspect", &path], more].concat());
    let lines = text(&output.stderr).lines().map(str::to_owned).collect();
    (output.status.code(), lines)
}

#[test]
fn regress_every_file_that_asks_for_too_much_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let wide = folder.path().join("wide.toml");
    std::fs::write(&wide, corpus::wide_map()).unwrap();
    let wide = ["--map", wide.to_str().unwrap()];
    let none: [&str; 0] = [];
    for (name, bytes, more) in [
        ("nested.mcap", corpus::nested_definition(), &none[..]),
        ("json.mcap", corpus::nested_json(), &none),
        ("fields.mcap", corpus::many_json_fields(), &none),
        ("zeros.bag", corpus::bzip2_zeros(), &none),
        ("zeros.mcap", corpus::zstd_zeros(), &none),
        ("tiny.mcap", corpus::tiny_messages_mcap(), &wide),
        ("tiny.bag", corpus::tiny_messages_bag(), &wide),
        ("cell.parquet", corpus::parquet_cell(1 << 30), &none),
        ("lie.parquet", corpus::parquet_cell(100), &none),
        ("columns.parquet", corpus::parquet_columns(15_000), &none),
        ("wide16.csv", corpus::csv_columns(16_000), &none),
        ("wide30.csv", corpus::csv_columns(30_000), &none),
        ("wide100.csv", corpus::csv_columns(100_000), &none),
        (
            "delimiters.csv",
            corpus::csv_without_names(5_000_000),
            &none,
        ),
        ("names.ulg", corpus::ulog_names(), &none),
    ] {
        let start = std::time::Instant::now();
        let (status, lines) = inspect(folder.path(), name, &bytes, more);
        eprintln!(
            "{name}: {} bytes, {:?} s, status {status:?}, {} lines: {:.300}",
            bytes.len(),
            start.elapsed(),
            lines.len(),
            lines.join(" / ")
        );
    }
}
