use touchdown_sim::air::wind::{DrydenSettings, WindSettings};
use touchdown_sim::deck::rigid::SeaSettings;
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceLanding};

use super::*;
use crate::vehicle::{PRESETS, VehicleSettings};

fn of_preset(name: &str) -> Ratios {
    let text = format!("preset = \"{name}\"");
    let settings: VehicleSettings = toml::from_str(&text).unwrap();
    settings.with_preset().ratios()
}

fn flown(scenario: &SpaceScenario, trial: u64) -> SpaceLanding {
    SpaceLander::new(scenario)
        .unwrap()
        .land(trial, 1, false)
        .unwrap()
}

#[test]
fn prop_every_key_is_a_setting_and_stands_once() {
    let table = Table::try_from(SpaceScenario::default()).unwrap();
    for (k, entry) in TABLE.iter().enumerate() {
        let mut here = Some(&Value::Table(table.clone())).cloned();
        for part in entry.key.split('.') {
            here = here.and_then(|value| value.get(part).cloned());
        }
        assert!(here.is_some(), "{} is no setting", entry.key);
        assert!(
            TABLE[..k].iter().all(|other| other.key != entry.key),
            "{} stands twice",
            entry.key
        );
    }
}

/// Settings of the vehicle and its computer whose unit is one of length, time, mass or force.
fn has_a_unit(key: &str) -> bool {
    const UNITS: [&str; 13] = [
        "_m",
        "_s",
        "_mps",
        "_n",
        "_kg",
        "_hz",
        "_per_s",
        "_per_m",
        "_n2",
        "_per_s2",
        "_kg_m2",
        "_ns_per_m",
        "_ns2_per_m2",
    ];
    let free = ["deck.", "course.", "wind.", "faults.", "spread."];
    let own = !free.iter().any(|part| key.starts_with(part)) && !key.contains("thrust.library");
    own && UNITS.iter().any(|unit| key.ends_with(unit))
}

fn numbers(prefix: &str, table: &Table, found: &mut Vec<String>) {
    for (key, value) in table {
        let key = format!("{prefix}{key}");
        match value {
            Value::Table(below) => numbers(&format!("{key}."), below, found),
            Value::Float(_) | Value::Array(_) => found.push(key),
            _ => {}
        }
    }
}

#[test]
fn prop_every_setting_with_a_unit_has_a_law() {
    // Sensors whose errors are those of their electronics; what the assembly replaces; the shortest period that readings at 100 Hz
    // resolve.
    const FIXED: [&str; 35] = [
        "control.deck.shortest_period_s",
        "control.latency.greatest_s",
        "control.latency.memory_s",
        "control.latency.evidence_s",
        "sensors.imu.tilt_wander_s",
        "sensors.range.greatest_m",
        "sensors.range.schedule.jitter_s",
        "sensors.tag.camera.exposure_s",
        "sensors.tag.schedule.jitter_s",
        "sensors.gnss.horizontal_sd_mps",
        "sensors.gnss.vertical_sd_mps",
        "sensors.gnss.wander_s",
        "sensors.gnss.wander_sd_mps",
        "sensors.gnss.schedule.jitter_s",
        "sensors.barometer.ground_effect_m",
        "sensors.barometer.noise_sd_m",
        "sensors.barometer.schedule.jitter_s",
        "sensors.beacon.horizontal_sd_m",
        "sensors.beacon.vertical_sd_m",
        "sensors.beacon.place_s",
        "sensors.beacon.velocity_sd_mps",
        "sensors.beacon.velocity_wander_sd_mps",
        "sensors.beacon.schedule.jitter_s",
        "sensors.beacon.schedule.latency_s",
        "control.relative.imu.delay_s",
        "control.relative.range.greatest_m",
        "control.relative.range.jitter_s",
        "control.relative.range.least_m",
        "control.relative.range.quantum_m",
        "control.relative.tag.jitter_s",
        "control.lander.lateral_m.per_m",
        "body.torque_per_thrust_m",
        "plant.rotor_radius_m",
        "sensors.range.place_m",
        "sensors.tag.camera.place_m",
    ];
    let mut found = Vec::new();
    let table = Table::try_from(SpaceScenario::default()).unwrap();
    numbers("", &table, &mut found);
    let with_law = |key: &str| {
        TABLE
            .iter()
            .any(|e| e.key == key || key.starts_with(&format!("{}.", e.key)))
    };
    let missing: Vec<&String> = found
        .iter()
        .filter(|key| has_a_unit(key) && !with_law(key) && !FIXED.contains(&key.as_str()))
        .collect();
    assert!(missing.is_empty(), "without a law: {missing:?}");
}

#[test]
fn prop_the_standard_vehicle_keeps_every_bit() {
    let standard = Case::Paper.scenario();
    let of = of_preset("quadrotor_1.37kg");
    assert_eq!(of, Ratios::STANDARD);
    assert_eq!(scaled(&standard, &of, &|_| false).unwrap(), standard);
}

#[test]
fn prop_presets_validate_and_land() {
    for preset in PRESETS {
        let of = of_preset(preset.name);
        let mut scenario = scaled(&Case::Paper.scenario(), &of, &|_| false).unwrap();
        deck(&mut scenario.deck, of.radius);
        let landing = flown(&scenario, 0);
        let landed = landing.outcome.landed();
        assert!(landed, "{}: {:?}", preset.name, landing.outcome);
        // Neighbouring discs do not overlap.
        let arms = f64::from(preset.layout.arms());
        let apart_m = 2.0 * preset.arm_m * (std::f64::consts::PI / arms).sin();
        assert!(apart_m >= 2.0 * preset.rotor_radius_m, "{}", preset.name);
    }
}

#[test]
fn prop_a_stated_key_wins() {
    let of = of_preset("quadrotor_15kg");
    let scenario = SpaceScenario::default();
    let own = scaled(&scenario, &of, &|key| key == "control.lander.hold_height_m").unwrap();
    assert_eq!(own.control.state_machine.hold_height_m, 0.8);
    let length = own.legs.depth_m / scenario.legs.depth_m;
    // Rounding only.
    assert!((length - of.radius).abs() < 1e-12, "{length}");
}

#[test]
fn analytic_gains_of_a_small_vehicle_follow_by_half_the_power() {
    let gains = |radius: f64| {
        let of = Ratios::similar(radius);
        let own = scaled(&SpaceScenario::default(), &of, &|_| false).unwrap();
        own.control.gains
    };
    let standard = SpaceScenario::default().control.gains;
    for (radius, power) in [(0.25_f64, 0.25), (4.0, 0.5)] {
        let (own, mass) = (gains(radius), radius.powi(3));
        // Rounding only.
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{radius}: {a} {b}");
        close(own.gamma / standard.gamma, radius.powf(-power));
        close(own.k_p / standard.k_p, mass * radius.powf(-power));
        close(own.k_i / standard.k_i, mass * radius.powf(-2.0 * power));
        close(own.integral_limit_n / standard.integral_limit_n, mass);
    }
}

#[test]
fn analytic_feet_of_larger_vehicles_come_down_no_faster() {
    let standard = SpaceScenario::default();
    for preset in PRESETS {
        let of = of_preset(preset.name);
        let own = scaled(&standard, &of, &|_| false).unwrap();
        let idle = |scenario: &SpaceScenario| scenario.control.guidance.idle_n_per_s;
        let rate = idle(&own) / idle(&standard) / of.mass;
        if of.radius < 1.0 {
            // By similarity, as its crash speed. Rounding only, here and below.
            assert!(
                (rate * of.radius.sqrt() - 1.0).abs() < 1e-12,
                "{}",
                preset.name
            );
        } else {
            // h = ṡ t³/6 and v = ṡ t²/2 of a height that is as the arm.
            let speed = rate * (of.arm / rate).cbrt().powi(2);
            assert!((speed - 1.0).abs() < 1e-12, "{}: {speed}", preset.name);
        }
    }
    // Arms that are long for the rotors: at least 0.12 of the similar rate.
    let of = Ratios {
        arm: 3.5,
        mass: 3.0,
        ..Ratios::STANDARD
    };
    let own = scaled(&standard, &of, &|_| false).unwrap();
    let rate = own.control.guidance.idle_n_per_s / standard.control.guidance.idle_n_per_s;
    assert!((rate / 0.36 - 1.0).abs() < 1e-12, "{rate}");
}

#[test]
fn regress_fifteen_kilograms_land_in_wind() {
    let wind = WindSettings {
        steady_mps: [10.0, 0.0, 0.0],
        dryden: Some(DrydenSettings::low_altitude(3.0, 10.0).expect("a wind")),
        ..WindSettings::default()
    };
    let scenario = SpaceScenario {
        deck: RigidMotion::Sea(SeaSettings::default()),
        wind,
        timeout_s: 150.0,
        ..SpaceScenario::default()
    };
    let scenario = scaled(&scenario, &of_preset("quadrotor_15kg"), &|_| false).unwrap();
    // By similarity alone, 2 of these 10 crash: they fall from one foot onto the others.
    let landed = (0..10).filter(|&trial| flown(&scenario, trial).outcome.landed());
    assert_eq!(landed.count(), 10);
}

#[test]
fn analytic_froude_scaled_vehicles_fly_the_same_dimensionless_landing() {
    let mut scenario = Case::Still.scenario().without_noise();
    // Its hypotheses are those of electronics.
    scenario.control.finds_latency = false;
    let touch = flown(&scenario, 0).touch.unwrap();
    for radius in [0.25, 4.0] {
        let own = flown(&similar(&scenario, radius).unwrap(), 0)
            .touch
            .unwrap();
        let pace = f64::sqrt(radius);
        // Two steps of the standard control, 10 ms: periods of estimator and planner that are whole steps do not scale.
        let duration_s = own.t_l_s / pace;
        assert!(
            (duration_s - touch.t_l_s).abs() < 0.02,
            "{radius}: {duration_s} {}",
            touch.t_l_s
        );
        // What the plan brakes by in that time, 0.05 m/s² at its end.
        let speed_mps = own.v_l_mps / pace;
        assert!(
            (speed_mps - touch.v_l_mps).abs() < 0.002,
            "{radius}: {speed_mps} {}",
            touch.v_l_mps
        );
    }
}
