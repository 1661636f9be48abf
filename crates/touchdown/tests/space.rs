//! `touchdown land --space`: the whole vehicle, its records, and a detector that looks at rendered images.

use crate::common;
use std::path::Path;

use serde_json::Value;
use touchdown::settings::parse;
use touchdown_campaign::recording;
use touchdown_campaign::sweep::{Sweep, replay, rows};
use touchdown_log::Log;

/// Starts low over a deck at rest, to be short.
const SHORT: &str = "trials = 1\n[scenario]\nstart_m = [0.0, 0.0, 0.5]\ncontrol.watch_s = 1.0\n";

fn results(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("results.json")).unwrap()).unwrap()
}

#[test]
fn prop_landings_in_space_are_those_of_the_campaign_that_is_written_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("s.toml"), SHORT).unwrap();
    let [file, out, mcap, ulog] = [at("s.toml"), at("out"), at("mcap"), at("ulog")];
    let output = common::run([
        "land".as_ref(),
        "--space".as_ref(),
        "--json".as_ref(),
        file.as_os_str(),
        "--trials".as_ref(),
        "2".as_ref(),
        "--controller".as_ref(),
        "observer".as_ref(),
        "--controller".as_ref(),
        "dynamic+observer".as_ref(),
        "--mcap".as_ref(),
        mcap.as_os_str(),
        "--ulog".as_ref(),
        ulog.as_os_str(),
        "--out".as_ref(),
        out.as_os_str(),
    ]);
    assert!(output.status.success(), "{}", common::text(&output.stderr));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed, results(&out), "what is printed is what is written");
    let points = printed["points"].as_array().unwrap();
    let flown: Vec<&Value> = points.iter().map(|p| &p["controller"]).collect();
    assert_eq!(flown, ["observer", "dynamic+observer"]);
    assert!(
        points.iter().all(|p| p["landed"]["count"] == 2),
        "{points:?}"
    );
    let table = std::fs::read_to_string(out.join("landings.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 4);
    assert!(table.starts_with("control.controller,trial,outcome,"));
    common::page(&out, common::CAMPAIGN_PAGE);
    for landing in 0..4 {
        let bytes = std::fs::read(mcap.join(format!("landing-{landing:06}.mcap"))).unwrap();
        let messages: Vec<_> = mcap::MessageStream::new(&bytes)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        // Poses, deck, forces, estimate and phase a hundred times a second, for some seconds.
        assert!(messages.len() > 9 * 200);
        for message in messages {
            let schema = message.channel.schema.as_ref().expect("a schema");
            let of = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).unwrap();
            let topic = &message.channel.topic;
            common::fits(&of(&schema.data), &of(&message.data), topic);
        }
        let path = ulog.join(format!("landing-{landing:06}.ulg"));
        let log = Log::open(path).unwrap().expect("a log");
        assert_eq!(log.survey().unwrap().0.recommended_map(), Some("px4"));
    }
    let again = at("again");
    let sweep = out.join("sweep.toml");
    let output = common::run([
        "campaign".as_ref(),
        sweep.as_os_str(),
        "--out".as_ref(),
        again.as_os_str(),
    ]);
    assert!(output.status.success());
    assert_eq!(results(&again)["points"], printed["points"]);
}

/// A policy in a file: a law by hand that sinks at 0.25 m/s less what the ground effect lifts.
fn policy() -> String {
    let mut weights = [[0.0; 19]; 3];
    weights[0][5] = -2.0;
    (weights[1][1], weights[1][4]) = (0.8, 1.0);
    (weights[2][0], weights[2][3]) = (-0.8, -1.0);
    let [offset, scale] = [[0.0; 19], [1.0; 19]];
    format!(
        "{{\"schema\": 1, \"decision_s\": 0.02, \"action\": {{}}, \
         \"input\": {{\"offset\": {offset:?}, \"scale\": {scale:?}}}, \
         \"layers\": [{{\"weights\": {weights:?}, \"bias\": [-0.5, 0.0, 0.0], \"activation\": \"linear\"}}]}}"
    )
}

#[test]
fn prop_a_policy_lands_beside_a_controller_and_its_folder_flies_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("s.toml"), SHORT).unwrap();
    std::fs::write(at("own.json"), policy()).unwrap();
    let [file, own, out, mcap] = [at("s.toml"), at("own.json"), at("out"), at("mcap")];
    let land = |own: &Path, out: &Path| {
        common::run([
            "land".as_ref(),
            "--space".as_ref(),
            "--json".as_ref(),
            file.as_os_str(),
            "--trials".as_ref(),
            "2".as_ref(),
            "--policy".as_ref(),
            own.as_os_str(),
            "--out".as_ref(),
            out.as_os_str(),
        ])
    };
    let output = land(&own, &out);
    assert!(output.status.success(), "{}", common::text(&output.stderr));
    let points = results(&out)["points"].clone();
    let flown: Vec<&Value> = points
        .as_array()
        .unwrap()
        .iter()
        .map(|p| &p["controller"])
        .collect();
    assert_eq!(flown, ["dynamic+observer", "policy"]);
    assert_eq!(points[1]["landed"]["count"], 2);
    // 0.4 m at 0.25 m/s at most; the planner's descent is faster.
    let t_l = |k: usize| points[k]["t_l_s"]["mean"].as_f64().unwrap();
    assert!(t_l(1) > 1.6 && t_l(1) > t_l(0), "{} {}", t_l(0), t_l(1));
    let table = std::fs::read_to_string(out.join("landings.csv")).unwrap();
    assert_eq!(
        table.lines().filter(|l| l.starts_with("policy,")).count(),
        2
    );
    let page = common::page(&out, common::CAMPAIGN_PAGE);
    assert!(page.contains("policy"));
    assert_eq!(
        std::fs::read(out.join("sweep-policy.json")).unwrap(),
        policy().into_bytes()
    );

    // The folder has all that a campaign and a replay need.
    let (sweep, again) = (out.join("sweep.toml"), at("again"));
    let campaign = ["campaign".as_ref(), sweep.as_os_str(), "--out".as_ref()];
    let output = common::run(campaign.into_iter().chain([again.as_os_str()]));
    assert!(output.status.success(), "{}", common::text(&output.stderr));
    assert_eq!(results(&again)["points"], points);
    let output = common::run([
        "campaign".as_ref(),
        "replay".as_ref(),
        again.join("sweep.toml").as_os_str(),
        "--landing".as_ref(),
        "3".as_ref(),
        "--mcap".as_ref(),
        mcap.as_os_str(),
    ]);
    assert!(output.status.success(), "{}", common::text(&output.stderr));
    assert!(mcap.join("landing-000003.mcap").exists());

    // A bad policy is one error before anything is written.
    std::fs::write(at("bad.json"), policy().replace("linear", "cubic")).unwrap();
    let output = land(&at("bad.json"), &at("none"));
    let text = common::text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("bad.json") && text.contains("cubic") && text.contains("tanh"),
        "{text}"
    );
    assert!(!at("none").exists());
}

#[test]
fn prop_a_recorded_landing_is_what_the_sensors_said() {
    let trace = replay(&sweep("").unwrap(), &[0]).unwrap().remove(0);
    let (imu, ranges) = (&trace.log.imu, &trace.log.ranges);
    let span_s = trace.rows.last().unwrap().time_s;
    // 250 and 50 Hz, but for a reading at either end, and for those of the 10 ms after the last row.
    let apart = |readings: usize, hz: f64| (readings as f64 - hz * span_s).abs();
    assert!(apart(imu.len(), 250.0) < 5.0, "{} {span_s}", imu.len());
    assert!(apart(ranges.len(), 50.0) < 3.0, "{} {span_s}", ranges.len());

    // As PX4's: the built-in map has it back.
    let log = Log::from_bytes("landing.ulg", recording::ulog(&trace).unwrap()).expect("a log");
    let (trial, findings) = log.trial(None).unwrap();
    assert!(!findings.is_lossy(), "{findings:?}");
    let channel = |name: &str| trial.channel(name).expect("a channel");
    assert_eq!(trial.len(), imu.len());
    let rows = imu.iter().enumerate();
    for (k, row) in rows {
        // Single precision: half of 6e-8 of 10 to 20.
        assert!((channel("specific_force_mps2")[k] - row.specific_force_mps2[2]).abs() < 2e-6);
        assert!((channel("battery_v")[k] - row.battery_v).abs() < 0.5);
        match row.throttle {
            Some(s) => assert!((channel("throttle")[k] - s.iter().sum::<f64>() / 4.0).abs() < 1e-7),
            None => assert!(channel("throttle")[k].is_nan(), "motors are off"),
        }
    }
    let stopped = imu.iter().filter(|row| row.throttle.is_none()).count();
    // Watched for half a second more.
    assert!(stopped > 100, "{stopped}");

    // As messages of ROS: the reader has their values.
    let bytes = recording::mcap(&trace).unwrap();
    let log = Log::from_bytes("landing.mcap", bytes).expect("a log");
    let (survey, _) = log.survey().unwrap();
    let seen = |topic: &str, field: &str| {
        let topic = survey.topics.iter().find(|t| t.name == topic).unwrap();
        let field = topic.field(field).unwrap();
        (topic.messages, field.min.unwrap(), field.max.unwrap())
    };
    let least = |of: &dyn Fn(usize) -> f64, n: usize| (0..n).map(of).fold(f64::INFINITY, f64::min);
    let (count, min, _) = seen("/imu", "linear_acceleration.z");
    assert_eq!(count, imu.len());
    assert_eq!(min, least(&|k| imu[k].specific_force_mps2[2], imu.len()));
    let (count, min, _) = seen("/range", "range");
    assert_eq!(count, ranges.len());
    assert_eq!(min, least(&|k| ranges[k].distance_m, ranges.len()));
}

#[test]
fn prop_what_flies_in_space_only_is_refused_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let fails = |more: &[&str]| {
        let args = ["land", "--out"].map(std::ffi::OsStr::new);
        let more = more.iter().map(std::ffi::OsStr::new);
        common::fails(2, args.into_iter().chain([out.as_os_str()]).chain(more))
    };
    let said = fails(&["--controller", "observer"]);
    assert!(
        said.contains("observer") && said.contains("--space"),
        "{said}"
    );
    let output = common::run([
        "land".as_ref(),
        "--mcap".as_ref(),
        out.as_os_str(),
        "--out".as_ref(),
        out.as_os_str(),
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(common::text(&output.stderr).contains("--space"));
    assert!(!out.exists());
}

fn sweep(more: &str) -> Result<Sweep, String> {
    let text = format!("{SHORT}{more}");
    let settings = parse(&text, "s.toml").map_err(|e| e.to_string())?;
    Sweep::new(settings, Path::new(""), "s.toml".into()).map_err(|e| e.to_string())
}

#[test]
fn prop_a_detector_that_looks_at_rendered_images_lands_the_vehicle() {
    let rendered = "[scenario.sensors]\ncamera = \"rendered\"\n";
    let seen = sweep(rendered).unwrap();
    let row = rows(&seen, 0..1, &touchdown_campaign::progress::Silent)
        .unwrap()
        .remove(0);
    assert!(row.landed_at_first(), "{row:?}");
    // The deck is found to millimetres from half a metre: four times what the error model allows for.
    assert!(row.number("lateral_m").unwrap() < 0.05, "{row:?}");
    // Other errors than those that the model draws, of the same landing.
    let fast = replay(&sweep("").unwrap(), &[0]).unwrap().remove(0);
    let images = replay(&seen, &[0]).unwrap().remove(0);
    let at = |trace: &touchdown_sim::landing::space::SpaceTrace| trace.rows[150].estimated_m;
    let (a, b) = (at(&fast), at(&images));
    assert_ne!(a, b);
    let apart = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    // Both are right to centimetres in the same air.
    assert!(apart < 0.05, "{a:?} {b:?}");
}

#[test]
fn prop_images_that_cannot_be_looked_at_name_their_key() {
    let said = sweep(
        "[scenario.sensors]\ncamera = \"rendered\"\n[scenario.sensors.tag]\nsizes_m = [0.4, 0.08, 0.016, 0.003]\n",
    )
    .unwrap_err();
    for needed in ["s.toml", "sensors.tag.sizes_m", "4"] {
        assert!(said.contains(needed), "{said}");
    }
    let said = sweep("[scenario.sensors]\ncamera = \"painted\"\n").unwrap_err();
    assert!(
        said.contains("painted") && said.contains("rendered"),
        "{said}"
    );
}
