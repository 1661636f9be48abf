//! `touchdown reproduce` as a command: what it writes, and that threads do not matter.

#![allow(clippy::unwrap_used)]

use crate::common;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn reproduce(out: &Path, threads: &str, seed: &str) -> String {
    Command::cargo_bin("touchdown")
        .unwrap()
        .env("RAYON_NUM_THREADS", threads)
        .args([
            "reproduce",
            "--quick",
            "--trials",
            "3",
            "--quiet",
            "--seed",
            seed,
            "--out",
        ])
        .arg(out)
        .assert()
        .success();
    std::fs::read_to_string(out.join("results.json")).unwrap()
}

#[test]
fn prop_results_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let one = reproduce(&folder.path().join("one"), "1", "7");
    let three = reproduce(&folder.path().join("three"), "3", "7");
    assert!(
        one == three,
        "results.json differs between one and three threads"
    );
    let other = reproduce(&folder.path().join("other"), "2", "8");
    assert!(one != other, "another seed must give other results");

    shape(&serde_json::from_str(&one).unwrap());
    files(&folder.path().join("one"));
}

/// The keys that people and programs rely on.
fn shape(results: &Value) {
    assert_eq!(
        (&results["schema"], &results["seed"], &results["trials"]),
        (&1.into(), &7.into(), &3.into())
    );
    assert_eq!(results["settings_sha256"].as_str().unwrap().len(), 64);
    for plate in ["plate_removed", "plate_present"] {
        for model in ["eq7", "eq8"] {
            for trial in ["ramp", "sine"] {
                let error = &results["thrust"][plate][model][trial];
                assert!(
                    error["mae_n"].is_f64() && error["worst_n"].is_f64(),
                    "{plate} {model} {trial}"
                );
            }
        }
    }
    for data in ["paper_data", "rich_data"] {
        for form in ["empirical", "static", "derivative", "ratio", "lag"] {
            for kind in [
                "approach",
                "triangle_low",
                "triangle_mid",
                "sine",
                "fast_approach",
            ] {
                let error = &results["ground_effect"][data][form][kind];
                assert!(
                    error["mae_n"].is_f64() && error["worst_n"].is_f64(),
                    "{data} {form} {kind}"
                );
            }
        }
    }
    fronts(results);
    for method in ["feedback", "empirical", "dynamic"] {
        landing(&results["ground_landing"][method]);
    }
    for column in ["with_acceleration", "without_acceleration"] {
        for method in ["feedback", "empirical", "dynamic", "imbc", "ssc"] {
            landing(&results["deck_landing"][column][method]);
        }
    }
    // No landing: null, never zero.
    let feedback = &results["ground_landing"]["feedback"];
    assert_eq!(feedback["landed"], 0);
    assert!(
        feedback["t_l_s"].is_null() && feedback["v_l_mps"].is_null() && feedback["s_l_m"].is_null()
    );
    for deck in ["paper", "strong", "heave", "sea"] {
        for how in ["planned", "straight_down", "published"] {
            at_sea(&results["sea"]["decks"][deck][how], 3);
        }
    }
    for fault in [
        "tag_lost",
        "range_missing",
        "late",
        "late_unknown",
        "rotor",
        "gust",
        "nan",
    ] {
        at_sea(&results["sea"]["faults"][fault], 2);
    }
    assert!(results["sea"]["series_sha256"].is_null());
    assert_eq!(
        results["published"]["deck_landing"]["dynamic"]["t_l_s"],
        5.38
    );
}

/// Fronts with their proofs: 2048 subsets where vehicle and plate both move, 256 where only the plate does.
fn fronts(results: &Value) {
    let ge = &results["ground_effect"];
    for (front, terms, nodes) in [
        (&ge["fronts"]["paper_data"], 8, 256),
        (&ge["fronts"]["rich_data"], 8, 256),
        (&ge["fronts"]["moving_data"], 11, 2048),
        (&results["thrust"]["fronts"]["plate_removed"], 8, 256),
    ] {
        let certificate = &front["certificate"];
        assert_eq!(certificate["subsets"], f64::from(nodes), "{certificate}");
        assert_eq!(certificate["proven"], true, "{certificate}");
        assert!(certificate["nodes"].as_u64().unwrap() <= nodes as u64);
        let sizes = front["sizes"].as_array().unwrap();
        assert_eq!(sizes.len(), terms + 1);
        let error = |k: usize| sizes[k]["training_rmse"].as_f64().unwrap();
        for k in 1..=terms {
            assert_eq!(sizes[k]["terms"].as_array().unwrap().len(), k);
            assert!(error(k) <= error(k - 1), "more terms never fit worse");
        }
        let model = &front["model"];
        let own = model["terms"].as_u64().unwrap() as usize;
        // Sums of products in two orders.
        assert!(model["training_rmse"].as_f64().unwrap() >= error(own) * (1.0 - 1e-9));
    }
    for data in ["paper_data", "rich_data"] {
        let levels = ge["levels"][data].as_array().unwrap();
        let found: Vec<&str> = levels
            .iter()
            .map(|l| l["model"].as_str().unwrap())
            .collect();
        for model in [
            "static",
            "sr3_to_the_letter",
            "derivative",
            "best_subset",
            "weak_form",
            "refined",
            "ratio",
            "lag",
        ] {
            assert!(found.contains(&model), "{data}: {found:?}");
        }
        let lag = levels.iter().find(|l| l["model"] == "lag").unwrap();
        assert!(lag["free_run_rmse_n"].is_f64() && lag["held_out_rmse_n_per_s"].is_null());
    }
    assert_eq!(
        ge["relative_velocity"]["printed_eq12"]["relative"]["terms"],
        8
    );
}

fn landing(figures: &Value) {
    let object = figures.as_object().unwrap();
    for key in [
        "trials",
        "landed",
        "t_l_s",
        "v_l_mps",
        "s_l_m",
        "hover_height_m",
    ] {
        assert!(object.contains_key(key), "{key}");
    }
    if let Some(t) = figures["t_l_s"].as_object() {
        assert!(t["mean"].is_f64() && t.contains_key("sd") && t.contains_key("ci95"));
    }
}

/// Figures of landings in six degrees of freedom.
fn at_sea(figures: &Value, trials: u64) {
    let count = |key: &str| figures[key]["count"].as_u64().unwrap();
    assert_eq!(figures["trials"], trials, "{figures}");
    assert!(
        count("landed_at_first") <= count("landed") && count("landed") + count("crashed") <= trials
    );
    for key in ["t_l_s", "v_l_mps", "s_l_m", "lateral_m"] {
        // Over those that landed; null, never zero, where none did.
        assert_eq!(figures[key]["count"], count("landed"), "{key}");
        assert_eq!(
            figures[key]["mean"].is_null(),
            count("landed") == 0,
            "{key}"
        );
    }
    assert!(figures["waited_s"]["mean"].is_f64());
}

fn files(out: &Path) {
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let report = common::page(out, common::LARGE_PAGE + common::WATCHED);
    for needed in [
        "Levels of identification side by side",
        "2048 subsets",
        "256 subsets",
        "front-moving-data",
        "front-thrust",
        "half the 95 % interval",
        "What the planner gains over going straight down",
        "Faults above the paper",
        "sea-track",
    ] {
        assert!(report.contains(needed), "the report lacks: {needed}");
    }
    // The plotting library is inside, and the page forbids itself to load anything from anywhere.
    assert!(report.contains("Plotly"));
    assert!(report.contains("Content-Security-Policy") && report.contains("default-src 'none'"));
    for (folder, ending, least) in [
        ("cards", "toml", 19),
        ("figures", "svg", 5),
        ("figures", "png", 5),
    ] {
        let count = std::fs::read_dir(out.join(folder))
            .unwrap()
            .filter(|f| {
                f.as_ref()
                    .unwrap()
                    .path()
                    .extension()
                    .is_some_and(|e| e == ending)
            })
            .count();
        assert!(count >= least, "{count} .{ending} in {folder}");
    }
    for entry in std::fs::read_dir(out.join("cards")).unwrap() {
        let card = touchdown_model::Card::read(&entry.unwrap().path()).unwrap();
        let fitted = card.status == touchdown_model::Status::Fitted;
        assert_eq!(card.provenance.seed, fitted.then_some(7));
        for term in &card.terms {
            // An interval where there is a standard error, around the value.
            assert_eq!(
                term.ci95.is_some(),
                term.std_error.is_some(),
                "{}",
                card.name
            );
            assert!(
                term.ci95
                    .is_none_or(|[low, high]| low <= term.value && term.value <= high)
            );
        }
    }
    let settings: touchdown_reproduce::settings::ReproduceSettings =
        touchdown::settings::read(&out.join("settings.toml")).unwrap();
    assert_eq!(
        (settings.seed, settings.trials, settings.quick),
        (7, 3, true)
    );
    // Header, and 3 + 5 + 5 methods of 3 trials.
    assert_eq!(read("landings.csv").lines().count(), 1 + 13 * 3);
    // Header, four decks flown in three ways and seven faults.
    assert_eq!(read("sea.csv").lines().count(), 1 + 4 * 3 * 3 + 7 * 2);
    let leftovers = walk(out).into_iter().filter(|p| {
        p.file_name()
            .is_some_and(|n| n.to_string_lossy().starts_with('.'))
    });
    assert_eq!(leftovers.count(), 0, "temporary files are left behind");
}

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(walk(&path));
        } else {
            out.push(path);
        }
    }
    out
}

#[test]
fn prop_bad_input_is_one_error_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let settings = folder.path().join("s.toml");
    let cases = [
        ("colour = 3\n", "colour", 2),
        ("seed = \"one\"\n", "seed", 2),
        ("trials = 0\n", "trials", 2),
        ("[rig.plant]\nmass_kg = -1.37\n", "-1.37", 2),
        (
            "[deck_landing.scenario.deck]\nkind = \"sine\"\namplitude_m = 0.6\nfrequency_hz = 0.5\n",
            "start height",
            2,
        ),
        ("[identification.smoothing]\nwindow = 40\n", "window", 2),
        (
            "[identification.thrust]\nlibrary = [\"1\", \"x +\"]\n",
            "x +",
            2,
        ),
        (
            "[sea.scenario.body]\ninertia_kg_m2 = [0.01, -0.02, 0.03]\n",
            "-0.02",
            2,
        ),
        (
            "[sea.wave.spectrum]\npeak_period_s = 0.0\n",
            "peak_period_s",
            2,
        ),
        ("this is not TOML\n", "line 1", 2),
    ];
    for (text, named, status) in cases {
        std::fs::write(&settings, text).unwrap();
        let output = Command::cargo_bin("touchdown")
            .unwrap()
            .args(["reproduce", "--quick", "--quiet", "--settings"])
            .arg(&settings)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).to_string();
        assert_eq!(output.status.code(), Some(status), "{text}: {said}");
        assert!(
            said.contains(named) && said.contains("s.toml"),
            "{text}: {said}"
        );
        assert_eq!(said.matches("error:").count(), 1, "{said}");
        assert!(!out.exists(), "{text}: something was written");
    }
    Command::cargo_bin("touchdown")
        .unwrap()
        .args(["reproduce", "--settings", "/no/such/file.toml"])
        .assert()
        .code(2);
    Command::cargo_bin("touchdown")
        .unwrap()
        .args(["reproduce", "--colour"])
        .assert()
        .code(2);
    // A file where the folder should be.
    std::fs::write(folder.path().join("file"), "x").unwrap();
    Command::cargo_bin("touchdown")
        .unwrap()
        .args(["reproduce", "--quick", "--quiet", "--out"])
        .arg(folder.path().join("file"))
        .assert()
        .code(2);
}
