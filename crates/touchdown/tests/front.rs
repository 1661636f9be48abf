//! `touchdown identify` shows the front of sparse fits, intervals, and the levels side by side.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::common::json;
use serde_json::Value;
use touchdown_identify::{IdentificationSettings, Origin, thrust};
use touchdown_sim::rig::sets::{self, Extent};
use touchdown_sim::rig::{self, RigSettings, RigTrial};

/// Records short trials as logs, and gives their paths.
fn logs(folder: &std::path::Path, trials: Vec<RigTrial>) -> Vec<PathBuf> {
    let record = |trial: RigTrial| {
        let short = RigTrial {
            duration_s: 12.0,
            ..trial
        };
        let trial = rig::run(&RigSettings::default(), &short, 1).unwrap();
        let path = folder.join(format!("{}.csv", trial.name()));
        touchdown_log::write_csv(&trial, &path).unwrap();
        path
    };
    trials.into_iter().map(record).collect()
}

fn thrust_card(folder: &std::path::Path) -> PathBuf {
    let record = |t: RigTrial| rig::run(&RigSettings::default(), &t, 1).unwrap();
    let trials: Vec<_> = sets::thrust_training(false, Extent::Quick)
        .into_iter()
        .map(record)
        .collect();
    let settings = IdentificationSettings::default();
    let card = thrust::first_order(&trials, &settings, &Origin::default())
        .unwrap()
        .card;
    let path = folder.join("thrust.toml");
    card.write(&path).unwrap();
    path
}

#[test]
fn prop_ground_effect_reports_front_intervals_and_levels() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let thrust = thrust_card(folder.path());
    let logs = logs(folder.path(), sets::ground_effect_moving(Extent::Quick));
    assert!(logs.len() >= 5, "enough to hold one out");
    let mut args: Vec<OsString> = ["identify", "ground-effect"].map(OsString::from).into();
    args.extend(logs.iter().map(OsString::from));
    args.extend([
        "--thrust".into(),
        thrust.into(),
        "--out".into(),
        out.clone().into(),
    ]);
    let found = json(0, args);
    let derivative = found
        .as_array()
        .unwrap()
        .iter()
        .find(|m| m["form"] == "derivative")
        .unwrap();
    // Vehicle and plate both move: no term is zero throughout.
    let front = &derivative["front"];
    assert_eq!(front["certificate"]["subsets"], 2048.0);
    assert_eq!(front["certificate"]["proven"], true);
    assert_eq!(front["sizes"].as_array().unwrap().len(), 12);
    let lag = found
        .as_array()
        .unwrap()
        .iter()
        .find(|m| m["form"] == "lag")
        .unwrap();
    assert!(lag["front"].is_null());
    for (name, c) in lag["coefficients"].as_object().unwrap() {
        // Eight trials carry seven coefficients: an interval around each, unless it sits at its bound.
        if !c["std_error"].is_null() {
            let (low, high) = (
                c["ci95"][0].as_f64().unwrap(),
                c["ci95"][1].as_f64().unwrap(),
            );
            let value = c["value"].as_f64().unwrap();
            assert!(low < value && value < high, "{name}: {c}");
        }
    }
    let text = std::fs::read_to_string(out.join("results.json")).unwrap();
    let results: Value = serde_json::from_str(&text).unwrap();
    let levels = results["levels"].as_array().unwrap();
    let of = |model: &str| levels.iter().find(|l| l["model"] == model).unwrap();
    for model in ["sr3_to_the_letter", "derivative", "best_subset", "refined"] {
        assert!(
            of(model)["held_out_rmse_n_per_s"].is_f64(),
            "{model}: {levels:?}"
        );
    }
    assert!(of("lag")["free_run_rmse_n"].is_f64());
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    for needed in ["2048 subsets", "95 % interval", "Levels of identification"] {
        assert!(report.contains(needed), "the report lacks: {needed}");
    }
    assert!(
        out.join("figures/front-ground-effect-derivative.svg")
            .exists()
    );
}
