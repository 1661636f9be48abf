//! Measured flights with the faults that logs have: a right number or a refusal, never a number out of thin air.

use crate::common::{data, fails, map};
use touchdown_identify::flights::phases::{Phase, Phases};
use touchdown_identify::flights::{
    Flight, FlightSettings, GroundEffect, ground_effect, thrust_alone, with_thrust,
};
use touchdown_log::{Map, read_trial};
use touchdown_trial::Trial;

fn settings() -> FlightSettings {
    FlightSettings {
        rotor_radius_m: Some(0.023),
        ..FlightSettings::default()
    }
}

/// Five flights of CrazyPAD's drone E9 (Masalimov et al., Data 9, 2024).
fn crazypad() -> Option<Vec<Trial>> {
    let folder = data("flight-crazypad-takeoff-landing")?;
    let map = Map::load(map("flight-crazypad-motor.toml")).unwrap();
    let read = |k| read_trial(folder.join(format!("E9_log0{k}_motor.csv")), Some(&map));
    Some((0..5).map(|k| read(k).unwrap().0).collect())
}

fn flights(trials: &[Trial]) -> Vec<Flight> {
    trials
        .iter()
        .map(|t| Flight::of(t, &settings()).unwrap())
        .collect()
}

fn identify(trials: &[Trial]) -> GroundEffect {
    ground_effect(&flights(trials), &settings()).unwrap()
}

fn refuse(trials: &[Trial]) -> String {
    let error = ground_effect(&flights(trials), &settings()).unwrap_err();
    assert_eq!(error.exit_status(), 1);
    error.to_string()
}

/// The trials with another clock, and with channels changed.
fn changed(
    trials: &[Trial],
    clock: impl Fn(usize, f64) -> f64,
    change: impl Fn(&str, usize, f64, f64) -> f64,
) -> Vec<Trial> {
    let one = |trial: &Trial| {
        let time = trial.time_s();
        let stamps = time.iter().enumerate().map(|(i, t)| clock(i, *t)).collect();
        let mut out = Trial::new(trial.name(), stamps).unwrap();
        for (name, values) in trial.channels() {
            let new = values
                .iter()
                .enumerate()
                .map(|(i, v)| change(name, i, time[i], *v));
            out.insert(name, new.collect()).unwrap();
        }
        out
    };
    trials.iter().map(one).collect()
}

fn same(_: usize, t: f64) -> f64 {
    t
}

fn kept(_: &str, _: usize, _: f64, v: f64) -> f64 {
    v
}

/// Extra lift between the heights of the published mean: 7 % of weight.
fn extra(found: &GroundEffect) -> f64 {
    found.extra_lift([0.03, 0.045], [0.13, 0.30]).unwrap().value
}

#[test]
fn regress_faults_that_leave_the_number_alone() {
    let Some(trials) = crazypad() else { return };
    let clean = extra(&identify(&trials));
    assert!((0.05..=0.09).contains(&clean), "{clean}");
    // Spikes of 28 m in the air, on the stand, and for a second in hover.
    let spiked = changed(&trials, same, |name, i, t, z| {
        let spike = i % 211 == 0 || (8.0..9.0).contains(&t);
        if name == "height_m" && spike { 28.0 } else { z }
    });
    let notes = &flights(&spiked)[0].notes;
    assert!(
        notes.iter().any(|n| n.to_string().contains("spikes")),
        "{notes:?}"
    );
    let found = identify(&spiked);
    assert!(
        (extra(&found) - clean).abs() < 0.01,
        "{} {clean}",
        extra(&found)
    );
    assert!(found.heights_m[1] < 1.0, "{:?}", found.heights_m);
    // Unix stamps: the same but for the rounding of stamps to 0.2 µs.
    let found = identify(&changed(&trials, |_, t| t + 1.7e9, kept));
    assert!(
        (extra(&found) - clean).abs() < 1e-3,
        "{} {clean}",
        extra(&found)
    );
    // Stamps that jitter by 2 ms of 10.
    let jitter = |i: usize, t: f64| t + 0.002 * (i as f64 * 12.9898).sin();
    let found = identify(&changed(&trials, jitter, kept));
    assert!(
        (extra(&found) - clean).abs() < 0.01,
        "{} {clean}",
        extra(&found)
    );
    // The clock leaps by three hours between the two flights of a log.
    let leap = |_: usize, t: f64| if t > 14.0 { t + 10_800.0 } else { t };
    let found = identify(&changed(&trials, leap, kept));
    assert!(
        (extra(&found) - clean).abs() < 0.01,
        "{} {clean}",
        extra(&found)
    );
    // A range finder that gives nothing above 0.3 m now and then, and a battery that was logged once a second.
    let gappy = changed(&trials, same, |name, i, _, v| match name {
        "height_m" if v > 0.3 && i / 37 % 3 == 0 => f64::NAN,
        "battery_v" if i % 100 != 0 => f64::NAN,
        _ => v,
    });
    let found = identify(&gappy);
    assert!(
        (extra(&found) - clean).abs() < 0.015,
        "{} {clean}",
        extra(&found)
    );
}

#[test]
fn prop_faults_that_leave_no_number() {
    let Some(trials) = crazypad() else { return };
    // Never flew: motors off; motors on, but on the floor.
    let still = changed(&trials, same, |name, _, _, v| {
        if name.starts_with("throttle") { 0.0 } else { v }
    });
    let text = refuse(&still);
    assert!(
        text.contains("motors off") && text.contains("a stretch of flight"),
        "{text}"
    );
    let floor = changed(&trials, same, |name, _, _, v| match name {
        "height_m" => 0.02,
        "specific_force_mps2" => 9.81,
        "vehicle_velocity_mps" => 0.0,
        _ => v,
    });
    let text = refuse(&floor);
    assert!(text.contains("on the ground"), "{text}");
    // Heights that nobody knows.
    let text = refuse(&changed(&trials, same, |name, _, _, v| {
        if name == "height_m" { f64::NAN } else { v }
    }));
    assert!(
        text.contains("height_m") && text.contains("record"),
        "{text}"
    );
    // Near and far in different runs of the motors: scales of runs differ, so that nothing compares.
    let apart = changed(&trials[..2], same, |name, _, t, z| {
        if name != "height_m" {
            return z;
        }
        match t {
            ..14.0 if z > 0.092 => f64::NAN,
            14.0.. if z < 0.05 => f64::NAN,
            _ => z,
        }
    });
    let text = refuse(&apart);
    assert!(text.contains("rotor radii"), "{text}");
}

#[test]
fn regress_thrust_that_falls_with_time_without_a_voltage() {
    let Some(trials) = crazypad() else { return };
    let falling = |rate: f64| {
        identify(&changed(&trials, same, |name, _, t, v| match name {
            "battery_v" => f64::NAN,
            "specific_force_mps2" => v * (1.0 - rate * t),
            _ => v,
        }))
    };
    let (still, falls) = (falling(0.0), falling(0.002));
    assert!(still.drift_of_time && falls.drift_of_time);
    // Twenty seconds at 0.2 % a second are half of the extra lift of 7 %; the drift takes it up.
    let apart = extra(&falls) - extra(&still);
    assert!(apart.abs() < 0.01, "{apart}");
    let numbers = falls.numbers();
    let drift = numbers.iter().find(|n| n.name == "drift").expect("a drift");
    assert!(
        (-0.003..-0.001).contains(&drift.estimate.value),
        "{drift:?}"
    );
}

#[test]
fn prop_a_disturbance_that_swamps_the_throttle_is_refused() {
    let Some(trials) = crazypad() else { return };
    // Three tenths of gravity, another course in every flight.
    let mut gusty = Vec::new();
    for (k, trial) in trials.iter().enumerate() {
        let phase = 1.9 * k as f64;
        gusty.extend(changed(
            std::slice::from_ref(trial),
            same,
            |name, _, t, v| match name {
                "specific_force_mps2" => v + 3.0 * (1.7 * t + phase).sin(),
                _ => v,
            },
        ));
    }
    let text = refuse(&gusty);
    assert!(
        text.contains("follows the throttle") && text.contains("95 % interval"),
        "{text}"
    );
}

#[test]
fn prop_flights_without_a_ground_effect_give_no_number() {
    let Some(trials) = crazypad() else { return };
    // What the logs have of it (7 % at 0.038 m, a decay of 26 per metre) is taken off.
    let free: Vec<Trial> = trials
        .iter()
        .map(|trial| {
            let height = trial.channel("height_m").unwrap().to_vec();
            let lift = |i: usize| 0.184 * (-height[i].max(0.0) / 0.0386).exp();
            let one = changed(
                std::slice::from_ref(trial),
                same,
                |name, i, _, v| match name {
                    "specific_force_mps2" => v / (1.0 + lift(i)),
                    _ => v,
                },
            );
            one.into_iter().next().unwrap()
        })
        .collect();
    let text = refuse(&free);
    assert!(
        text.contains("extra lift of") && text.contains("95 % interval"),
        "{text}"
    );
}

#[test]
fn prop_a_log_carried_by_hand_gives_no_number() {
    let Some(trials) = crazypad() else { return };
    // Motors that are said to run, by a sine, and an accelerometer that feels a hand.
    let carried = changed(&trials, same, |name, i, t, v| match name {
        "specific_force_mps2" => 9.81 + 0.1 * (7.3 * t + f64::from(i as u32 % 13)).sin(),
        _ if name.starts_with("throttle") && v > 0.3 => 0.6 + 0.05 * (3.0 * t).sin(),
        _ => v,
    });
    let text = refuse(&carried);
    assert!(text.contains("follows the throttle"), "{text}");
}

#[test]
fn prop_a_throttle_in_percent_is_refused() {
    let Some(trials) = crazypad() else { return };
    let percent = changed(&trials[..1], same, |name, _, _, v| {
        if name.starts_with("throttle") {
            100.0 * v
        } else {
            v
        }
    });
    let error = Flight::of(&percent[0], &settings()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("throttle from 0 to 1") && text.contains("map"),
        "{text}"
    );
}

#[test]
fn prop_a_log_that_begins_with_motors_idling_on_the_floor_is_not_flight_there() {
    let Some(trials) = crazypad() else { return };
    // Logged from arming on: two seconds of idling before the take-off at 2.95 s, and nothing before.
    let trial = &trials[0];
    let rows: Vec<usize> = (0..trial.len())
        .filter(|&i| trial.time_s()[i] > 0.9)
        .collect();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let mut armed = Trial::new("armed", pick(trial.time_s())).unwrap();
    for (name, values) in trial.channels() {
        let mut values = pick(values);
        if name.starts_with("throttle") {
            values.iter_mut().for_each(|s| *s = s.max(0.1));
        }
        armed.insert(name, values).unwrap();
    }
    let flight = Flight::of(&armed, &settings()).unwrap();
    let phases = Phases::of(&flight, &settings());
    let idle = (0..flight.time_s.len()).filter(|&i| flight.time_s[i] < 2.8);
    assert!(idle.clone().count() > 100);
    assert!(idle.into_iter().all(|i| phases.rows[i] != Phase::Airborne));
    let airborne = phases.count(Phase::Airborne);
    assert!(airborne > 1000, "{airborne}");
}

#[test]
fn xval_thrust_of_five_flights_with_its_delay() {
    let Some(trials) = crazypad() else { return };
    let found = thrust_alone(&flights(&trials), &settings()).unwrap();
    // The lag of another Crazyflie, logged at 1 kHz under throttle pulses, is 0.060 s; its commands went through no radio.
    let delay = found.delay_s().unwrap();
    assert!(
        (0.05..=0.13).contains(&delay.value) && delay.std_error < 0.02,
        "{delay:?}"
    );
    // The motors' log, slowed to 10 Hz: no lag, and it says so.
    let slow = changed(&trials, same, |name, i, _, v| {
        if name.starts_with("throttle") && i % 10 != 0 {
            f64::NAN
        } else {
            v
        }
    });
    let found = thrust_alone(&flights(&slow), &settings()).unwrap();
    assert!(found.delay_s().is_none());
    assert!(
        found
            .refused
            .iter()
            .any(|r| r.what().contains("lag") && r.found().contains("0.099")),
        "{:?}",
        found.refused
    );
}

#[test]
fn xval_logs_of_autopilots() {
    let folder = tempfile::tempdir().unwrap();
    let quad = folder.path().join("quad.toml");
    std::fs::write(&quad, "[flight]\nmass_kg = 1.5\nrotor_radius_m = 0.12\n").unwrap();
    let quad = quad.display().to_string();
    if let Some(log) = data("log-px4-ulog/test_ulog.ulg") {
        // A fixed wing: its thrust is not along the axis of what lifts it.
        let log = log.display().to_string();
        let error = fails(1, ["identify", "thrust", &log, "--settings", &quad]);
        assert!(error.contains("follows the throttle"), "{error}");
    }
    if let Some(log) = data("log-ardupilot-dataflash/log171.bin") {
        let log = log.display().to_string();
        // Loiter, with vibration folded down to 50 Hz: throttle goes with climbs, not with the specific force. What is left
        // is the throttle of hover: motors at 1480 µs of 1000 to 1900.
        let error = fails(1, ["identify", "thrust", &log, "--settings", &quad]);
        assert!(error.contains("follows the throttle"), "{error}");
        let hover: f64 = error.trim().rsplit(' ').next().unwrap().parse().unwrap();
        assert!((hover - 0.533).abs() < 0.02, "{error}");
        // No range finder.
        let error = fails(1, ["identify", "ground-effect", &log, "--settings", &quad]);
        assert!(
            error.contains("height_m") && error.contains("range finder"),
            "{error}"
        );
    }
}

#[test]
fn prop_thrust_without_accelerometer_is_from_poses_or_refused() {
    let Some(trials) = crazypad() else { return };
    let strip = |names: &[&str]| {
        let trial = &trials[0];
        let mut out = Trial::new(trial.name(), trial.time_s().to_vec()).unwrap();
        for (name, values) in trial.channels().filter(|(n, _)| !names.contains(n)) {
            out.insert(name, values.to_vec()).unwrap();
        }
        out
    };
    let poses = strip(&["specific_force_mps2", "acceleration_mps2"]);
    let by_poses = with_thrust(&poses, &settings(), Some(0.03)).unwrap();
    let by_accelerometer = with_thrust(&trials[0], &settings(), Some(0.03)).unwrap();
    let mean = |t: &Trial| {
        let known: Vec<f64> = t
            .channel("thrust_n")
            .unwrap()
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    // The weight is 0.294 N; the mean over flights that end where they began is that.
    assert!((mean(&by_poses) / mean(&by_accelerometer) - 1.0).abs() < 0.02);
    let blind = strip(&[
        "specific_force_mps2",
        "acceleration_mps2",
        "height_m",
        "vehicle_velocity_mps",
    ]);
    let error = with_thrust(&blind, &settings(), Some(0.03))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("specific_force_mps2") && error.contains("40 Hz"),
        "{error}"
    );
}
