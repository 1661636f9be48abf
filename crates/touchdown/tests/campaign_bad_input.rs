//! Sweeps that make no sense: one error with file, key and value, and nothing written.

use crate::common;
use std::path::{Path, PathBuf};

fn sweep(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("sweep.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn prop_bad_sweeps_are_one_error_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::write(
        folder.path().join("gap.csv"),
        "t,z\n0,0\n1,0.1\n2,0.2\n30,0.1\n31,0\n",
    )
    .unwrap();
    let series = |file: &str| {
        format!(
            "[series]\nfile = \"{file}\"\n[series.format]\ntime = [{{ column = \"t\", factor = 1.0 }}]\n\
             channels = [{{ axis = \"heave\", column = \"z\", factor = 1.0 }}]\nlongest_step_s = 2.0\n"
        )
    };
    // Millimetres, said to be metres.
    std::fs::write(
        folder.path().join("unit.csv"),
        "t,z\n0,0\n1,100\n2,-200\n3,100\n4,0\n",
    )
    .unwrap();
    let (gap, absent) = (series("gap.csv"), series("absent.csv"));
    let unit = series("unit.csv");
    let cases: &[(&str, i32, &[&str])] = &[
        ("colour = 1\n", 2, &["sweep.toml", "colour", "line 1"]),
        ("trials = 0\n", 2, &["sweep.toml", "trials", "found 0"]),
        ("block = 0\n", 2, &["sweep.toml", "block", "found 0"]),
        (
            "[grid]\n\"wind.colour\" = [1]\n",
            2,
            &["sweep.toml", "wind.colour", "unknown key"],
        ),
        (
            "[grid]\n\"timeout_s\" = [10.0, \"long\"]\n",
            2,
            &["sweep.toml", "timeout_s", "long", "a number"],
        ),
        (
            "[grid]\n\"timeout_s\" = [10.0, -1.0]\n",
            2,
            &["sweep.toml", "timeout_s", "-1"],
        ),
        // A deck that lies still has no waves.
        (
            "[grid]\n\"deck.spectrum.significant_height_m\" = [0.3, 2.0]\n",
            2,
            &["sweep.toml", "unknown key", "spectrum"],
        ),
        (
            "[scenario.plant]\nmass_kg = nan\n",
            2,
            &["sweep.toml", "plant.mass_kg", "NaN"],
        ),
        (
            "[scenario.deck]\nkind = \"sines\"\ntones = [{ axis = \"roll\", amplitude = 3.0, frequency_hz = 0.2 }]\n",
            2,
            &["sweep.toml", "tones.amplitude", "found 3"],
        ),
        (
            "[scenario]\nstart_m = [200.0, 0.0, 1.0]\n",
            2,
            &["sweep.toml", "start_m", "found 200"],
        ),
        (
            "[grid]\n\"control.controller\" = [\"magic\"]\n",
            2,
            &["control.controller", "magic", "dynamic+observer"],
        ),
        (
            "[grid]\n\"timeout_s\" = []\n",
            2,
            &["grid.timeout_s", "empty"],
        ),
        (
            "[grid]\n\"timeout_s\" = 3.0\n",
            2,
            &["grid.timeout_s", "list", "found 3.0"],
        ),
        (
            "[grid]\n\"timeout_s\" = [20.0, 20.0]\n",
            2,
            &["grid.timeout_s", "stands twice"],
        ),
        (
            "[grid]\n\"start_m.7\" = [0.0]\n",
            2,
            &["start_m.7", "below 3"],
        ),
        (
            "[grid]\n\"wind\" = [{}]\n\"wind.steady_mps\" = [[0.0, 0.0, 0.0]]\n",
            2,
            &["wind.steady_mps", "swept twice"],
        ),
        (
            "[random]\n\"timeout_s\" = { kind = \"uniform\", min = 9.0, max = 2.0 }\n",
            2,
            &["random.timeout_s", "9", "2"],
        ),
        (
            "[random]\n\"timeout_s\" = { kind = \"gauss\" }\n",
            2,
            &["random.timeout_s", "gauss", "normal"],
        ),
        (
            "[random]\n\"timeout_s\" = 4.0\n",
            2,
            &["random.timeout_s", "distribution"],
        ),
        (
            "[random]\n\"plant.mass_kg\" = { kind = \"choice\", of = [1.3, -2.0] }\n",
            2,
            &["plant.mass_kg", "-2"],
        ),
        // No trial may happen to draw it: what is said to be possible has to be.
        (
            "trials = 1\n[random]\n\"plant.mass_kg\" = { kind = \"uniform\", min = -0.001, max = 2.0 }\n",
            2,
            &["plant.mass_kg", "-0.001"],
        ),
        (
            "[scenario.plant]\nmass_kg = -1.0\n",
            2,
            &["sweep.toml", "mass_kg", "-1"],
        ),
        (
            "[scenario.deck]\nkind = \"sea\"\n[scenario.deck.spectrum]\nshape = \"jonswap\"\nsignificant_height_m = 0.5\n",
            2,
            &["sweep.toml", "peak_period_s"],
        ),
        (
            "[cards]\nthrust = \"no-such-card.toml\"\n",
            2,
            &["no-such-card.toml"],
        ),
        (
            "[scenario.body]\ninertia_kg_m2 = [0.01, -0.02, 0.03]\n",
            2,
            &["sweep.toml", "inertia_kg_m2", "-0.02"],
        ),
        (
            "[scenario]\ncontrol_period_s = 0.0\n",
            2,
            &["sweep.toml", "control_period_s", "found 0"],
        ),
        (
            "[scenario]\nstart_m = [0.0, 0.0, -0.2]\n",
            2,
            &["sweep.toml", "start_m", "landed_height_m", "-0.2"],
        ),
        (&gap, 2, &["gap.csv", "row 4", "28"]),
        (&unit, 2, &["unit.csv", "heave", "100", "15"]),
        (&absent, 1, &["absent.csv"]),
    ];
    for (text, status, named) in cases {
        let sweep = sweep(folder.path(), text);
        let said = common::fails(
            *status,
            [
                "campaign".as_ref(),
                sweep.as_os_str(),
                "--out".as_ref(),
                out.as_os_str(),
            ],
        );
        for name in *named {
            assert!(said.contains(name), "{text}: `{name}` is not in: {said}");
        }
        assert!(!out.exists(), "{text}");
    }
    // A folder for records that is none is found before anything is flown for it.
    let good = sweep(folder.path(), "trials = 1\n");
    let (flown, taken) = (folder.path().join("flown"), folder.path().join("gap.csv"));
    for command in [vec!["campaign"], vec!["land", "--space"]] {
        let mut words: Vec<&std::ffi::OsStr> = command.iter().map(AsRef::as_ref).collect();
        words.extend([good.as_os_str(), "--mcap".as_ref(), taken.as_os_str()]);
        words.extend(["--out".as_ref(), flown.as_os_str()]);
        let said = common::fails(2, words);
        assert!(
            said.contains("gap.csv") && said.contains("expected a folder"),
            "{said}"
        );
        assert!(!flown.join("landings.csv").exists());
        assert!(!flown.join("landings/block-000000.parquet").exists());
    }
    let sweep = sweep(folder.path(), "trials = 1\n");
    for shard in ["5/4", "0/2", "x"] {
        let said = common::fails(
            2,
            [
                "campaign".as_ref(),
                sweep.as_os_str(),
                "--shard".as_ref(),
                shard.as_ref(),
            ],
        );
        assert!(
            said.contains("I from 1 to N") && said.contains(shard),
            "{said}"
        );
    }
}

#[test]
fn regress_no_other_command_writes_into_the_folder_of_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), "trials = 1\n[scenario]\ntimeout_s = 1.0\n");
    let campaign = folder.path().join("campaign");
    let into = |words: &[&str], out: &Path| {
        let words = words.iter().map(std::ffi::OsStr::new);
        let words: Vec<_> = words.chain(["--out".as_ref(), out.as_os_str()]).collect();
        words
            .iter()
            .map(|word| (*word).to_owned())
            .collect::<Vec<_>>()
    };
    let path = sweep.to_str().unwrap();
    assert!(
        common::run(into(&["campaign", path], &campaign))
            .status
            .success()
    );
    let names = ["sweep.toml", "results.json", "summary.csv", "report.html"];
    let files = || names.map(|name| std::fs::read(campaign.join(name)).unwrap());
    let before = files();
    for command in [
        &["land", "--trials", "1"][..],
        &["land", "--space", "--trials", "1"],
        &["rig"],
        &["reproduce"],
    ] {
        let said = common::fails(2, into(command, &campaign));
        let words = ["contains a campaign", "choose another folder"];
        assert!(
            words.iter().all(|word| said.contains(word)),
            "{command:?}: {said}"
        );
        assert!(files() == before && !campaign.join("landings.csv").exists());
    }
    // The folder of earlier landings is written again.
    let landings = folder.path().join("landed");
    for _ in 0..2 {
        let command = ["land", "--space", path];
        assert!(common::run(into(&command, &landings)).status.success());
    }
}

/// What the command says of a sweep that it refuses.
fn refused(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let sweep = sweep(folder.path(), text);
    let out = folder.path().join("out");
    let words = [
        "campaign".as_ref(),
        sweep.as_os_str(),
        "--out".as_ref(),
        out.as_os_str(),
    ];
    common::fails(2, words)
}

#[test]
fn regress_the_limit_of_points_is_checked_before_values_are_compared() {
    let values = ["20.0, "; 100_001].concat();
    let said = refused(&format!("[grid]\n\"timeout_s\" = [{values}]\n"));
    assert!(
        said.contains("at most 100000 points, found 100001"),
        "{said}"
    );
}

#[test]
fn regress_errors_of_swept_values_name_the_key_as_it_was_written() {
    let sea = "trials = 1\n[scenario.deck]\nkind = \"sea\"\n[grid]\n\"deck.spectrum.signifcant_height_m\" = [1.0]\n";
    let said = refused(sea);
    assert!(
        said.contains("key `deck.spectrum.signifcant_height_m`: unknown key"),
        "{said}"
    );
    let said = refused("[grid]\n\"control.controller\" = [\"dynamic\", 3]\n");
    assert!(
        said.contains("key `control.controller`: expected a text, found another value"),
        "{said}"
    );
    let said = refused("[scenario.faults]\ntag_lost = { from_s = 1.0, to_s = 2.0 }\n");
    assert!(
        said.contains("`scenario.faults.tag_lost`: expected a list, found a table"),
        "{said}"
    );
    let said = refused("[scenario]\ntruth.thrust = 0.01\n");
    assert!(said.contains("setting `truth.thrust`"), "{said}");
}

#[test]
fn regress_settings_that_others_replace_are_refused() {
    let said = refused("[grid]\n\"control.relative.range.quantum_m\" = [0.01, 0.05]\n");
    assert!(
        said.contains("`sensors.range.quantum_m` replaces it, found 0.05"),
        "{said}"
    );
}
