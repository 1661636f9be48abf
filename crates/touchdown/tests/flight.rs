//! Thrust and ground effect from flight logs, on measured flights.

use std::path::PathBuf;
use std::sync::OnceLock;

use crate::common::{LARGE_PAGE, data, fails, json, map, number, page, run, text};
use touchdown_identify::flights::phases::{Phase, Phases};
use touchdown_identify::flights::{Flight, FlightSettings, GroundEffect, Refusal, ground_effect};
use touchdown_log::{Map, read_trial};

/// The five flights of CrazyPAD's drone E9 (Masalimov et al., Data 9, 2024), and what is known of a Crazyflie.
fn crazypad() -> Option<(Vec<Flight>, FlightSettings)> {
    let folder = data("flight-crazypad-takeoff-landing")?;
    let map = Map::load(map("flight-crazypad-motor.toml")).unwrap();
    let settings = FlightSettings {
        rotor_radius_m: Some(0.023),
        ..FlightSettings::default()
    };
    let flights = (0..5)
        .map(|k| {
            let path = folder.join(format!("E9_log0{k}_motor.csv"));
            let (trial, _) = read_trial(&path, Some(&map)).unwrap();
            Flight::of(&trial, &settings).unwrap()
        })
        .collect();
    Some((flights, settings))
}

/// Their ground effect.
fn of_crazypad(flights: &[Flight], settings: &FlightSettings) -> &'static GroundEffect {
    static FOUND: OnceLock<GroundEffect> = OnceLock::new();
    FOUND.get_or_init(|| ground_effect(flights, settings).unwrap())
}

#[test]
fn xval_motors_and_hover_of_five_flights() {
    let Some((flights, settings)) = crazypad() else {
        return;
    };
    // Reference values: motors on and off, and the mean command of hover from 6 to 10 s, read off the logs with NumPy.
    let hover = [0.638, 0.633, 0.633, 0.623, 0.621];
    for (flight, expected) in flights.iter().zip(hover) {
        let phases = Phases::of(flight, &settings);
        let [first, second] = &phases.runs[..] else {
            panic!("{:?}", phases.runs)
        };
        let near = |found: Option<f64>, [lo, hi]: [f64; 2]| {
            found.is_some_and(|t| (lo - 0.1..=hi + 0.1).contains(&t))
        };
        assert!(near(first.on_s, [2.93, 2.96]), "{first:?}");
        assert!(near(first.off_s, [11.51, 11.57]), "{first:?}");
        assert!(near(second.on_s, [16.46, 16.52]), "{second:?}");
        let window: Vec<usize> = (0..flight.time_s.len())
            .filter(|&i| (6.0..=10.0).contains(&flight.time_s[i]))
            .collect();
        assert!(
            window.iter().all(|&i| phases.rows[i] == Phase::Airborne),
            "{}",
            flight.name
        );
        let mean = window.iter().map(|&i| flight.throttle[i]).sum::<f64>() / window.len() as f64;
        assert!((mean - expected).abs() < 0.003, "{}: {mean}", flight.name);
        // The motors are cut 0.2 m above the floor: no row of the drop or of the blow counts.
        let after = first.off_s.unwrap();
        let counted = (0..flight.time_s.len())
            .filter(|&i| (after..after + 2.0).contains(&flight.time_s[i]))
            .filter(|&i| phases.rows[i] == Phase::Airborne);
        assert_eq!(counted.count(), 0);
    }
}

fn value(found: &GroundEffect, name: &str) -> f64 {
    let numbers = found.numbers();
    numbers
        .iter()
        .find(|n| n.name == name)
        .map_or(f64::NAN, |n| n.estimate.value)
}

#[test]
fn xval_ground_effect_of_five_flights() {
    let Some((flights, settings)) = crazypad() else {
        return;
    };
    let found = of_crazypad(&flights, &settings);
    // Reference values: 7 ± 2 % of the weight between these heights, and a decay of 12 to 26 per metre, from means over
    // heights.
    let extra = found.extra_lift([0.03, 0.045], [0.13, 0.30]).unwrap();
    assert!((0.05..=0.09).contains(&extra.value), "{extra:?}");
    assert!(extra.ci95[0] > 0.03 && extra.ci95[1] < 0.11, "{extra:?}");
    let decay = found.decay_per_m().unwrap();
    assert!((12.0..=26.0).contains(&decay.value), "{decay:?}");
    assert!(decay.ci95[1] - decay.ci95[0] < 16.0, "{decay:?}");
    // The motors' lag agrees with that of another Crazyflie, logged at 1 kHz under throttle pulses.
    assert!(
        (value(found, "T_m") - 0.060).abs() < 0.010,
        "{:?}",
        found.numbers()
    );
    // Take-offs pass each height once, at one speed: neither a lag nor an effect of climb can be told apart there.
    let refused: Vec<&str> = found.refused.iter().map(Refusal::what).collect();
    assert_eq!(refused.len(), 2, "{refused:?}");
    assert!(
        refused[0].contains("lag") && refused[1].contains("climb"),
        "{refused:?}"
    );
    // Second take-offs, whose height wandered on the floor, do not count near the ground.
    let wandered = found.left_out.iter().filter(|l| l.why.contains("wandered"));
    assert_eq!(wandered.count(), 5);
}

#[test]
fn xval_what_is_told_of_every_run_of_five_flights() {
    let Some((flights, settings)) = crazypad() else {
        return;
    };
    let found = of_crazypad(&flights, &settings);
    let result = found.result(&flights, &settings);
    // Reference values: means of the command from 6 to 10 s. The steady seconds that are found are others, and the command of
    // one hover wanders by 0.003.
    let hover = [0.638, 0.633, 0.633, 0.623, 0.621];
    for (first, expected) in result.runs.iter().step_by(2).zip(hover) {
        let found = first.hover.expect("a hover");
        assert!(
            (found.throttle.unwrap() - expected).abs() < 0.004,
            "{first}"
        );
        assert!(found.from_s > 4.0 && found.to_s < 11.2, "{first}");
        // Reference value: 7 ± 2 % in the mean of the flights; each alone is known to about 2 %.
        let lift = first.extra_lift.expect("heights near and far");
        assert!((0.03..=0.12).contains(&lift.share.value), "{first}");
        assert!(lift.share.differs_from_zero(), "{first}");
    }
    let lift = result.extra_lift.expect("a curve");
    let [lo, hi] = lift.share.ci95;
    assert!(
        (0.05..=0.09).contains(&lift.share.value) && lo > 0.03 && hi < 0.11,
        "{lift}"
    );
    // Second flights, whose height wandered on the floor, say nothing near the ground, and most logs end in them.
    let second = &result.runs[1];
    assert!(
        second.hover.is_some() && second.extra_lift.is_none(),
        "{second}"
    );
    let text = second.to_string();
    assert!(
        text.contains("motors on 16.4") && text.contains("off 25.70 s or later"),
        "{text}"
    );
}

#[test]
fn prop_a_log_without_heights_near_the_ground_gives_no_number() {
    let Some((mut flights, settings)) = crazypad() else {
        return;
    };
    for flight in &mut flights {
        flight.height_m.iter_mut().for_each(|z| *z += 0.2);
    }
    let error = ground_effect(&flights, &settings).unwrap_err();
    assert_eq!(error.exit_status(), 1);
    let text = error.to_string();
    assert!(
        text.contains("two rotor radii") && text.contains("record"),
        "{text}"
    );
}

fn crazypad_logs() -> Option<Vec<PathBuf>> {
    let folder = data("flight-crazypad-takeoff-landing")?;
    Some(
        (0..5)
            .map(|k| folder.join(format!("E9_log0{k}_motor.csv")))
            .collect(),
    )
}

#[test]
fn prop_a_log_given_twice_is_refused() {
    let Some(logs) = crazypad_logs() else { return };
    let mut args: Vec<PathBuf> = ["identify", "ground-effect"]
        .iter()
        .map(PathBuf::from)
        .collect();
    args.extend([logs[0].clone(), logs[1].clone(), logs[0].clone()]);
    args.extend(["--map".into(), map("flight-crazypad-motor.toml")]);
    let text = fails(2, &args);
    assert!(
        text.contains("different logs") && text.contains("E9_log00_motor.csv"),
        "{text}"
    );
}

#[test]
fn prop_the_command_identifies_flights_and_writes_all_of_it() {
    let Some(logs) = crazypad_logs() else { return };
    let folder = tempfile::tempdir().unwrap();
    let settings = folder.path().join("crazyflie.toml");
    std::fs::write(
        &settings,
        "[flight]\nmass_kg = 0.03\nrotor_radius_m = 0.023\n",
    )
    .unwrap();
    let out = folder.path().join("out");
    let mut args: Vec<PathBuf> = ["identify", "ground-effect"]
        .iter()
        .map(PathBuf::from)
        .collect();
    args.extend(logs);
    args.extend(["--map".into(), map("flight-crazypad-motor.toml")]);
    args.extend(["--settings".into(), settings, "--out".into(), out.clone()]);
    let found = json(0, &args);
    assert_eq!(
        (&found["form"], &found["lag_s"]),
        (&"static".into(), &serde_json::Value::Null)
    );
    let numbers = found["flight"]["numbers"].as_array().unwrap();
    let decay = numbers.iter().find(|n| n["name"] == "decay").unwrap();
    assert!(
        (12.0..=26.0).contains(&number(&decay["value"])) && decay["ci95"][1].is_f64(),
        "{decay}"
    );
    assert_eq!(found["flight"]["refused"].as_array().unwrap().len(), 2);
    assert_eq!(found["flight"]["runs"].as_array().unwrap().len(), 10);
    let run = &found["flight"]["runs"][1];
    assert!(run["off_s"].is_null() && number(&run["ran_until_s"]) > 25.6);
    assert!(number(&found["flight"]["extra_lift"]["value"]) > 0.05);
    // What is to be told of the thrust card is told with the other.
    let warnings = found["warnings"].as_array().unwrap();
    let of_thrust = |w: &&serde_json::Value| {
        let text = w.as_str().unwrap();
        text.starts_with("thrust card: thrust at one throttle differs")
    };
    assert_eq!(warnings.iter().filter(of_thrust).count(), 1, "{warnings:?}");
    assert_eq!(found["rmse"]["unit"], "N");
    for file in [
        "ground-effect.toml",
        "thrust.toml",
        "report.html",
        "results.json",
        "summary.csv",
        "inputs/settings.toml",
        "figures/residual-over-height.png",
        "figures/flight-05-E9_log04_motor.svg",
    ] {
        assert!(out.join(file).exists(), "{file}");
    }
    page(&out, LARGE_PAGE);
    // The cards fly.
    let card = |name: &str| touchdown_model::Card::read(&out.join(name)).unwrap();
    let hover = card("thrust.toml")
        .thrust_model()
        .unwrap()
        .throttle_for(0.03 * 9.81);
    // Commands of hover are 0.62 to 0.64; the motors of the mean flight are between.
    assert!((0.61..=0.65).contains(&hover), "{hover}");
    card("ground-effect.toml").ground_effect().unwrap();
}

#[test]
fn regress_what_flights_say_stands_in_lines_of_their_own() {
    let Some(logs) = crazypad_logs() else { return };
    let folder = tempfile::tempdir().unwrap();
    let settings = folder.path().join("crazyflie.toml");
    std::fs::write(&settings, "[flight]\nrotor_radius_m = 0.023\n").unwrap();
    let mut args: Vec<PathBuf> = ["identify", "ground-effect"].map(PathBuf::from).into();
    args.extend(logs);
    args.extend(["--map".into(), map("flight-crazypad-motor.toml")]);
    args.extend(["--settings".into(), settings]);
    let out = text(&run(&args).stdout);
    for begin in [
        "from specific force",
        "  extra lift ",
        "  E9_log00_motor, run 1: motors on 2.9",
        "  not identified: ",
    ] {
        let found = out.lines().filter(|line| line.starts_with(begin)).count();
        assert_eq!(found, 1, "{begin}: {out}");
    }
}

#[test]
fn prop_the_command_says_what_is_missing() {
    let Some(logs) = crazypad_logs() else { return };
    let map = map("flight-crazypad-motor.toml");
    let log = logs[0].display().to_string();
    let map = map.display().to_string();
    let error = fails(2, ["identify", "ground-effect", &log, "--map", &map]);
    assert!(error.contains("rotor_radius_m"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let settings = folder.path().join("big.toml");
    // A vehicle whose rotors are so large that it never left the ground effect.
    std::fs::write(&settings, "[flight]\nrotor_radius_m = 0.3\n").unwrap();
    let settings = settings.display().to_string();
    let args = [
        "identify",
        "ground-effect",
        &log,
        "--map",
        &map,
        "--settings",
        &settings,
    ];
    let error = fails(1, args);
    assert!(
        error.contains("1.200 m") && error.contains("reference"),
        "{error}"
    );
    let error = fails(2, ["identify", "thrust", &log, "--map", &map]);
    assert!(error.contains("mass_kg"), "{error}");
    std::fs::write(folder.path().join("bad.toml"), "[flight]\nmass_kg = -1\n").unwrap();
    let bad = folder.path().join("bad.toml").display().to_string();
    let error = fails(
        2,
        [
            "identify",
            "thrust",
            &log,
            "--map",
            &map,
            "--settings",
            &bad,
        ],
    );
    assert!(
        error.contains("flight.mass_kg") && error.contains("-1"),
        "{error}"
    );
}

#[test]
fn xval_motor_lag_of_a_gentle_flight_at_1_khz() {
    let Some(log) = data("flight-crazyflie-1khz-throttle/log15.csv") else {
        return;
    };
    let map = map("flight-crazyflie-1khz-throttle.toml");
    let args = ["identify", "thrust", "--map"].map(PathBuf::from);
    let found = json(0, args.iter().chain([&map, &log]));
    // Reference value 0.060 s, the lag of a parabola of the throttle without a dead time, by least squares on a grid: what a
    // lag and a dead time delay together.
    let delay_s = number(&found["lag_s"]) + number(&found["coefficients"]["dead_time"]["value"]);
    assert!((delay_s - 0.060).abs() <= 0.010, "{found}");
}

#[test]
fn xval_a_gentle_flight_by_its_specific_force_says_which_form_gives_the_lag() {
    let Some(log) = data("flight-crazyflie-1khz-throttle/log15.csv") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("specific-force.toml");
    let given = std::fs::read_to_string(map("flight-crazyflie-1khz-throttle.toml")).unwrap();
    let force = "specific_force_mps2 = '9.80665 * acc_z_g'";
    let changed = given.replace("thrust_n = 'mass_kg * 9.80665 * acc_z_g'", force);
    assert!(changed.contains(force));
    std::fs::write(&path, changed).unwrap();
    let args = ["identify", "thrust", "--map"].map(PathBuf::from);
    let all = || args.iter().chain([&path, &log]);
    // Disturbances as slow as the throttle's changes: the lag's interval is wider than the lag.
    let error = fails(1, all());
    assert!(
        error.contains("try the form `lagged_motors`") && error.contains("pulses"),
        "{error}"
    );
    let form = ["--form", "lagged_motors"].map(PathBuf::from);
    let found = json(0, all().chain(&form));
    // As for the same log above.
    let delay_s = number(&found["lag_s"]) + number(&found["coefficients"]["dead_time"]["value"]);
    assert!((delay_s - 0.060).abs() <= 0.010, "{found}");
}
