//! Hostile and careless input: a corpus of small files that ask for much, read with a limit of memory and of work.
#![cfg(unix)]

mod corpus;
mod parquet;
mod recordings;

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Address space of a command, in KiB: 1 GiB. The readers take 256 MiB and 64 bytes for each byte of a file; twice
/// that is left for the program, its threads and what it prints. Half of it is too little for two passes of a log.
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
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// Writes the file, inspects it, and gives the exit status and standard error.
fn inspect(folder: &Path, name: &str, bytes: &[u8], more: &[&str]) -> (Option<i32>, String) {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    // The tests of the landing lab drop the same files on its page.
    if let Some(corpus) = std::env::var_os("TOUCHDOWN_CORPUS") {
        std::fs::write(Path::new(&corpus).join(name), bytes).unwrap();
    }
    let path = path.display().to_string();
    let output = bounded(&[&["inspect", &path], more].concat());
    (
        output.status.code(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// Each file is refused with exit status 1 and one sentence that holds these words.
fn are_refused(cases: &[(&str, Vec<u8>, &[&str], &str)]) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, more, words) in cases {
        let (status, text) = inspect(folder.path(), name, bytes, more);
        assert_eq!(status, Some(1), "{name}: {text}");
        assert_eq!(text.lines().count(), 1, "{name}: {text}");
        let is_told = text.starts_with("error: ") && text.contains("refused: expected at most");
        assert!(is_told && text.contains(words), "{name}: {text}");
    }
}

#[test]
fn regress_names_that_multiply_are_refused() {
    are_refused(&[
        (
            "nested.mcap",
            corpus::nested_definition(),
            &[],
            "MiB of names in a log",
        ),
        (
            "flat.mcap",
            corpus::wide_definitions(),
            &[],
            "parts of the definitions",
        ),
        (
            "json.mcap",
            corpus::nested_json(),
            &[],
            "512 bytes in a name",
        ),
        (
            "names.ulg",
            corpus::ulog_names(),
            &[],
            "512 bytes in a name",
        ),
    ]);
}

#[test]
fn regress_what_unpacks_without_end_is_refused() {
    let words = "100 unpacked bytes for each packed byte";
    are_refused(&[
        ("zeros.bag", corpus::bzip2_zeros(), &[], words),
        ("zeros.mcap", corpus::zstd_zeros(), &[], words),
        ("cell.parquet", corpus::parquet_cell(1 << 30), &[], words),
        ("lie.parquet", corpus::parquet_cell(100), &[], words),
    ]);
}

#[test]
fn regress_values_and_columns_without_end_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let wide = folder.path().join("wide.toml");
    std::fs::write(&wide, corpus::wide_map()).unwrap();
    let wide = ["--map", wide.to_str().unwrap()];
    are_refused(&[
        (
            "tiny.mcap",
            corpus::tiny_messages_mcap(),
            &wide,
            "MB of values",
        ),
        (
            "tiny.bag",
            corpus::tiny_messages_bag(),
            &wide,
            "MB of values",
        ),
        (
            "columns.parquet",
            corpus::parquet_columns(20_000),
            &[],
            "16384 columns",
        ),
        (
            "wide30.csv",
            corpus::csv_columns(30_000),
            &[],
            "16384 columns",
        ),
        (
            "wide100.csv",
            corpus::csv_columns(100_000),
            &[],
            "16384 columns",
        ),
        (
            "delimiters.csv",
            corpus::csv_without_names(5_000_000),
            &[],
            "16384 columns",
        ),
    ]);
}

#[test]
fn regress_files_within_the_limits_are_read_with_bounded_work() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("fields.mcap", corpus::many_json_fields()),
        ("tiny.mcap", corpus::tiny_messages_mcap()),
        ("wide16.csv", corpus::csv_columns(16_000)),
        ("delimiters.csv", corpus::csv_without_names(16_000)),
        ("columns.parquet", corpus::parquet_columns(16_000)),
    ] {
        let (status, text) = inspect(folder.path(), name, &bytes, &[]);
        assert_eq!(status, Some(0), "{name}: {text}");
    }
}

#[test]
fn regress_a_map_without_end_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (name, channels, words) in [
        ("long.toml", 100_000, "at most 1048576 bytes of text"),
        ("many.toml", 20_000, "at most 1024 expressions"),
    ] {
        let map = folder.path().join(name);
        std::fs::write(&map, corpus::endless_map(channels)).unwrap();
        let map = ["--map", map.to_str().unwrap()];
        let (status, text) = inspect(folder.path(), "a.csv", b"time_s,x\n0,1\n1,2\n", &map);
        assert_eq!(status, Some(2), "{text}");
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn regress_pipes_and_devices_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.csv");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let limits = format!("ulimit -t {WORK_S}; echo time_s,x | exec \"$0\" \"$@\"");
    let piped = |args: &[&str]| {
        let mut command = Command::new("sh");
        command.args(["-c", &limits, env!("CARGO_BIN_EXE_touchdown"), "--quiet"]);
        command.args(args).output().unwrap()
    };
    let pipe = pipe.to_str().unwrap();
    for (path, found) in [
        (pipe, "found a pipe"),
        ("/dev/stdin", "found a pipe"),
        ("/dev/zero", "found a device"),
    ] {
        for command in [&["inspect", path][..], &["identify", "thrust", path]] {
            let output = piped(command);
            let text = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(1), "{path}: {text}");
            assert!(
                text.contains(path) && text.contains(found),
                "{path}: {text}"
            );
        }
    }
}

#[test]
fn regress_names_never_command_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "x\u{1b}[2J\u{9b}31m\u{202e}\u{2066}\nwarning: y";
    let mut logs = vec![
        ("name.mcap", corpus::named_mcap(hostile)),
        ("name.bin", corpus::named_dataflash("x\u{1b}[2J\u{9b}\n")),
        ("name.ulg", corpus::named_ulog("x\u{9b}2J\u{202e}")),
        ("name.parquet", corpus::named_parquet(hostile)),
    ];
    let text = format!(
        "time_s,{0},{0}\n0,1,2\n1,2,word\n",
        hostile.replace('\n', "\r")
    );
    logs.push(("name.csv", text.replace('\r', "").into_bytes()));
    for (name, bytes) in logs {
        let path = folder.path().join(format!("\u{9b}{name}"));
        std::fs::write(&path, &bytes).unwrap();
        for more in [&[][..], &["--json"]] {
            let output = bounded(&[&["inspect", path.to_str().unwrap()], more].concat());
            let shown = [output.stdout, output.stderr].concat();
            let shown = String::from_utf8(shown).unwrap();
            let raw = shown.chars().find(|&c| {
                c != '\n' && c.is_control()
                    || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
            });
            assert_eq!(raw, None, "{name}: {shown:?}");
            assert!(shown.contains("9b"), "{name}: {shown:?}");
            let forged = |line: &str| line.starts_with("warning: y");
            assert!(!shown.lines().any(forged), "{name}: {shown}");
        }
    }
}
