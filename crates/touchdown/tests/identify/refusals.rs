//! Bad input and losses: exit status, one error, nothing half written.

use std::path::{Path, PathBuf};

use std::ffi::OsString;

use super::words;
use crate::common::{fails, json, rotor_row, run, text, write_log};
use touchdown_model::Card;

#[test]
fn prop_bad_input_is_one_error_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_log(&path("good.csv"), 3000, rotor_row);
    write_log(&path("three.csv"), 3, rotor_row);
    write_log(&path("gaps.csv"), 3000, |i| {
        format!("{},nan,nan", 0.01 * i as f64)
    });
    write_log(&path("reversed.csv"), 3000, |i| {
        format!("{},{},-4", 0.01 * i as f64, i % 7)
    });
    write_log(&path("huge.csv"), 3000, |i| {
        format!("{},0.{},{}e300", 0.01 * i as f64, i % 7, 1 + i % 7)
    });
    write_log(&path("constant.csv"), 3000, |i| {
        format!("{},0.{},5", 0.01 * i as f64, i % 7)
    });
    write_log(&path("header.csv"), 0, rotor_row);
    std::fs::write(path("empty.csv"), "").unwrap();
    std::fs::write(path("numbers.csv"), "0,1\n1,2\n").unwrap();
    let card = path("card.toml");
    let fit = |log: &str, more: &[&str]| {
        let mut args = words(&["identify", "thrust"], &[&path(log)]);
        args.extend(words(&["--out"], &[&card]));
        args.extend(words(more, &[]));
        args
    };
    for (log, what) in [
        ("missing.csv", "missing.csv: cannot be read"),
        (".", "cannot be read"),
        ("empty.csv", "found an empty file"),
        ("header.csv", "no usable rows"),
        ("three.csv", "found 3 points at 3 levels"),
        ("gaps.csv", "gaps only"),
        ("reversed.csv", "is its sign reversed?"),
        (
            "huge.csv",
            "values of `thrust_n` of at most 1e9, found 1e300 in row 0 (from 0)",
        ),
        ("constant.csv", "thrust does not follow the throttle"),
    ] {
        let error = fails(1, fit(log, &[]));
        assert!(error.contains(what), "{log}: {error}");
    }
    // Columns without names are read, and need a map.
    let error = fails(2, fit("numbers.csv", &[]));
    assert!(
        error.contains("found the columns \"c1\", \"c2\""),
        "{error}"
    );
    for (name, content, what) in [
        (
            "key.toml",
            "schema = 1\nkey = 2\n[channels]\ntime_s = 'time_s'\n",
            "key.toml, line 2",
        ),
        (
            "column.toml",
            "schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = 'throttel'\n",
            "line 4, channels.throttle: ",
        ),
        (
            "mass.toml",
            "schema = 1\n[channels]\ntime_s = 'time_s'\n[vehicle]\nmass_kg = -1\n",
            "expected a finite number above 0, found -1",
        ),
    ] {
        std::fs::write(path(name), content).unwrap();
        let error = fails(
            2,
            fit("good.csv", &["--map", &path(name).display().to_string()]),
        );
        assert!(error.contains(what), "{name}: {error}");
    }
    for (content, what) in [
        ("[thrust]\ndegre = 3\n", "degre"),
        ("[thrust]\ndegree = 0\n", "expected 1 to 6, found 0"),
        ("[smoothing]\nwindow = 4\n", "found 4"),
    ] {
        std::fs::write(path("settings.toml"), content).unwrap();
        let settings = path("settings.toml").display().to_string();
        let error = fails(2, fit("good.csv", &["--settings", &settings]));
        assert!(
            error.contains(what) && error.contains("settings.toml"),
            "{error}"
        );
    }
    let left: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|n| n.starts_with('.') || n == "card.toml")
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn regress_what_was_dropped_is_told_where_nothing_can_be_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("runs.csv");
    // Two runs: the second repeats the stamps of the first, which never moves the throttle.
    write_log(&log, 200, |i| {
        let throttle = if i < 100 {
            0.5
        } else {
            0.3 + 0.005 * (i - 100) as f64
        };
        format!("{},{throttle},5", 0.01 * (i % 100) as f64)
    });
    let card = folder.path().join("card.toml");
    for more in [vec![], vec![Path::new("--out"), &card]] {
        let mut paths = vec![log.as_path()];
        paths.extend(more);
        let output = run(words(&["identify", "thrust"], &paths));
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(
            told.contains("100 of 200 rows repeat a stamp and were dropped"),
            "{told}"
        );
        assert!(
            told.contains("time_s goes back once and runs on from there, first at row 100"),
            "{told}"
        );
    }
}

#[test]
fn regress_several_load_cells_are_named_where_no_thrust_is() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("stand.csv");
    let rows: String = (0..200)
        .map(|i| format!("{},{},{i},{i}\n", 0.01 * f64::from(i), f64::from(i) / 200.0))
        .collect();
    std::fs::write(
        &log,
        format!("time_s,throttle,Thrust1 [g],Thrust2 [g]\n{rows}"),
    )
    .unwrap();
    let told = text(&run(words(&["identify", "thrust"], &[&log])).stderr);
    assert!(
        told.contains("but several look like it") && told.contains("remove the # of one line"),
        "{told}"
    );
}

#[test]
fn prop_losses_are_told_by_the_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    let stamps = |every: usize| {
        write_log(&log, 3000, |i| {
            let row = rotor_row(i);
            let (_, rest) = row.split_once(',').unwrap();
            let t = 0.01 * if i % every == every - 1 { i - 1 } else { i } as f64;
            format!("{t},{rest}")
        });
    };
    // 10 of 3000 rows repeat a stamp: warned of; 60 of them: lost.
    stamps(300);
    let found = json(0, words(&["identify", "thrust"], &[&log]));
    assert_eq!(found["rows_dropped"], 10);
    assert!(
        text(&run(words(&["identify", "thrust"], &[&log])).stderr)
            .contains("warning: 10 of 3000 rows")
    );
    stamps(50);
    assert_eq!(
        json(3, words(&["identify", "thrust"], &[&log]))["rows_dropped"],
        60
    );
    // The last record breaks off.
    write_log(&log, 3000, rotor_row);
    let whole = std::fs::read_to_string(&log).unwrap();
    std::fs::write(&log, whole.trim_end().rsplit_once(',').unwrap().0).unwrap();
    assert_eq!(
        json(3, words(&["identify", "thrust"], &[&log]))["rows_dropped"],
        1
    );
}

#[test]
fn prop_ground_effect_needs_a_thrust_card_and_its_channels() {
    let folder = tempfile::tempdir().unwrap();
    let (log, card) = (
        folder.path().join("log.csv"),
        folder.path().join("thrust.toml"),
    );
    write_log(&log, 3000, rotor_row);
    let mut args = words(&["identify", "thrust"], &[&log]);
    args.extend(words(&["--out"], &[&card]));
    assert!(run(args).status.success());
    let ground = |thrust: &Path, more: &[&str]| {
        let mut args = words(&["identify", "ground-effect"], &[&log]);
        args.extend(words(&["--thrust"], &[thrust]));
        args.extend(words(more, &[]));
        args
    };
    assert!(fails(2, ground(&card, &[])).contains("height_m"));
    assert!(fails(2, ground(&folder.path().join("none.toml"), &[])).contains("none.toml"));
    fails(2, ground(&log, &[]));
    let published = folder.path().join("eq12.toml");
    std::fs::write(&published, touchdown_model::published::EQ_12).unwrap();
    assert!(fails(2, ground(&published, &[])).contains("expected `thrust`"));
    let other = folder.path().join("other.toml");
    let schema = std::fs::read_to_string(&card)
        .unwrap()
        .replace("schema = 1", "schema = 7");
    std::fs::write(&other, schema).unwrap();
    assert!(fails(2, ground(&other, &[])).contains("key `schema`: expected 1, found 7"));
}

#[test]
fn regress_a_thrust_with_thousands_separators_is_no_flight() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("stand.csv");
    write_log(&log, 200, |i| {
        let s = (i / 20) as f64 / 10.0;
        format!("{},{s},\"1{},200.5\"", 0.01 * i as f64, i / 20)
    });
    let error = fails(2, words(&["identify", "thrust"], &[&log]));
    assert!(
        error.contains(
            "expected numbers in the column \"thrust_n\", found text such as \"10,200.5\""
        ),
        "{error}"
    );
    assert!(!error.contains("mass"), "{error}");
    for command in ["identify thrust", "inspect"] {
        let command: Vec<&str> = command.split(' ').collect();
        let told = text(&run(words(&command, &[&log])).stderr);
        assert!(
            told.contains("column \"thrust_n\" was taken for text") && told.contains("line 2"),
            "{told}"
        );
    }
}

/// Ctrl-C while files are written leaves whole files and no temporary ones, and says that some are missing.
#[cfg(unix)]
#[test]
fn prop_an_interrupted_identification_says_what_is_missing() {
    if crate::common::ignores_interrupts() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let logs: Vec<PathBuf> = (0..8)
        .map(|k| folder.path().join(format!("log{k}.csv")))
        .collect();
    for (k, log) in logs.iter().enumerate() {
        write_log(log, 600 + 10 * k, rotor_row);
    }
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_touchdown"))
        .args(["--json", "identify", "thrust"])
        .args(&logs)
        .arg("--out")
        .arg(&out)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Cards come first, then the figures, whose images take a while.
    while !out.join("log7.toml").exists() && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    let signal = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signal.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{errors}");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["outcome"], "interrupted");
    let expected = format!(
        "interrupted: the files in {} are complete, but some are missing",
        out.display()
    );
    assert!(errors.contains(&expected), "{errors}");
    assert!(!out.join("results.json").exists());
    for k in 0..8 {
        Card::read(&out.join(format!("log{k}.toml"))).unwrap();
    }
    for folder in [&out, &out.join("figures")] {
        let names = std::fs::read_dir(folder).into_iter().flatten();
        let names = names.map(|entry| entry.unwrap().file_name());
        let temporary = |name: &OsString| name.to_string_lossy().starts_with(".touchdown-");
        assert_eq!(names.into_iter().find(temporary), None);
    }
}

#[test]
fn regress_a_stand_whose_thrust_has_another_name_is_no_flight() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("stand.csv");
    let rows: String = (0..200)
        .map(|i| {
            format!(
                "{:.2},{:.3},{}\n",
                0.01 * f64::from(i),
                f64::from(i) / 200.0,
                5 * i
            )
        })
        .collect();
    std::fs::write(&log, format!("time_s,throttle,Load cell [g]\n{rows}")).unwrap();
    let error = fails(2, words(&["identify", "thrust"], &[&log]));
    assert!(
        error.contains("thrust_n = '9.80665e-3 * \"Load cell [g]\"': save it")
            && error.contains("touchdown inspect"),
        "{error}"
    );
    assert!(!error.contains("mass"), "{error}");
}
