//! Parts of a campaign: shards, ranges of blocks, what is there of them, and the job script that flies them.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::campaign::{SWEEP, flies, same, sweep, touchdown};
use crate::common;

fn status(folder: &Path) -> serde_json::Value {
    status_that_ends(0, folder)
}

fn status_that_ends(code: i32, folder: &Path) -> serde_json::Value {
    let words = ["campaign".as_ref(), "status".as_ref(), folder.as_os_str()];
    common::json(code, words)
}

fn merged_in_place(folder: &Path) {
    let words = ["campaign", "merge", "--out"].map(std::ffi::OsStr::new);
    let folders = [folder.as_os_str(), folder.as_os_str()];
    common::json(0, words.into_iter().chain(folders));
}

#[test]
fn prop_parts_share_a_folder_and_its_status_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let [whole, shared] = ["whole", "shared"].map(|name| folder.path().join(name));
    flies(&[], &sweep, &whole);
    flies(&["--blocks", "1..3"], &sweep, &shared);
    let there = status(&shared);
    assert_eq!(there["missing"], serde_json::json!([[0, 1], [3, 6]]));
    let counts = ["blocks_there", "blocks", "rows", "landings"].map(|key| there[key].as_u64());
    assert_eq!(counts, [2, 6, 4, 12].map(Some));
    assert_eq!(there["complete"], false);
    let said = common::text(
        &common::run(["campaign".as_ref(), "status".as_ref(), shared.as_os_str()]).stdout,
    );
    assert!(
        said.contains("2 of 6 blocks") && said.contains("missing blocks: 0..1, 3..6"),
        "{said}"
    );
    // Two at once in the same folder; blocks that are there are not flown again.
    let before = std::fs::metadata(shared.join("landings/block-000001.parquet")).unwrap();
    let mut runs = ["1/2", "2/2"].map(|shard| {
        let mut run = touchdown(&["--shard", shard, "--resume"], &sweep, &shared);
        run.spawn().unwrap()
    });
    assert!(runs.iter_mut().all(|run| run.wait().unwrap().success()));
    let after = std::fs::metadata(shared.join("landings/block-000001.parquet")).unwrap();
    assert_eq!(before.modified().unwrap(), after.modified().unwrap());
    // No part writes the report, also not the last one.
    assert!(!shared.join("results.json").exists());
    let there = status(&shared);
    assert_eq!(
        (there["complete"].as_bool(), there["rows"].as_u64()),
        (Some(true), Some(12))
    );
    merged_in_place(&shared);
    same(&whole, &shared);
    // A broken block is named, and its landings are not counted.
    let block = shared.join("landings/block-000004.parquet");
    let bytes = std::fs::read(&block).unwrap();
    std::fs::write(&block, &bytes[..bytes.len() / 2]).unwrap();
    // The program says so by its status, too.
    let there = status_that_ends(3, &shared);
    assert_eq!(there["broken"][0]["block"], 4);
    assert_eq!(
        (there["complete"].as_bool(), there["rows"].as_u64()),
        (Some(false), Some(10))
    );
    // A part reads its own blocks only.
    flies(&["--blocks", "0..4", "--resume"], &sweep, &shared);
    let broken = touchdown(&["--blocks", "3..5", "--resume"], &sweep, &shared);
    assert_eq!({ broken }.status().unwrap().code(), Some(1));
}

#[test]
fn analytic_a_block_that_is_sized_by_time_takes_that_time() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let ask = |seconds: &str| {
        let words = ["campaign", "block", "--seconds", seconds].map(std::ffi::OsStr::new);
        common::json(0, words.into_iter().chain([sweep.as_os_str()]))
    };
    let number = |found: &serde_json::Value, key: &str| found[key].as_f64().unwrap();
    // Twelve landings, all of them timed.
    let found = ask("1e9");
    assert_eq!(
        (
            number(&found, "timed"),
            number(&found, "block"),
            number(&found, "blocks")
        ),
        (12.0, 12.0, 1.0)
    );
    assert!(number(&found, "fastest_landing_s") <= number(&found, "landing_s"));
    assert!(number(&found, "slowest_landing_s") >= number(&found, "landing_s"));
    let one = ask("1e-9");
    assert_eq!((number(&one, "block"), number(&one, "blocks")), (1.0, 12.0));
    for wrong in ["0", "-1", "nan", "inf", "x"] {
        let seconds = format!("--seconds={wrong}");
        let words = ["campaign", "block", &seconds].map(std::ffi::OsStr::new);
        let error = common::fails(2, words.into_iter().chain([sweep.as_os_str()]));
        assert!(error.contains("expected seconds"), "{wrong}: {error}");
    }
}

#[test]
fn prop_parts_that_fly_nothing_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let told = |args: &[&str], out: &str| {
        let output = touchdown(args, &sweep, &folder.path().join(out))
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        (output.status.code(), common::text(&output.stderr))
    };
    let (code, said) = told(&["--shard", "7/48"], "empty");
    assert_eq!(code, Some(0));
    assert!(
        said.contains("42 of 48 shards fly nothing") && said.contains("12 landings"),
        "{said}"
    );
    let (_, said) = told(&["--shard", "12/12"], "fewer");
    assert!(
        said.contains("Set `block = 1` in the sweep (now 2)"),
        "{said}"
    );
    let (code, said) = told(&["--shard", "6/6"], "last");
    assert!(code == Some(0) && !said.contains("nothing"), "{said}");
    let (code, said) = told(&["--blocks", "5..7"], "beyond");
    assert!(
        code == Some(2) && said.contains("from 0 to before 6"),
        "{said}"
    );
    assert!(!folder.path().join("beyond").exists());
    let (code, _) = told(&["--blocks", "3..3"], "beyond");
    assert_eq!(code, Some(2));
}

/// The script as Slurm runs it, one task after the other: `sbatch` is played by a program that writes down how it was called.
#[cfg(unix)]
#[test]
fn prop_the_job_script_flies_the_campaign() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let [whole, out] = ["whole", "o u't"].map(|name| folder.path().join(name));
    flies(&["--seed", "5"], &sweep, &whole);
    let args = |tasks: &str| {
        let words = ["campaign", "slurm", "--time", "01:00:00", "--seed", "5"];
        let words = words.into_iter().chain(["--cpus", "2", "--tasks", tasks]);
        let mut args: Vec<std::ffi::OsString> = words.map(Into::into).collect();
        args.extend(["--out".into(), out.clone().into(), sweep.clone().into()]);
        args
    };
    let refused = common::fails(2, args("7"));
    assert!(
        refused.contains("at most 6") && refused.contains("block = 1"),
        "{refused}"
    );
    let script = common::run(args("4")).stdout;
    let path = folder.path().join("job.sh");
    std::fs::write(&path, &script).unwrap();
    let script = common::text(&script);
    for line in [
        "--array=1-4",
        "--cpus-per-task=2",
        "--time=01:00:00",
        "--requeue",
    ] {
        assert!(script.contains(&format!("#SBATCH {line}\n")), "{line}");
    }
    let bin = folder.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    let stub = "#!/bin/sh\necho \"$@\" >> \"$CALLS\"\nwc -l < \"$CALLS\" | tr -d ' '\n";
    std::fs::write(bin.join("sbatch"), stub).unwrap();
    std::fs::set_permissions(bin.join("sbatch"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let calls = folder.path().join("calls");
    let bash = |task: Option<u32>, args: &[&str]| {
        let mut bash = Command::new("bash");
        bash.arg(&path).args(args).env("CALLS", &calls);
        let paths = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        bash.env("PATH", paths).env_remove("SLURM_ARRAY_TASK_ID");
        if let Some(task) = task {
            bash.env("SLURM_ARRAY_TASK_ID", task.to_string());
        }
        let output = bash.output().unwrap();
        let said = common::text(&output.stderr);
        assert!(output.status.success(), "{task:?} {args:?}: {said}");
        common::text(&output.stdout)
    };
    let said = bash(None, &["--partition=long"]);
    assert!(said.contains("4 tasks as job 1"), "{said}");
    let calls = std::fs::read_to_string(&calls).unwrap();
    let calls: Vec<&str> = calls.lines().collect();
    assert!(calls.len() == 2 && calls.iter().all(|call| call.contains("--partition=long")));
    assert!(
        calls[1].contains("--dependency=afterany:1") && calls[1].ends_with("job.sh merge"),
        "{calls:?}"
    );
    for task in 1..=4 {
        bash(Some(task), &[]);
    }
    std::fs::remove_dir_all(out.join("slurm")).unwrap();
    bash(Some(1), &["merge"]);
    same(&whole, &out);
    // A task that is queued again finds its blocks there.
    bash(Some(2), &[]);
    same(&whole, &out);
}
