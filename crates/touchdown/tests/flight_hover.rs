//! Ground effect from logs without accelerometer: hovers by rotor speed, card or throttle, and poses.

use crate::common::{fails, json, number};
use crate::flights;
use touchdown_identify::flights::hover::ThrustLaw;
use touchdown_identify::flights::{
    Basis, Flight, FlightSettings, GroundEffect, Refusal, ground_effect,
};
use touchdown_sim::body::plant::GroundLaw;
use touchdown_trial::Trial;

/// Rotor radius (m).
const R: f64 = 0.12;
/// Levels of hover in rotor radii, 3 s each.
const LEVELS: [f64; 12] = [6.0, 0.5, 1.0, 6.5, 2.0, 0.7, 1.4, 6.0, 3.0, 0.6, 2.4, 6.0];
/// Length of a level, of which one second is the way to it (s).
const LEVEL_S: f64 = 4.0;

fn truth(radii: f64) -> f64 {
    0.2 * (-radii / 1.3).exp()
}

/// A repeatable number in [-1, 1].
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// Height in rotor radii.
fn course(t: f64) -> f64 {
    let k = ((t / LEVEL_S) as usize).min(LEVELS.len() - 1);
    let from = LEVELS[k.saturating_sub(1)];
    let share = (t - LEVEL_S * k as f64).clamp(0.0, 1.0);
    from + (LEVELS[k] - from) * share * share * (3.0 - 2.0 * share)
}

/// A staircase of hovers, logged at `rate_hz` with stamps that jitter, from `start_s` on. Thrust goes with the square of
/// the rotor speed; the throttle with the rotor speed, as long as the battery is full. A run of the motors is 1 % stronger
/// or weaker than another.
fn staircase(index: usize, start_s: f64, rate_hz: f64) -> Trial {
    let n = (LEVELS.len() as f64 * LEVEL_S * rate_hz) as usize;
    let time: Vec<f64> = (0..n)
        .map(|i| (i as f64 + 0.3 * noise(i + 7 * index)) / rate_hz)
        .collect();
    let scale = 1.0 + 0.01 * noise(31 * index + 5);
    let rpm = |i: usize| {
        let ratio = 1.0 + truth(course(time[i]));
        6000.0 * scale * (1.0 / ratio).sqrt() * (1.0 + 0.004 * noise(3 * i + index))
    };
    // Three times a second.
    let mut next = 0.0;
    let telemetry: Vec<f64> = (0..n)
        .map(|i| {
            if time[i] < next {
                return f64::NAN;
            }
            next += 1.0 / 3.0;
            rpm(i)
        })
        .collect();
    let throttle = (0..n)
        .map(|i| rpm(i) / 11_000.0 * (1.0 + 4e-4 * time[i]))
        .collect();
    let height = (0..n)
        .map(|i| R * course(time[i]) + 5e-4 * noise(5 * i + 1))
        .collect();
    Trial::new(
        format!("stairs-{index}"),
        time.iter().map(|t| start_s + t).collect(),
    )
    .and_then(|t| t.with_channel("height_m", height))
    .and_then(|t| t.with_channel("rotor_rpm", telemetry))
    .and_then(|t| t.with_channel("throttle", throttle))
    .unwrap()
}

fn settings() -> FlightSettings {
    FlightSettings {
        rotor_radius_m: Some(R),
        ..FlightSettings::default()
    }
}

/// The trial without some of its channels.
fn without(trial: &Trial, names: &[&str]) -> Trial {
    let mut out = Trial::new(trial.name(), trial.time_s().to_vec()).unwrap();
    for (name, values) in trial.channels().filter(|(name, _)| !names.contains(name)) {
        out.insert(name, values.to_vec()).unwrap();
    }
    out
}

fn identify(trials: &[Trial]) -> GroundEffect {
    let settings = settings();
    let flights: Vec<Flight> = trials
        .iter()
        .map(|t| Flight::of(t, &settings).unwrap())
        .collect();
    ground_effect(&flights, &settings).unwrap()
}

/// Intervals that hold the truth at heights from half a radius to three, and the greatest error there over the truth at
/// half a radius.
fn judge(found: &GroundEffect, truth: impl Fn(f64) -> f64) -> (usize, f64) {
    let (mut held, mut worst) = (0, 0.0_f64);
    for radii in [0.5, 0.8, 1.2, 1.8, 2.4, 3.0] {
        let ratio = found.ratio(radii * R).unwrap();
        held += usize::from((ratio.ci95[0]..=ratio.ci95[1]).contains(&truth(radii)));
        worst = worst.max((ratio.value - truth(radii)).abs() / truth(0.5));
    }
    (held, worst)
}

#[test]
fn analytic_hovers_by_rotor_speed_three_times_a_second() {
    // Unix stamps, jitter, no throttle.
    let trials: Vec<Trial> = (0..4)
        .map(|k| without(&staircase(k, 1.7e9, 25.0), &["throttle"]))
        .collect();
    let found = identify(&trials);
    assert!(
        matches!(
            found.basis,
            Basis::Hovers {
                law: ThrustLaw::RotorSpeed,
                ..
            }
        ),
        "{:?}",
        found.basis
    );
    // Twelve levels in each of four flights, in pieces of at most 3 s.
    assert!(found.hovers.len() >= 40, "{}", found.hovers.len());
    let (held, worst) = judge(&found, truth);
    // A thousandth of thrust, of 0.14: noise of rotor speeds over some telegrams each.
    assert!(worst < 0.08 && held >= 5, "{held} of 6, {worst}");
    let refused: Vec<&str> = found.refused.iter().map(Refusal::what).collect();
    assert!(refused.len() == 2 && refused[0].contains("lag") && refused[1].contains("climb"));
    assert!(found.lag_s().is_none() && found.delay_s().is_none());
    for hover in &found.hovers {
        let expected = 1.0 + truth(hover.height_m / R);
        assert!((hover.ratio - expected).abs() < 0.02, "{hover:?}");
    }
}

#[test]
fn prop_a_rotor_speed_is_not_told_as_a_throttle() {
    let settings = settings();
    let flights: Vec<Flight> = (0..4)
        .map(|k| without(&staircase(k, 0.0, 25.0), &["throttle"]))
        .map(|trial| Flight::of(&trial, &settings).unwrap())
        .collect();
    assert!(
        flights[0]
            .notes
            .iter()
            .any(|n| n.to_string().contains("no throttle"))
    );
    let found = ground_effect(&flights, &settings).unwrap();
    let runs = found.result(&flights, &settings).runs;
    let hover = runs[0].hover.expect("a hover out of ground effect");
    assert_eq!(hover.throttle, None);
    assert!(hover.to_string().contains("turns a minute"), "{hover}");
    assert!(hover.rotor_rpm.is_some_and(|rpm| rpm > 1000.0), "{hover}");
}

#[test]
fn analytic_hovers_by_throttle_know_that_its_law_is_not_known() {
    let trials: Vec<Trial> = (0..4)
        .map(|k| without(&staircase(k, 0.0, 25.0), &["rotor_rpm"]))
        .collect();
    let found = identify(&trials);
    assert!(
        matches!(
            found.basis,
            Basis::Hovers {
                law: ThrustLaw::Throttle,
                ..
            }
        ),
        "{:?}",
        found.basis
    );
    let (held, worst) = judge(&found, truth);
    // Thrust goes with the square here, 1.9 is assumed, and intervals know that it may be another.
    assert!(held == 6 && worst < 0.35, "{held} of 6, {worst}");
    let near = found.ratio(0.5 * R).unwrap();
    assert!(near.std_error > 0.1 * near.value, "{near:?}");
    assert!(
        found
            .refused
            .iter()
            .any(|r| r.what() == "thrust by throttle" && r.record().contains("thrust card"))
    );
}

#[test]
fn analytic_an_accelerometer_beside_a_slow_throttle_has_its_hovers_judged() {
    let trials: Vec<Trial> = (0..4)
        .map(|k| {
            let mut trial = without(&staircase(k, 0.0, 10.0), &["throttle"]);
            let force = vec![9.81; trial.len()];
            trial.insert("specific_force_mps2", force).unwrap();
            trial
        })
        .collect();
    let found = identify(&trials);
    let (held, worst) = judge(&found, truth);
    // As by rotor speeds alone.
    assert!(worst < 0.08 && held >= 5, "{held} of 6, {worst}");
    let lag = &found.refused[0];
    assert!(
        lag.found().contains("throttle logged every 0.") && lag.record().contains("40 Hz"),
        "{lag:?}"
    );
    assert!(found.lag_s().is_none());
}

#[test]
fn analytic_one_log_of_hovers_has_intervals_too() {
    let found = identify(&[without(&staircase(0, 0.0, 25.0), &["throttle"])]);
    let (held, worst) = judge(&found, truth);
    assert!(held >= 5 && worst < 0.15, "{held} of 6, {worst}");
}

#[test]
fn prop_more_flights_of_hovers_never_know_less() {
    let trials: Vec<Trial> = (0..6)
        .map(|k| without(&staircase(k, 0.0, 25.0), &["throttle"]))
        .collect();
    let mut narrowest = f64::INFINITY;
    let mut half_widths = Vec::new();
    for flights in [1, 2, 3, 4, 6] {
        let found = identify(&trials[..flights]);
        let lift = found.extra_lift([R; 2], [6.0 * R; 2]).unwrap();
        let half = 0.5 * (lift.ci95[1] - lift.ci95[0]);
        // Resampled hovers know a width to a fifth. When three flights were resampled as three, they knew four times less than two.
        assert!(
            half < 1.3 * narrowest,
            "{flights} flights: {lift:?}, before {narrowest}"
        );
        narrowest = half.min(narrowest);
        half_widths.push(half);
    }
    // Six flights have six times the hovers of one: 2.4 times narrower, if flights differ by nothing else.
    assert!(half_widths[4] < 0.7 * half_widths[0], "{half_widths:?}");
}

#[test]
fn prop_intervals_of_hovers_hold_the_zero_of_heights() {
    // Each armed interval has a zero of its own, with the standard deviation that settings state.
    let sd_m = R * FlightSettings::default().height_bias_radii;
    let mut held = 0;
    for set in 0..8 {
        let trials: Vec<Trial> = (0..3)
            .map(|k| {
                let index = 3 * set + k;
                let mut trial = without(&staircase(index, 0.0, 25.0), &["throttle"]);
                // The sum of three uniform numbers in [-1, 1] has a variance of 1.
                let error_m: f64 = sd_m * (0..3).map(|i| noise(1000 + 3 * index + i)).sum::<f64>();
                let height = trial.channel("height_m").unwrap();
                let height = height.iter().map(|z| z + error_m).collect();
                trial.insert("height_m", height).unwrap();
                trial
            })
            .collect();
        let ratio = identify(&trials).ratio(R).unwrap();
        held += usize::from((ratio.ci95[0]..=ratio.ci95[1]).contains(&truth(1.0)));
    }
    // Chance leaves out two of eight in one of twenty times. Intervals of the hovers alone hold 6.
    assert!(held >= 7, "{held} of 8");
}

#[test]
fn prop_hovers_that_are_missing_are_asked_for() {
    let settings = settings();
    let refuse = |trial: &Trial| {
        let flight = Flight::of(trial, &settings).unwrap();
        let error = ground_effect(&[flight], &settings).unwrap_err();
        assert_eq!(error.exit_status(), 1);
        error.to_string()
    };
    let trial = without(&staircase(0, 0.0, 25.0), &["throttle"]);
    let with_height = |height: Vec<f64>| {
        let mut out = without(&trial, &["height_m"]);
        out.insert("height_m", height).unwrap();
        out
    };
    let height = trial.channel("height_m").unwrap();
    let time = trial.time_s();
    // It never rests.
    let restless = with_height(time.iter().map(|t| 0.5 + 0.4 * (1.5 * t).sin()).collect());
    let text = refuse(&restless);
    assert!(
        text.contains("no steady segment") && text.contains("record"),
        "{text}"
    );
    // It never comes down.
    let text = refuse(&with_height(height.iter().map(|z| z + 0.5).collect()));
    assert!(
        text.contains("0.360 m") && text.contains("hovers, at"),
        "{text}"
    );
    // The height is not known.
    let error = Flight::of(&with_height(vec![f64::NAN; height.len()]), &settings)
        .and_then(|f| ground_effect(&[f], &settings))
        .unwrap_err()
        .to_string();
    assert!(error.contains("height_m"), "{error}");
}

#[test]
fn analytic_poses_of_a_simulated_vehicle_stand_for_its_accelerometer() {
    let plant = flights::vehicle(1.4, R, GroundLaw::Exponential, 0.05);
    let flown: Vec<flights::Flown> = (0..6)
        .map(|k| flights::fly(&plant, k, 250.0, 250.0))
        .collect();
    let trials: Vec<Trial> = flown
        .iter()
        .map(|f| without(&f.trial, &["specific_force_mps2"]))
        .collect();
    let found = identify(&trials);
    assert_eq!(found.basis, Basis::Poses);
    let (held, worst) = judge(&found, |radii| flights::true_ratio(&plant, radii * R));
    assert!(held >= 5 && worst < 0.15, "{held} of 6, {worst}");
    // The motion tells the lag of the wake too; that of the motors and an effect of climb are refused.
    let truth_s = flights::true_lag_s(&plant, &flown);
    if let Some(lag) = found.lag_s() {
        assert!(
            (lag.ci95[0]..=lag.ci95[1]).contains(&truth_s),
            "{lag:?}, truth {truth_s}"
        );
    }
    let refused: Vec<&str> = found.refused.iter().map(Refusal::what).collect();
    assert!(refused.len() == 2 && refused[0].contains("lag") && refused[1].contains("climb"));
    assert!(
        found
            .numbers()
            .iter()
            .all(|n| n.name != "T_m" && n.name != "delay")
    );
}

#[test]
fn prop_the_command_takes_hovers_and_a_card() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for k in 0..3 {
        let trial = without(&staircase(k, 0.0, 25.0), &["rotor_rpm"]);
        touchdown_log::write_csv(&trial, std::path::Path::new(&path(&format!("{k}.csv")))).unwrap();
    }
    std::fs::write(
        path("quad.toml"),
        "[flight]\nmass_kg = 1.4\nrotor_radius_m = 0.12\n",
    )
    .unwrap();
    // T = (5 s)², in the same vehicle's units.
    let mut stand = String::from("time_s,throttle,thrust_n\n");
    for i in 0..40 {
        let s = 0.3 + 0.01 * f64::from(i);
        stand += &format!("{},{s},{}\n", i, 25.0 * s * s);
    }
    std::fs::write(path("stand.csv"), stand).unwrap();
    json(
        0,
        [
            "identify",
            "thrust",
            &path("stand.csv"),
            "--out",
            &path("thrust.toml"),
        ],
    );
    let logs = [path("0.csv"), path("1.csv"), path("2.csv")];
    let common = [
        "identify",
        "ground-effect",
        &logs[0],
        &logs[1],
        &logs[2],
        "--settings",
        &path("quad.toml"),
    ];
    let found = json(
        0,
        common
            .into_iter()
            .chain(["--thrust", &path("thrust.toml"), "--out", &path("out")]),
    );
    assert_eq!(
        found["flight"]["basis"]["hovers"]["law"], "card",
        "{}",
        found["flight"]["basis"]
    );
    let numbers = found["flight"]["numbers"].as_array().unwrap();
    assert!(numbers.iter().any(|n| n["name"] == "decay"), "{numbers:?}");
    let first = &found["flight"]["hovers"][1];
    let expected = 1.0 + truth(number(&first["height_m"]) / R);
    assert!((number(&first["ratio"]) - expected).abs() < 0.02, "{first}");
    let card = touchdown_model::Card::read(&folder.path().join("out/ground-effect.toml")).unwrap();
    card.ground_effect().unwrap();
    let report = std::fs::read_to_string(path("out/report.html")).unwrap();
    assert!(report.contains("Hovers at rest") && report.contains("thrust by the card"));
    // Motors that nobody logged.
    let poses = without(&staircase(0, 0.0, 25.0), &["rotor_rpm", "throttle"]);
    touchdown_log::write_csv(&poses, std::path::Path::new(&path("poses.csv"))).unwrap();
    let args = [
        "identify",
        "ground-effect",
        &path("poses.csv"),
        "--settings",
        &path("quad.toml"),
    ];
    let error = fails(1, args);
    assert!(
        error.contains("rotor_rpm") && error.contains("record"),
        "{error}"
    );
}
