//! `touchdown land`, `rig` and `settings` as commands.

use crate::common;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

fn touchdown() -> Command {
    Command::cargo_bin("touchdown").unwrap()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn json(output: &std::process::Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn prop_shipped_scenarios_run() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["ground", "deck", "yours"] {
        let out = folder.path().join(name);
        let output = touchdown()
            .args(["land", "--quiet", "--json", "--trials", "2", "--out"])
            .arg(&out)
            .arg(
                root()
                    .join("examples/scenarios")
                    .join(format!("{name}.toml")),
            )
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        let results = json(&output);
        let written: Value =
            serde_json::from_str(&std::fs::read_to_string(out.join("results.json")).unwrap())
                .unwrap();
        assert_eq!(results, written, "what is printed is what is written");
        assert_eq!(results["landing"]["dynamic"]["trials"], 2);
        common::page(&out, common::SMALL_PAGE);
    }
}

#[test]
fn prop_cards_that_are_given_are_flown() {
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("first");
    let land = |out: &Path, more: &[&str]| {
        touchdown()
            .args([
                "land",
                "--quiet",
                "--json",
                "--controller",
                "dynamic",
                "--trials",
                "3",
                "--out",
            ])
            .arg(out)
            .args(more)
            .output()
            .unwrap()
    };
    let own = land(&first, &[]);
    assert!(own.status.success());
    let card = |name: &str| first.join("cards").join(name).display().to_string();
    let again = land(
        &folder.path().join("again"),
        &[
            "--thrust",
            &card("thrust-library.toml"),
            "--dynamic",
            &card("ground-effect-lag.toml"),
        ],
    );
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
    assert_eq!(json(&own)["landing"], json(&again)["landing"]);
    // A thrust card where a ground-effect card belongs.
    let thrust = card("thrust-library.toml");
    let wrong = land(
        &folder.path().join("wrong"),
        &["--thrust", &thrust, "--dynamic", &thrust],
    );
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("ground-effect card is expected"));
}

#[test]
fn prop_bad_scenarios_are_one_error_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("s.toml");
    let cases: [(&str, &[&str]); 11] = [
        (
            "[scenario.plant]\nmass_kg = -1.0\n",
            &["s.toml", "mass_kg", "-1"],
        ),
        (
            "[scenario.deck]\nkind = \"sine\"\namplitude_m = 0.7\nfrequency_hz = 0.5\n",
            &["s.toml", "deck", "0.7", "start height"],
        ),
        (
            "controllers = [\"magic\"]\n",
            &["s.toml", "magic", "feedback"],
        ),
        ("controllers = []\n", &["s.toml", "controllers"]),
        ("trials = 0\n", &["s.toml", "trials", "0"]),
        ("[scenario]\ncolour = 1\n", &["s.toml", "colour", "line 2"]),
        (
            "[scenario]\nstart_height_m = 0.05\n",
            &["s.toml", "start_height_m", "0.05"],
        ),
        (
            "[scenario]\ncontrol_period_s = nan\n",
            &["s.toml", "control_period_s"],
        ),
        (
            "[cards]\nthrust = \"no-such-card.toml\"\n",
            &["no-such-card.toml"],
        ),
        (
            "control.deck_lead_s = -1.0\n",
            &["s.toml", "key `control.deck_lead_s`", "found -1"],
        ),
        (
            "control.end_height_m = 1e9\n",
            &[
                "s.toml",
                "key `control.end_height_m`",
                "`scenario.start_height_m` = 0.5",
            ],
        ),
    ];
    for (text, named) in cases {
        std::fs::write(&scenario, text).unwrap();
        let out = folder.path().join("out");
        let output = touchdown()
            .args(["land", "--quiet", "--out"])
            .arg(&out)
            .arg(&scenario)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).to_string();
        assert_eq!(output.status.code(), Some(2), "{text}: {said}");
        for name in named {
            assert!(said.contains(name), "{text}: `{name}` is not in: {said}");
        }
        assert!(!out.join("results.json").exists(), "{text}");
    }
}

#[test]
fn prop_the_rig_writes_trials_that_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rig");
    let output = touchdown()
        .args(["rig", "--quiet", "--json", "--out"])
        .arg(&out)
        .arg(root().join("examples/scenarios/rig.toml"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let results = json(&output);
    let trials = results["trials"].as_array().unwrap();
    // Ten for training, two for validation, two of the scenario's own.
    assert_eq!(trials.len(), 14);
    for trial in trials {
        let path = out.join(trial["file"].as_str().unwrap());
        let (read, findings) = touchdown_log::read_trial(&path, None).unwrap();
        assert_eq!(read.len() as u64, trial["rows"].as_u64().unwrap());
        assert!(!findings.is_lossy());
    }
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "sets = []\n[[trials]]\nname = \"../evil\"\nduration_s = 1.0\nthrottle = { kind = \"constant\", value = 0.5 }\nplate = { kind = \"constant\", value = 0.2 }\n").unwrap();
    let refused = touchdown()
        .args(["rig", "--quiet", "--out"])
        .arg(folder.path().join("x"))
        .arg(&bad)
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("../evil"));
    assert!(!folder.path().join("x").exists());
}

#[test]
fn prop_printed_settings_are_accepted_again() {
    let folder = tempfile::tempdir().unwrap();
    for of in ["reproduce", "rig", "land", "identify"] {
        let output = touchdown().args(["settings", of]).output().unwrap();
        assert!(output.status.success());
        let path = folder.path().join(format!("{of}.toml"));
        std::fs::write(&path, &output.stdout).unwrap();
        let json = touchdown()
            .args(["settings", of, "--json"])
            .output()
            .unwrap();
        assert!(serde_json::from_slice::<Value>(&json.stdout).is_ok());
    }
    touchdown()
        .args([
            "land",
            "--quiet",
            "--controller",
            "feedback",
            "--trials",
            "1",
            "--out",
        ])
        .arg(folder.path().join("land"))
        .arg(folder.path().join("land.toml"))
        .assert()
        .success();
}

#[test]
fn prop_vertical_landings_take_a_measured_motion_of_the_deck() {
    let folder = tempfile::tempdir().unwrap();
    // 0.05 m at 0.2 Hz, ten rows a second.
    let rows: String = (0..2400)
        .map(|i| 0.1 * f64::from(i))
        .map(|t| {
            format!(
                "{t:.1},{:.6}\n",
                0.05 * (std::f64::consts::TAU * 0.2 * t).sin()
            )
        })
        .collect();
    std::fs::write(folder.path().join("z.csv"), format!("t,z\n{rows}")).unwrap();
    let land = |name: &str, more: &str| {
        let scenario = folder.path().join(format!("{name}.toml"));
        let text = format!(
            "trials = 3\ncontrollers = [\"dynamic\"]\n[series]\nfile = \"z.csv\"\n{more}[series.format]\n\
             time = [{{ column = \"t\", factor = 1.0 }}]\n\
             channels = [{{ axis = \"heave\", column = \"z\", factor = 1.0 }}]\nlongest_step_s = 1.0\n"
        );
        std::fs::write(&scenario, text).unwrap();
        let out = folder.path().join(name);
        let output = touchdown()
            .args(["land", "--quiet", "--json", "--out"])
            .args([&out, &scenario])
            .output()
            .unwrap();
        (output, out)
    };
    let (output, out) = land("sine", "");
    assert!(output.status.success(), "{}", common::text(&output.stderr));
    assert_eq!(json(&output)["landing"]["dynamic"]["trials"], 3);
    // The motion is beside the results, which need no other file.
    let copied = std::fs::read(out.join(touchdown_campaign::measured_deck::SERIES)).unwrap();
    assert_eq!(copied, std::fs::read(folder.path().join("z.csv")).unwrap());

    // 0.05 m at 0.2 Hz has an acceleration of 0.079 m/s².
    let (refused, out) = land("quick", "greatest_acceleration_mps2 = 0.05\n");
    let text = common::text(&refused.stderr);
    assert!(
        !refused.status.success() && text.contains("greatest_acceleration_mps2"),
        "{text}"
    );
    assert!(!out.exists());
}

#[test]
fn regress_a_tide_noise_and_a_frozen_sensor_do_not_make_the_waves() {
    let folder = tempfile::tempdir().unwrap();
    // Waves of 4 and 6 s for ten minutes at 10 Hz, on a rise of 1 mm/s; every other row is 5 mm off.
    let heave = |i: i32, frozen: bool| {
        let hangs = frozen && (2000..2600).contains(&i);
        let row = if hangs { 2000 } else { i };
        let t = 0.1 * f64::from(row);
        let sea = 0.12 * (std::f64::consts::TAU * t / 4.0).sin()
            + 0.12 * (std::f64::consts::TAU * t / 6.0).sin();
        let noise = if i % 2 == 0 { 0.0025 } else { -0.0025 };
        sea + 0.0001 * f64::from(row) + if frozen { 0.0 } else { noise }
    };
    let land = |name: &str, frozen: bool, more: &str| {
        let rows: String = (0..6000)
            .map(|i| format!("{:.1},{:.6}\n", 0.1 * f64::from(i), heave(i, frozen)))
            .collect();
        std::fs::write(folder.path().join("z.csv"), format!("t,z\n{rows}")).unwrap();
        let scenario = folder.path().join(format!("{name}.toml"));
        let text = format!(
            "trials = 1\ncontrollers = [\"dynamic\"]\n[series]\nfile = \"z.csv\"\n{more}[series.format]\n\
             time = [{{ column = \"t\", factor = 1.0 }}]\n\
             channels = [{{ axis = \"heave\", column = \"z\", factor = 1.0 }}]\nlongest_step_s = 1.0\n"
        );
        std::fs::write(&scenario, text).unwrap();
        let output = touchdown()
            .args(["land", "--quiet", "--out"])
            .args([&folder.path().join(name), &scenario])
            .output()
            .unwrap();
        assert_eq!(
            output.status.success(),
            !frozen,
            "{}",
            common::text(&output.stderr)
        );
        common::text(&output.stderr).to_owned()
    };
    // 4 standard deviations of both waves are 0.48 m; smoothing takes up to 4 of the noise, 2 cm.
    let text = land("plain", false, "");
    assert!(text.contains("significant height 0.4"), "{text}");
    assert!(text.contains("smoothed at"), "{text}");
    // The line through rise and waves is some cm flatter than the rise of 0.6 m.
    assert!(
        text.contains("heave slower than 60 s, 0.5")
            || text.contains("heave slower than 60 s, 0.6"),
        "{text}"
    );
    assert!(!text.contains("warning"), "{text}");
    // As it was recorded: the rise counts, and the noise makes 5 m/s² where the waves have 0.43.
    let text = land(
        "raw",
        false,
        "cutoff_hz = \"off\"\nlongest_period_s = inf\n",
    );
    assert!(text.contains("significant height 0.8"), "{text}");
    assert!(
        text.contains("not smoothed") && !text.contains("left out"),
        "{text}"
    );
    assert!(
        text.contains("Are these short waves? If they are noise, set cutoff_hz = "),
        "{text}"
    );
    // The sensor hangs for a minute, and steps at its end: more than gravity.
    let text = land("frozen", true, "");
    assert!(
        text.contains("no motion from 200.0 to 259.9 s (from row 2001)"),
        "{text}"
    );
}
