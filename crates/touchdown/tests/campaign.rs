//! `touchdown campaign` as a command: the same bytes however it is flown.

use crate::common;
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Two controllers and a drawn strength of the ground effect, on the paper's deck; starts low, to be short.
pub(crate) const SWEEP: &str = r#"
trials = 6
block = 2
[grid]
"control.controller" = ["dynamic", "dynamic+observer"]
[random]
"ground_effect_strength" = { kind = "uniform", min = 0.8, max = 1.2 }
[scenario]
control.watch_s = 1.0
[scenario.deck]
kind = "sines"
tones = [{ axis = "heave", amplitude = 0.05, frequency_hz = 0.5 }]
"#;

pub(crate) fn sweep(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("sweep.toml");
    std::fs::write(&path, text).unwrap();
    path
}

pub(crate) fn touchdown(args: &[&str], sweep: &Path, out: &Path) -> std::process::Command {
    let mut command = campaign(args, sweep, out);
    command.arg("--quiet");
    command
}

/// As [`touchdown`], but telling its progress.
pub(crate) fn campaign(args: &[&str], sweep: &Path, out: &Path) -> std::process::Command {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_touchdown"));
    command
        .arg("campaign")
        .arg(sweep)
        .arg("--out")
        .arg(out)
        .args(args);
    command.stdout(Stdio::null());
    command
}

pub(crate) fn flies(args: &[&str], sweep: &Path, out: &Path) {
    let output = touchdown(args, sweep, out)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{args:?}: {}",
        common::text(&output.stderr)
    );
}

/// Every file below a folder, by its path.
pub(crate) fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

pub(crate) fn same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{} differs", name.display());
    }
}

#[test]
fn prop_threads_and_shards_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let sweep = sweep(folder.path(), SWEEP);
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let status = touchdown(&[], &sweep, &at(out))
            .env("RAYON_NUM_THREADS", threads)
            .status()
            .unwrap();
        assert!(status.success());
    }
    same(&at("one"), &at("two"));
    let whole = files(&at("one"));
    // Six blocks of two landings, the sweep, the results, the report and its figures.
    assert_eq!(
        whole.keys().filter(|p| p.starts_with("landings")).count(),
        6
    );
    for name in ["sweep.toml", "results.json", "summary.csv", "report.html"] {
        assert!(whole.contains_key(Path::new(name)), "{name}");
    }
    common::page(&at("one"), common::CAMPAIGN_PAGE);
    for shard in ["1/3", "2/3"] {
        flies(&["--shard", shard], &sweep, &at(&shard.replace('/', "of")));
    }
    // The worst landings are those of all shards: a shard writes no records, and says so.
    let records = at("records").display().to_string();
    let said = touchdown(&["--shard", "3/3", "--mcap", &records], &sweep, &at("3of3"))
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert!(said.status.success() && !at("records").exists());
    let said = common::text(&said.stderr);
    assert!(said.contains("--mcap") && said.contains("merge"), "{said}");
    let merge = |shards: &[&str], out: &str| {
        let mut args = vec![
            "campaign".into(),
            "merge".into(),
            "--out".into(),
            at(out).into_os_string(),
        ];
        args.extend(shards.iter().map(|s| at(s).into_os_string()));
        args
    };
    // Holes and duplicates are told, and nothing is written.
    let hole = common::fails(2, merge(&["1of3", "3of3"], "hole"));
    assert!(hole.contains("2 of 6 blocks are missing: 1, 4"), "{hole}");
    let twice = common::fails(2, merge(&["1of3", "2of3", "3of3", "one"], "twice"));
    assert!(
        twice.contains("block 0 is there twice") && twice.contains("1of3"),
        "{twice}"
    );
    assert!(!at("hole").exists() && !at("twice").exists());
    let results = common::json(0, merge(&["3of3", "1of3", "2of3"], "merged"));
    same(&at("one"), &at("merged"));
    // Once more, and after a kill that left a block out, it is the same.
    std::fs::remove_file(at("merged").join("landings/block-000004.parquet")).unwrap();
    common::json(0, merge(&["3of3", "1of3", "2of3"], "merged"));
    same(&at("one"), &at("merged"));
    // A block that is broken is told before anything is written; so is another one in its place.
    let block = at("2of3").join("landings/block-000004.parquet");
    let bytes = std::fs::read(&block).unwrap();
    std::fs::write(&block, &bytes[..bytes.len() / 2]).unwrap();
    let broken = common::fails(1, merge(&["3of3", "1of3", "2of3"], "broken"));
    assert!(broken.contains("block-000004.parquet"), "{broken}");
    assert!(!at("broken").exists());
    std::fs::write(&block, &bytes).unwrap();
    let there = at("merged").join("landings/block-000004.parquet");
    std::fs::write(&there, b"PAR1").unwrap();
    let other = common::fails(2, merge(&["3of3", "1of3", "2of3"], "merged"));
    assert!(other.contains("another block 4"), "{other}");
    std::fs::write(&there, &bytes).unwrap();
    assert_eq!(results["landings"], 12);
    assert_eq!(results["points"][1]["controller"], "dynamic+observer");
    let written: serde_json::Value =
        serde_json::from_slice(&whole[Path::new("results.json")]).unwrap();
    assert_eq!(results, written, "what is printed is what is written");
    // A shard in a folder of its own, completed there by the others.
    flies(&["--resume", "--shard", "2/3"], &sweep, &at("1of3"));
    flies(&["--resume"], &sweep, &at("1of3"));
    same(&at("one"), &at("1of3"));
    // Any landing can be flown once more, and read by what reads MCAP.
    let replays = at("replays");
    let replay = |landing: &str| {
        let sweep = at("one").join("sweep.toml");
        let args =
            ["campaign", "replay", "--landing", landing, "--mcap"].map(std::ffi::OsString::from);
        args.into_iter()
            .chain([replays.clone().into_os_string(), sweep.into_os_string()])
            .collect::<Vec<_>>()
    };
    assert!(common::fails(2, replay("12")).contains("from 0 to 11, found 12"));
    common::json(0, replay("7"));
    let bytes = std::fs::read(replays.join("landing-000007.mcap")).unwrap();
    let mut times = BTreeMap::<String, Vec<u64>>::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (
                schema.encoding.as_str(),
                message.channel.message_encoding.as_str()
            ),
            ("jsonschema", "json")
        );
        let value: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        // Schemas of Foxglove have a stamp of their own, those of ROS have it in a header.
        let (stamp, part) = match value.get("header") {
            Some(header) => (&header["stamp"], "nanosec"),
            None => (&value["timestamp"], "nsec"),
        };
        let time = stamp["sec"].as_u64().unwrap() * 1_000_000_000 + stamp[part].as_u64().unwrap();
        assert_eq!(time, message.log_time);
        times
            .entry(message.channel.topic.clone())
            .or_default()
            .push(time);
    }
    let topics: Vec<&str> = times.keys().map(String::as_str).collect();
    assert_eq!(
        topics,
        [
            "/battery",
            "/deck",
            "/deck/pose",
            "/estimate",
            "/forces",
            "/imu",
            "/local_position/velocity_local",
            "/motors",
            "/phase",
            "/range",
            "/sensors",
            "/tag",
            "/tf",
            "/vehicle",
            "/vehicle/pose"
        ]
    );
    // A message of each step of the landing computer, 10 ms apart.
    assert!(
        times["/deck"].windows(2).all(|t| t[1] - t[0] == 10_000_000) && times["/deck"].len() > 300
    );
    // The sweep in the folder is the campaign's own.
    flies(&[], &at("one").join("sweep.toml"), &at("again"));
    same(&at("one"), &at("again"));
}

#[test]
fn prop_a_killed_campaign_is_completed_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let trials = ["--trials", "24"];
    let [whole, killed] = ["whole", "killed"].map(|name| folder.path().join(name));
    flies(&trials, &sweep, &whole);
    let mut child = campaign(&trials, &sweep, &killed)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let blocks = || {
        let landings = std::fs::read_dir(killed.join("landings"));
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.unwrap().file_name().into_string().unwrap()
        };
        landings.map_or(0, |entries| {
            entries
                .map(name)
                .filter(|n| n.starts_with("block-"))
                .count()
        })
    };
    // Without a terminal, every block that is written is told in a line.
    let told = BufReader::new(child.stderr.take().unwrap()).lines();
    let third = told
        .map(Result::unwrap)
        .find(|line| line.starts_with("3 of 24 blocks"));
    assert!(third.is_some(), "no line about the third block");
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success(), "killed");
    assert!((3..24).contains(&blocks()), "{} of 24 blocks", blocks());
    assert!(!killed.join("results.json").exists());
    // What a kill in the middle of a write leaves.
    std::fs::write(killed.join("landings/.touchdown-x1"), "PAR1").unwrap();
    let again = common::text(
        &touchdown(&trials, &sweep, &killed)
            .stderr(Stdio::piped())
            .output()
            .unwrap()
            .stderr,
    );
    assert!(again.contains("--resume"), "{again}");
    flies(&[trials[0], trials[1], "--resume"], &sweep, &killed);
    same(&whole, &killed);
    // Other settings are another campaign.
    let other = touchdown(&["--resume", "--trials", "25"], &sweep, &killed)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(2));
    assert!(common::text(&other.stderr).contains("other settings"));
    // A block that is not whole is told by its name.
    let block = killed.join("landings/block-000002.parquet");
    let bytes = std::fs::read(&block).unwrap();
    std::fs::write(&block, &bytes[..bytes.len() / 2]).unwrap();
    let broken = touchdown(&["--resume", "--trials", "24"], &sweep, &killed)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_eq!(broken.status.code(), Some(1));
    assert!(common::text(&broken.stderr).contains("block-000002.parquet"));
    // The results of the whole campaign are still there.
    assert!(killed.join("results.json").exists());
}

/// Ctrl-C leaves whole blocks and no temporary file, and prints the command that flies the others.
#[cfg(unix)]
#[test]
fn prop_an_interrupted_campaign_says_how_to_resume() {
    if common::ignores_interrupts() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), SWEEP);
    let out = folder.path().join("interrupted");
    let mut child = campaign(&["--trials", "24", "--json"], &sweep, &out)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let second = lines
        .by_ref()
        .map(Result::unwrap)
        .find(|line| line.starts_with("2 of 24 blocks"));
    assert!(second.is_some(), "no line about the second block");
    let signal = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signal.unwrap().success());
    let said: Vec<String> = lines.map(Result::unwrap).collect();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{said:?}");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["outcome"], "interrupted");
    let last = said.last().unwrap();
    let written: Vec<PathBuf> = files(&out).into_keys().collect();
    let blocks = written.iter().filter(|p| p.starts_with("landings")).count();
    assert!((2..24).contains(&blocks), "{written:?}");
    assert!(
        last.contains(&format!(
            "interrupted: {blocks} of 24 blocks of landings are in"
        )),
        "{last}"
    );
    assert_eq!(object["error"], last.strip_prefix("error: ").unwrap());
    let temporary = |path: &&PathBuf| path.to_string_lossy().contains(".touchdown-");
    assert_eq!(written.iter().find(temporary), None);
    // The command runs as it is printed.
    let command = last.split('`').nth(1).unwrap();
    let mut words = command.split_whitespace();
    assert_eq!(words.next(), Some("touchdown"));
    let words: Vec<&str> = words.collect();
    assert_eq!(words.last(), Some(&"--resume"), "{command}");
    assert_eq!(common::json(0, words)["landings"], 48);
}

#[test]
fn prop_the_printed_sweep_is_flown() {
    let folder = tempfile::tempdir().unwrap();
    let printed = common::run(["settings", "campaign"]);
    assert!(printed.status.success());
    let text = common::text(&printed.stdout);
    assert!(
        text.contains("# [scenario.sensors.tag]"),
        "every setting is shown"
    );
    let sweep = sweep(folder.path(), &text);
    let out = folder.path().join("out");
    flies(&["--trials", "1"], &sweep, &out);
    let written = std::fs::read_to_string(out.join("results.json")).unwrap();
    let results: serde_json::Value = serde_json::from_str(&written).unwrap();
    // Two controllers, two heights, two periods.
    assert_eq!(results["points"].as_array().unwrap().len(), 8);
    assert!(out.join("figures/success.svg").exists());
}

/// What the command says of a sweep.
fn told(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), text);
    let run = touchdown(&[], &sweep, &folder.path().join("out"))
        .stdout(Stdio::piped())
        .output()
        .unwrap();
    assert!(run.status.success());
    common::text(&run.stdout).to_string()
}

#[test]
fn regress_landings_that_time_out_are_told_with_their_phase() {
    let said = told("trials = 2\n\n[grid]\ntimeout_s = [8.0, 80.0]\n");
    // A landing from the default start is near the deck after 8 s.
    let line = "none of 2 landings at timeout_s 8.0 landed: 2 timed out in phase commit";
    assert!(said.contains(line), "{said}");
    // All land with the usual time: no other point has a line.
    assert_eq!(said.matches(" landings at ").count(), 1, "{said}");
}

#[test]
fn regress_a_hover_whose_time_is_up_is_told_with_what_it_waits_for() {
    // No descent begins beyond 14.7 m/s.
    let said = told(
        "trials = 2\n\n[scenario]\ntimeout_s = 15.0\n\n[grid]\n\"wind.steady_mps\" = [[16.0, 0.0, 0.0]]\n",
    );
    let line = ": 2 timed out in phase hold (wind)";
    assert!(said.contains(line), "{said}");
}
