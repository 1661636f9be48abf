//! Logs of PX4 and ArduPilot against other readers and documented facts. The data are looked for
//! in the folder that the environment variable `TOUCHDOWN_DATA` names, by default beside the
//! workspace; without them the tests say that they were skipped.
#![allow(clippy::print_stderr)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use touchdown_log::{Log, Map, Survey, read_trial};

fn data(file: &str) -> Option<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::var_os("TOUCHDOWN_DATA")
        .map_or_else(|| workspace.join("../shared/data"), PathBuf::from);
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no data at {}", path.display());
    None
}

fn survey(path: &Path) -> Survey {
    let log = Log::open(path).unwrap().expect("a log with topics");
    let (survey, findings) = log.survey().unwrap();
    assert!(!findings.is_lossy(), "{findings:?}");
    survey
}

/// Number of messages and sum of the finite values of a topic, stamps left out as the other side
/// does.
fn count_and_sum(
    survey: &Survey,
    name: &str,
    instance: u32,
    is_ulog: bool,
) -> Option<(usize, f64)> {
    let mut topics = survey.topics.iter();
    let topic = topics.find(|topic| topic.name == name && topic.instance == instance)?;
    let fields = topic.fields.iter();
    let counted = fields.filter(|field| !(is_ulog && field.name == "timestamp"));
    // The other side gives the mode of a vehicle as text.
    let counted = counted.filter(|field| !(name == "MODE" && field.name == "Mode"));
    Some((topic.messages, counted.map(|field| field.sum).sum()))
}

/// Counts equal and sums within 1e-9 of those that pyulog 1.3.0 and pymavlink 2.4.50 give
/// (`tests/reference/make.py`). Sums of up to 1e6 numbers in another order differ by some 1e-11;
/// of floats scaled by 0.01 on the other side and divided by 100 here, as much again.
#[test]
fn xval_counts_and_sums_of_every_topic() {
    let folders = BTreeMap::from([("ulg", "log-px4-ulog"), ("bin", "log-ardupilot-dataflash")]);
    let mut surveys: BTreeMap<String, Survey> = BTreeMap::new();
    let mut compared = BTreeMap::new();
    for line in include_str!("reference/counts.tsv").lines() {
        let cells: Vec<&str> = line.split('\t').collect();
        let [kind, file, topic, instance, messages, sum] = cells[..] else {
            panic!("{line}");
        };
        let Some(path) = data(&format!("{}/{file}", folders[kind])) else {
            return;
        };
        let survey = surveys
            .entry(file.to_owned())
            .or_insert_with(|| survey(&path));
        let instance = instance.parse().unwrap();
        let (found, total) = count_and_sum(survey, topic, instance, kind == "ulg")
            .unwrap_or_else(|| panic!("{file} has no {topic} {instance}"));
        assert_eq!(found, messages.parse::<usize>().unwrap(), "{line}");
        let sum: f64 = sum.parse().unwrap();
        assert!(
            (total - sum).abs() <= 1e-9 * sum.abs().max(1.0),
            "{line}: {total}"
        );
        *compared.entry(file.to_owned()).or_insert(0) += 1;
    }
    for (file, survey) in &surveys {
        // The other side leaves out topics without a message.
        let heard = survey.topics.iter().filter(|topic| topic.messages > 0);
        assert_eq!(
            compared[file],
            heard.count(),
            "{file}: topics the other side lacks"
        );
    }
}

/// The number of records that the data's own description gives.
#[test]
fn xval_a_copters_log_has_the_documented_records() {
    let Some(path) = data("log-ardupilot-dataflash/log171.bin") else {
        return;
    };
    let survey = survey(&path);
    assert_eq!(survey.topic("RCOU").unwrap().messages, 11_916);
    assert_eq!(survey.topic("CTUN").unwrap().messages, 2_383);
    // Its receiver stamps by the time of the week, 7 days from the vehicle's.
    assert!(survey.duration_s < 300.0, "{}", survey.duration_s);
    assert_eq!(survey.parameters.len(), 491);
    assert_eq!(survey.parameters["MOT_THST_EXPO"], f64::from(0.8_f32));
}

#[test]
fn xval_hover_of_a_copter() {
    let Some(path) = data("log-ardupilot-dataflash/log171.bin") else {
        return;
    };
    let map = Map::parse(
        "hover.toml",
        "schema = 1\nclock = 'CTUN'\n[channels]\ntime_s = 'time_s'\nout = 'CTUN.ThrOut'\n[[windows]]\nfrom_s = 200\nto_s = 217\n",
    )
    .unwrap();
    let (trial, _) = read_trial(&path, Some(&map)).unwrap();
    let out = trial.require("out").unwrap();
    let mean = out.iter().sum::<f64>() / out.len() as f64;
    // The steady end of the loiter, before the mode changes at 217.2 s.
    assert!((mean - 395.0).abs() < 5.0, "{mean}");

    // By the built-in map. From pymavlink: the mean of Ch1 to Ch4 is 1484.7278 µs in a range of
    // 1000 to 1900 (RC3_MIN, RC3_MAX), that of AccZ -9.572072911517052 m/s², that of Volt
    // 1532.54 in 0.01 V at 10 Hz.
    let (trial, findings) = read_trial(&path, None).unwrap();
    let window = trial.window(200.0, 217.0).unwrap();
    let mean = |name: &str| {
        let values = window.require(name).unwrap();
        values.iter().sum::<f64>() / values.len() as f64
    };
    assert_eq!(window.len(), 843);
    assert!((mean("specific_force_mps2") - 9.572_072_911_517_052).abs() < 1e-12);
    // Motors and accelerometer are logged together; a stamp may differ by one sample of 843.
    assert!((mean("throttle") - 484.727_8 / 900.0).abs() < 1e-3);
    // 10 Hz held at 50 Hz: the ends weigh differently by some samples.
    assert!((mean("battery_v") - 15.3254).abs() < 2e-3);
    let told = |text: &str| {
        findings
            .warnings
            .iter()
            .any(|warning| warning.contains(text))
    };
    assert!(told("height_m: omitted"), "{findings:?}");
    assert!(
        told("rotor_rpm: omitted, because there is no ESC"),
        "{findings:?}"
    );
    assert!(trial.channel("height_m").is_none() && trial.channel("rotor_rpm").is_none());
}

/// Means of 22 s to 26 s from pyulog: four motors at 10 Hz 0.478662, accelerometer at 250 Hz
/// -9.588048779166543 m/s².
#[test]
fn xval_channels_of_a_simulated_flight() {
    let Some(path) = data("log-px4-ulog/sample_px4_events.ulg") else {
        return;
    };
    let (trial, findings) = read_trial(&path, None).unwrap();
    assert!(!findings.is_lossy());
    assert_eq!(trial.len(), 7783);
    let window = trial.window(22.0, 26.0).unwrap();
    let mean = |name: &str| {
        let values = window.require(name).unwrap();
        values.iter().sum::<f64>() / values.len() as f64
    };
    assert!((mean("specific_force_mps2") - 9.588_048_779_166_543).abs() < 1e-12);
    // Held at 250 Hz, the ends weigh differently: one sample in 40, which differ by 0.02.
    assert!((mean("throttle") - 0.478_662).abs() < 1e-3);
    // vz at 23.91 s is 0.7428 m/s, down.
    let row = trial.time_s().partition_point(|&t| t < 23.91);
    let speed = trial.require("vehicle_velocity_mps").unwrap()[row];
    assert!((speed + 0.742_8).abs() < 0.01, "{speed}");
    // There is a height only where PX4 holds its distance to the ground for valid.
    let height = trial.require("height_m").unwrap();
    assert!(height[row].is_nan() && (height[250] - 0.09).abs() < 0.02);
    let tilt = trial.require("tilt_rad").unwrap();
    assert!(tilt.iter().all(|tilt| tilt.is_nan() || *tilt < 0.02));
}
