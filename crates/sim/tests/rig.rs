//! The virtual force rig.

use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::rig::profile::Profile;
use touchdown_sim::rig::sets::{
    Extent, VALIDATION_KINDS, VALIDATION_THRUSTS_N, ground_effect_moving,
    ground_effect_moving_validation, ground_effect_paper, ground_effect_rich,
    ground_effect_validation, thrust_training, thrust_validation,
};
use touchdown_sim::rig::{RigSettings, RigTrial, run};
use touchdown_trial::Trial;

fn still(throttle: f64, height_m: f64, duration_s: f64) -> RigTrial {
    RigTrial {
        name: "still".to_owned(),
        throttle: Profile::Constant { value: throttle },
        plate: Profile::Constant { value: height_m },
        carriage: None,
        duration_s,
        plate_present: true,
        start_throttle: None,
    }
}

fn channel<'a>(trial: &'a Trial, name: &str) -> &'a [f64] {
    trial.require(name).expect("the rig records it")
}

fn sd(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[test]
fn analytic_rest_is_recorded_as_rest() {
    let settings = RigSettings {
        noise: false,
        ..RigSettings::default()
    };
    let recorded = run(&settings, &still(0.4869, 0.2, 5.0), 1).expect("valid trial");
    assert_eq!(recorded.len(), 501);
    for (&truth, &measured) in channel(&recorded, "truth_thrust_n")
        .iter()
        .zip(channel(&recorded, "thrust_n"))
    {
        // Reference values 13.4397 and 1.2086 with four decimals, and the
        // rounded throttle: together below 3e-4. The quantum is 9.8e-4.
        assert!((truth - 13.4397 - 1.2086).abs() < 3e-4, "{truth}");
        assert!((measured - truth).abs() < 5e-4);
    }
}

#[test]
fn analytic_signs_of_a_plate_that_comes_up() {
    let trial = RigTrial {
        plate: Profile::Ramp {
            from: 0.5,
            to: 0.12,
            rate: 0.2,
            hold_s: 0.0,
            back: false,
        },
        ..still(0.48, 0.0, 3.0)
    };
    let recorded = run(&RigSettings::default(), &trial, 1).expect("valid trial");
    let at = |name: &str, i: usize| channel(&recorded, name)[i];
    // Rounding only.
    assert!((at("height_m", 100) - 0.3).abs() < 1e-12);
    assert!((at("deck_velocity_mps", 100) - 0.2).abs() < 1e-12);
    assert!((at("deck_height_m", 100) - 0.7).abs() < 1e-12);
    assert_eq!(at("deck_velocity_mps", 250), 0.0);
    assert_eq!(at("vehicle_velocity_mps", 100), 0.0);
}

#[test]
fn analytic_truth_is_late_by_the_nominal_latency() {
    let trial = RigTrial {
        throttle: Profile::Ramp {
            from: 0.3,
            to: 0.7,
            rate: 0.4,
            hold_s: 0.5,
            back: false,
        },
        plate_present: false,
        ..still(0.0, 0.75, 3.0)
    };
    let record = |latency_s: f64| {
        let mut settings = RigSettings {
            noise: false,
            ..RigSettings::default()
        };
        settings.load_cell.latency_s = latency_s;
        settings.load_cell.jitter_s = 0.0;
        settings.load_cell.quantum_n = 0.0;
        run(&settings, &trial, 1).expect("valid trial")
    };
    let (prompt, late) = (record(0.0), record(0.02));
    for name in ["truth_thrust_n", "truth_free_air_n", "thrust_n"] {
        let (prompt, late) = (channel(&prompt, name), channel(&late, name));
        for i in 2..prompt.len() {
            // Two samples of 10 ms; rounding of the interpolation.
            assert!((late[i] - prompt[i - 2]).abs() < 1e-9, "{name} {i}");
        }
    }
    // Without a plate there is no height to record and no ground effect; the
    // damping is zero too, for the rig stands still.
    assert!(late.channel("height_m").is_none());
    assert_eq!(
        channel(&late, "truth_thrust_n"),
        channel(&late, "truth_free_air_n")
    );
}

#[test]
fn analytic_noise_floor_of_turbulence() {
    // sd = 0.01 x² (0.2 + (q1* + q2*)/0.15), white noise 0.03 N.
    for (height_m, throttle) in [(0.10, 0.4869), (0.20, 0.4869)] {
        let settings = RigSettings::default();
        let recorded = run(&settings, &still(throttle, height_m, 600.0), 4).expect("valid trial");
        let noise: Vec<f64> = channel(&recorded, "thrust_n")
            .iter()
            .zip(channel(&recorded, "truth_thrust_n"))
            .map(|(a, b)| a - b)
            .collect();
        let plant = Plant::new(&settings.plant).expect("defaults are valid");
        let expected = plant
            .turbulence_sd_n(&plant.rest(throttle, height_m), height_m)
            .hypot(0.03);
        // 600 s are 2000 independent samples: a relative error of 1.6 %; 4 of them.
        assert!(
            (sd(&noise) / expected - 1.0).abs() < 0.065,
            "{}",
            sd(&noise)
        );
    }
}

#[test]
fn analytic_mean_error_that_turbulence_alone_leaves() {
    // √(2/π) sd: from 0.06 N (10 N at 0.20 m) to 0.13 N (16 N at 0.10 m),
    // reference values with two decimals.
    let plant = Plant::new(&PlantSettings::default()).expect("defaults are valid");
    for (thrust_n, height_m, expected_n) in [(10.0, 0.20, 0.06), (16.0, 0.10, 0.13)] {
        let throttle = plant.motor().throttle_for(thrust_n);
        let sd_n = plant.turbulence_sd_n(&plant.rest(throttle, height_m), height_m);
        let mean_n = std::f64::consts::FRAC_2_PI.sqrt() * sd_n;
        // Half a unit of the last digit.
        assert!((mean_n - expected_n).abs() < 5.1e-3, "{mean_n}");
    }
}

#[test]
fn prop_same_seed_same_bits_other_seed_other_noise() {
    let settings = RigSettings::default();
    let trials = ground_effect_rich(Extent::Quick);
    let multisine = trials
        .iter()
        .find(|t| t.name.starts_with("multisine"))
        .expect("the rich set has multi-sines");
    let bits = |seed: u64| {
        let recorded = run(&settings, multisine, seed).expect("valid trial");
        let values = recorded.channels().flat_map(|(_, v)| v.to_vec());
        values.map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(1));
    assert_ne!(bits(1), bits(2));
    let height = |seed| {
        let recorded = run(&settings, multisine, seed).expect("valid trial");
        channel(&recorded, "height_m").to_vec()
    };
    assert_ne!(height(1), height(2), "phases follow the seed");
}

#[test]
fn prop_names_are_unique_and_trials_run_on_both_plants() {
    for plant in [PlantSettings::default(), PlantSettings::exponential()] {
        let settings = RigSettings {
            plant,
            ..RigSettings::default()
        };
        let motor = *Plant::new(&plant).expect("defaults are valid").motor();
        let sets = |extent| {
            [
                thrust_training(false, extent),
                thrust_training(true, extent),
                thrust_validation(true),
                ground_effect_rich(extent),
                ground_effect_validation(&motor, extent),
            ]
        };
        for (quick, full) in sets(Extent::Quick).iter().zip(sets(Extent::Full)) {
            let mut names: Vec<_> = full.iter().map(|t| t.name.clone()).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), full.len());
            for trial in quick {
                assert!(full.contains(trial), "{} is not in the set", trial.name);
                let recorded = run(&settings, trial, 1).expect("a standard trial");
                let thrust = channel(&recorded, "thrust_n");
                assert!(thrust.iter().all(|f| (0.0..30.0).contains(f)));
            }
        }
    }
}

#[test]
fn paper_sizes_of_the_sets() {
    let motor = *Plant::new(&PlantSettings::default())
        .expect("defaults are valid")
        .motor();
    assert_eq!(thrust_training(true, Extent::Full).len(), 10);
    assert_eq!(thrust_validation(true).len(), 2);
    assert_eq!(ground_effect_paper(Extent::Full).len(), 10 + 21 + 6);
    assert_eq!(ground_effect_rich(Extent::Full).len(), 37 + 10 + 3);
    let validation = ground_effect_validation(&motor, Extent::Full);
    assert_eq!(
        validation.len(),
        VALIDATION_KINDS.len() * VALIDATION_THRUSTS_N.len()
    );
    assert!(validation.iter().any(|t| t.name == "approach-13N"));
}

#[test]
fn prop_losses_are_gaps() {
    let mut settings = RigSettings::default();
    settings.load_cell.loss_share = 0.05;
    let recorded = run(&settings, &still(0.5, 0.3, 60.0), 1).expect("valid trial");
    let gaps = channel(&recorded, "thrust_n")
        .iter()
        .filter(|v| v.is_nan())
        .count();
    // Binomial: 300 ± 17; five standard deviations.
    assert!((215..385).contains(&gaps), "{gaps}");
    assert!(
        channel(&recorded, "truth_thrust_n")
            .iter()
            .all(|v| v.is_finite())
    );
}

#[test]
fn prop_bad_trials_name_trial_key_and_number() {
    let settings = RigSettings::default();
    let cases = [
        (still(1.3, 0.2, 5.0), "throttle", "1.3"),
        (still(0.5, -0.2, 5.0), "plate", "-0.2"),
        (still(0.5, 0.2, -1.0), "duration_s", "-1"),
        (still(f64::NAN, 0.2, 1.0), "throttle.value", "NaN"),
        (
            RigTrial {
                start_throttle: Some(2.0),
                ..still(0.5, 0.2, 1.0)
            },
            "start_throttle",
            "2",
        ),
    ];
    for (trial, key, number) in cases {
        let message = run(&settings, &trial, 1).expect_err(key).to_string();
        for part in ["`still`", key, &format!("found {number}")] {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
    let mut settings = settings;
    settings.load_cell.rate_hz = 0.0;
    let message = run(&settings, &still(0.5, 0.2, 1.0), 1)
        .expect_err("no samples")
        .to_string();
    assert!(message.contains("load_cell.rate_hz"), "{message}");
}

#[test]
fn analytic_a_plate_that_comes_up_lifts_by_its_upwash_alone() {
    // Without ground effect proper the force on the still vehicle is k_v (x/√W) P(z_r) v_p: upwards when the plate
    // rises at 0.2 m/s, downwards when it falls.
    let mut settings = RigSettings {
        noise: false,
        ..RigSettings::default()
    };
    settings.plant.ground_effect_scale = 0.0;
    settings.load_cell.latency_s = 0.0;
    settings.load_cell.jitter_s = 0.0;
    let plant = Plant::new(&settings.plant).expect("valid settings");
    let throttle = plant.motor().throttle_for(plant.weight_n());
    for (from, to, sign) in [(0.55, 0.15, 1.0), (0.15, 0.55, -1.0)] {
        let trial = RigTrial {
            plate: Profile::Ramp {
                from,
                to,
                rate: 0.2,
                hold_s: 1.0,
                back: false,
            },
            ..still(throttle, from, 2.5)
        };
        let trial = run(&settings, &trial, 1).expect("valid trial");
        let (height, total) = (
            channel(&trial, "height_m"),
            channel(&trial, "truth_thrust_n"),
        );
        for i in (120..280).filter(|i| *i < trial.len()) {
            let u = (height[i] + 0.05) / 0.846_284;
            let upwash = std::f64::consts::FRAC_2_PI * ((1.0 / u).atan() - u / (1.0 + u * u));
            let expected = sign * 0.79 * upwash * 0.2;
            // The plate's side gives a to six digits.
            assert!(
                (total[i] - plant.weight_n() - expected).abs() < 1e-5,
                "{i}: {} {expected}",
                total[i] - plant.weight_n()
            );
        }
    }
}

#[test]
fn analytic_a_carriage_that_climbs_is_damped() {
    // Without ground effect proper the force on a vehicle that climbs over a plate at rest is -k_v (x/√W) v_q.
    let mut settings = RigSettings {
        noise: false,
        ..RigSettings::default()
    };
    settings.plant.ground_effect_scale = 0.0;
    settings.load_cell.latency_s = 0.0;
    settings.load_cell.jitter_s = 0.0;
    let plant = Plant::new(&settings.plant).expect("valid settings");
    let throttle = plant.motor().throttle_for(plant.weight_n());
    let trial = RigTrial {
        carriage: Some(Profile::Ramp {
            from: 0.0,
            to: 0.4,
            rate: 0.2,
            hold_s: 1.0,
            back: false,
        }),
        ..still(throttle, 0.15, 2.9)
    };
    let trial = run(&settings, &trial, 1).expect("valid trial");
    let truth = channel(&trial, "truth_thrust_n");
    for i in 120..trial.len() {
        let expected = -0.79 * 0.2;
        // Only the motor's settling at its rest is left: rounding of the throttle that gives the weight.
        assert!((truth[i] - plant.weight_n() - expected).abs() < 1e-6);
    }
}

#[test]
fn prop_moving_trials_keep_clear_of_the_plate_and_their_channels_belong_together() {
    let settings = RigSettings::default();
    let trials = ground_effect_moving(Extent::Quick);
    assert_eq!(ground_effect_moving(Extent::Full).len(), 2 * (5 + 3));
    let unseen = ground_effect_moving_validation(Extent::Full);
    assert_eq!(unseen.len(), 4);
    for planned in trials.iter().chain(&unseen) {
        let trial = run(&settings, planned, 3).expect("valid trial");
        let (t, z) = (trial.time_s(), channel(&trial, "height_m"));
        let (up, down) = (
            channel(&trial, "vehicle_velocity_mps"),
            channel(&trial, "deck_velocity_mps"),
        );
        assert!(z.iter().all(|z| *z > 0.099), "{}", trial.name());
        assert!(sd(up) > 0.02 && sd(down) > 0.03, "{}", trial.name());
        for i in 1..t.len() - 1 {
            let slope = (z[i + 1] - z[i - 1]) / (t[i + 1] - t[i - 1]);
            // Central differences over 20 ms: w³ h²/6 of 0.2 m at 7 rad/s is 1.2 mm/s.
            assert!((slope - (up[i] - down[i])).abs() < 1.2e-3, "{i}");
        }
    }
}

#[test]
fn prop_a_carriage_below_the_plate_is_refused() {
    let trial = RigTrial {
        carriage: Some(Profile::Constant { value: -0.3 }),
        ..still(0.5, 0.2, 1.0)
    };
    let message = run(&RigSettings::default(), &trial, 1)
        .expect_err("below the plate")
        .to_string();
    assert!(message.contains("carriage"), "{message}");
}
