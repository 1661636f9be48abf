//! Requests as a worker sends them, on this machine's own file system.

use std::path::Path;

use serde_json::{Value, json};

fn ask(request: &Value) -> Result<Value, String> {
    let answer: Value =
        serde_json::from_str(&touchdown_web::answer(&request.to_string(), &|_| {})).unwrap();
    match answer.get("error") {
        Some(error) => Err(error.as_str().unwrap().to_string()),
        None => Ok(answer["result"].clone()),
    }
}

/// A thrust stand's table: T = 20 σ², in columns of other names and units.
fn stand(folder: &Path) -> String {
    let path = folder.join("stand.csv");
    let rows: String = (0..=20)
        .map(|k| {
            let throttle = 0.2 + 0.03 * f64::from(k);
            format!(
                "{k},{},{}\n",
                1000.0 + 1000.0 * throttle,
                20.0 * throttle * throttle
            )
        })
        .collect();
    std::fs::write(&path, format!("t,ESC (us),Thrust (N)\n{rows}")).unwrap();
    path.display().to_string()
}

const MAP: &str = r#"
schema = 1
[channels]
time_s = 't'
throttle = '("ESC (us)" - 1000) / 1000'
thrust_n = '"Thrust (N)"'
"#;

#[test]
fn analytic_a_table_becomes_channels_and_a_card() {
    let folder = tempfile::tempdir().unwrap();
    let log = stand(folder.path());
    let seen = ask(&json!({ "task": "inspect", "log": log, "map": null })).unwrap();
    assert_eq!(seen["table"]["rows"], 21);
    assert!(seen["channels"].is_null());
    let seen = ask(&json!({ "task": "inspect", "log": log, "map": MAP })).unwrap();
    assert_eq!(seen["preview"].as_array().unwrap().len(), 2);
    let fit = json!({ "task": "identify_thrust", "logs": [log], "map": MAP, "settings": "" });
    let found = ask(&fit).unwrap();
    let card = &found["cards"][0];
    assert_eq!(card["card"]["kind"], "thrust");
    // The data have no noise, and a curve over throttle holds them.
    assert!(card["rmse"].as_f64().unwrap() < 1e-6, "{}", card["rmse"]);
    let curve = &found["figures"][0][0]["series"][1];
    for (s, t) in curve["x"]
        .as_array()
        .unwrap()
        .iter()
        .zip(curve["y"].as_array().unwrap())
    {
        let (s, t) = (s.as_f64().unwrap(), t.as_f64().unwrap());
        assert!((t - 20.0 * s * s).abs() < 1e-3, "{s}: {t}");
    }
}

#[test]
fn regress_errors_are_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let log = stand(folder.path());
    for (request, part) in [
        (json!({ "task": "dance" }), "not understood"),
        (
            json!({ "task": "inspect", "log": "nowhere.csv", "map": null }),
            "nowhere.csv",
        ),
        (
            json!({ "task": "inspect", "log": log, "map": "schema = 9" }),
            "schema",
        ),
        (
            json!({ "task": "identify_ground_effect", "data": { "logs": [log], "map": MAP }, "thrust": null }),
            "thrust card",
        ),
        (
            json!({ "task": "identify_thrust", "logs": [log], "map": MAP, "settings": "[flight]\nmas_kg = 1.0" }),
            "mas_kg",
        ),
    ] {
        let error = ask(&request).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn prop_a_landing_in_a_block_is_the_landing_alone() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = folder.path().join("sweep.toml");
    let text = "seed = 3\ntrials = 10\n[scenario.deck]\nkind = \"sines\"\ntones = [{ axis = \"heave\", amplitude = 0.1, frequency_hz = 0.3 }]\n";
    std::fs::write(&sweep, text).unwrap();
    let rows = ask(&json!({ "task": "landings", "sweep": sweep, "from": 1, "to": 3 })).unwrap();
    let one = ask(&json!({ "task": "land", "sweep": sweep, "landing": 2 })).unwrap();
    assert_eq!(rows[1], one["row"]);
    let frames = &one["frames"];
    let count = frames["time_s"].as_array().unwrap().len();
    assert!(count > 100, "{count}");
    for (name, of) in frames.as_object().unwrap() {
        assert_eq!(of.as_array().unwrap().len(), count, "{name}");
    }
    let beyond = ask(&json!({ "task": "land", "sweep": sweep, "landing": 10 }));
    assert_eq!(
        beyond.unwrap_err(),
        "expected a landing from 0 to 9, found 10"
    );
}

#[test]
fn regress_examples_are_logs_that_the_lab_reads() {
    let folder = tempfile::tempdir().unwrap();
    for (name, channel) in [("rig", "thrust_n"), ("flights", "specific_force_mps2")] {
        let names = ask(&json!({ "task": "example", "name": name, "out": folder.path() })).unwrap();
        let log = folder.path().join(names[0].as_str().unwrap());
        let seen = ask(&json!({ "task": "inspect", "log": log, "map": null })).unwrap();
        let columns = seen["channels"]["columns"].as_array().unwrap();
        assert!(
            columns.iter().any(|c| c["name"] == channel),
            "{name}: {columns:?}"
        );
    }
}
