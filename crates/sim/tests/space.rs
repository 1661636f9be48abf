//! Whole landings: sensors, landing computer, vehicle, deck.

use touchdown_flight::Method;
use touchdown_lander::settings::DescentShape;
use touchdown_sim::deck::rigid::{Axis, RigidMotion, Tone};
use touchdown_sim::landing::space::{
    FaultySensor, NanBurst, SpaceLander, SpaceLanding, SpaceOutcome, SpaceScenario, TimeSpan,
    WeakRotor, land,
};

/// A deck that heaves in a sine.
fn heaving(amplitude: f64, frequency_hz: f64) -> SpaceScenario {
    SpaceScenario {
        deck: RigidMotion::Sines {
            tones: vec![Tone {
                axis: Axis::Heave,
                amplitude,
                frequency_hz,
                phase_rad: 0.0,
            }],
        },
        ..SpaceScenario::default()
    }
}

fn landings(scenario: &SpaceScenario, trials: u64) -> Vec<SpaceLanding> {
    let lander = SpaceLander::new(scenario).expect("a valid scenario");
    let land = |trial| lander.land(trial, 1, false).expect("a checked scenario");
    (0..trials).map(land).collect()
}

#[test]
fn analytic_without_noise_it_lands_on_the_plan() {
    let scenario = SpaceScenario::default().without_noise();
    let landing = land(&scenario, 0, 1).unwrap();
    assert_eq!(landing.outcome, SpaceOutcome::Landed { attempts: 1 });
    assert!(landing.aborts.is_empty());
    let touch = landing.touch.unwrap();
    // The shortest descent the planner allows, 2.0 s, then the last centimetre at
    // the sink rate of 0.03 m/s; the model's error moves it by a few millimetres, and
    // by some tenths of that rate.
    assert!((2.0..2.7).contains(&touch.t_l_s), "{touch:?}");
    assert!((touch.v_l_mps - 0.03).abs() < 0.015, "{touch:?}");
    // Monotone from 0.8 to 0.1 m, and what the hover was off.
    assert!((touch.s_l_m - 0.7).abs() < 0.02, "{touch:?}");
    assert!(
        touch.lateral_m < 0.002 && touch.tilt_rad < 0.002,
        "{touch:?}"
    );
    // It stands: four feet carry 13.44 N, the damping of a touch adds 10 % or so.
    assert!((3.3..5.0).contains(&landing.greatest_foot_n), "{landing:?}");
    assert!(landing.slide_m < 1e-3);
}

#[test]
fn prop_a_landing_is_a_function_of_scenario_seed_and_index() {
    let scenario = heaving(0.05, 0.5);
    let lander = SpaceLander::new(&scenario).unwrap();
    let first = lander.land(3, 7, false).unwrap();
    lander.land(4, 7, false).unwrap();
    assert_eq!(first, lander.land(3, 7, false).unwrap());
    // Being watched changes nothing.
    let mut watched = lander.land(3, 7, true).unwrap();
    let trace = watched.trace.take().unwrap();
    assert_eq!(first, watched);
    assert_eq!(trace.rows.len() as u64, first.steps.div_ceil(10));
    for (trial, seed) in [(4, 7), (3, 8)] {
        assert_ne!(first.touch, lander.land(trial, seed, false).unwrap().touch);
    }
}

#[test]
fn regress_the_papers_deck_with_all_sensors() {
    let landings = landings(&heaving(0.05, 0.5), 30);
    let mut speeds = 0.0;
    for landing in &landings {
        assert_eq!(
            landing.outcome,
            SpaceOutcome::Landed { attempts: 1 },
            "{landing:?}"
        );
        let touch = landing.touch.unwrap();
        // Of 2000: at most 0.151 m/s, 0.045 m and 3.54 s.
        assert!(touch.v_l_mps < 0.2 && touch.lateral_m < 0.06, "{touch:?}");
        assert!(touch.t_l_s < 4.0, "{touch:?}");
        speeds += touch.v_l_mps;
    }
    // Of 1000: 0.045; the standard error of the mean of 30 is 0.003.
    assert!(speeds / 30.0 < 0.055, "{}", speeds / 30.0);
}

#[test]
fn prop_every_controller_and_descent_flies() {
    for controller in Method::ALL {
        for reference in [DescentShape::Terminal, DescentShape::Exponential] {
            let mut scenario = heaving(0.05, 0.5);
            scenario.control.method = controller;
            scenario.control.reference = reference;
            scenario.timeout_s = 40.0;
            for landing in landings(&scenario, 2) {
                // All of them can, of twelve of each as well; how softly is another matter.
                assert!(
                    landing.outcome.landed(),
                    "{controller:?} {reference:?} {landing:?}"
                );
            }
        }
    }
}

#[test]
fn prop_faults_end_in_landings_or_aborts() {
    let paper = || heaving(0.05, 0.5);
    let span = |from_s, to_s| TimeSpan { from_s, to_s };
    // The tag is away for longer than a descent may miss it: one go-around.
    let mut scenario = paper();
    scenario.faults.tag_lost = vec![span(0.2, 1.2)];
    for landing in landings(&scenario, 5) {
        assert_eq!(
            landing.outcome,
            SpaceOutcome::Landed { attempts: 2 },
            "{landing:?}"
        );
        assert!(landing.aborts[0].height_m > 0.3);
    }
    // It never comes back: aloft by velocities, wherever the estimate of the place has
    // gone to.
    let mut scenario = paper();
    scenario.faults.tag_lost = vec![span(0.2, 100.0)];
    scenario.timeout_s = 60.0;
    for landing in landings(&scenario, 3) {
        assert_eq!(landing.descents, 1);
        assert!(!landing.outcome.crashed(), "{landing:?}");
        assert!(!landing.outcome.landed(), "{landing:?}");
    }
    // Nothing but NaN for a while.
    let mut scenario = paper();
    scenario.faults.nan = vec![NanBurst {
        sensor: FaultySensor::All,
        from_s: 0.5,
        to_s: 0.7,
    }];
    for landing in landings(&scenario, 5) {
        assert!(landing.outcome.landed(), "{landing:?}");
        assert!(!landing.aborts.is_empty());
    }
    // Readings a tenth of a second later: stamped, the estimator makes up for it; not
    // stamped, it is found by the swing that comes of it.
    for (known, found_s) in [(true, 0.0), (false, 0.1)] {
        let mut scenario = paper();
        scenario.faults.extra_latency_s = 0.1;
        scenario.faults.extra_latency_known = known;
        for landing in landings(&scenario, 5) {
            assert_eq!(
                landing.outcome,
                SpaceOutcome::Landed { attempts: 1 },
                "{landing:?}"
            );
            // Of 400: 0.0981 on average, with a standard deviation of 2 ms.
            let error_s = landing.estimated_latency_s - found_s;
            assert!(error_s.abs() < 0.012, "{landing:?}");
        }
    }
    let mut scenario = paper();
    scenario.faults.range_missing_share = 0.1;
    scenario.faults.rotor = Some(WeakRotor {
        rotor: 2,
        share: 0.8,
        from_s: 0.5,
    });
    for landing in landings(&scenario, 5) {
        assert!(landing.outcome.landed(), "{landing:?}");
    }
}

#[test]
fn regress_a_rising_sea_with_tilt_and_sway() {
    let mut scenario = heaving(0.3, 0.2);
    if let RigidMotion::Sines { tones } = &mut scenario.deck {
        tones.push(Tone {
            axis: Axis::Roll,
            amplitude: 0.0524,
            frequency_hz: 0.2,
            phase_rad: 1.0,
        });
    }
    for landing in landings(&scenario, 10) {
        assert!(landing.outcome.landed(), "{landing:?}");
        // Of 2000: at most 0.132 m/s.
        assert!(landing.touch.unwrap().v_l_mps < 0.2, "{landing:?}");
    }
}

#[test]
fn prop_scenarios_that_make_no_sense_are_refused() {
    type Change = fn(&mut SpaceScenario);
    let refused = |change: Change, words: &[&str]| {
        let mut scenario = SpaceScenario::default();
        change(&mut scenario);
        let error = SpaceLander::new(&scenario).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "{word}: {error}");
        }
    };
    refused(
        |s| s.body.inertia_kg_m2[0] = -1.0,
        &["body.inertia_kg_m2", "-1"],
    );
    refused(|s| s.control_period_s = 0.0, &["control_period_s", "0"]);
    refused(
        |s| s.control_period_s = 0.0015,
        &["control_period_s", "0.0015"],
    );
    refused(
        |s| s.start_m[2] = 0.05,
        &["start_m", "landed_height_m", "0.05"],
    );
    refused(|s| s.timeout_s = f64::NAN, &["timeout_s", "NaN"]);
    refused(
        |s| s.sensors.range.schedule.rate_hz = 0.0,
        &["sensors.range.schedule.rate_hz", "0"],
    );
    refused(
        |s| s.sensors.imu.noise_density = -1.0,
        &["sensors.imu.noise_density", "-1"],
    );
    refused(
        |s| s.faults.range_missing_share = 1.5,
        &["faults.range_missing_share", "1.5"],
    );
    refused(
        |s| {
            s.faults.tag_lost = vec![TimeSpan {
                from_s: 2.0,
                to_s: 1.0,
            }];
        },
        &["faults.tag_lost.to_s", "1"],
    );
    refused(|s| s.control.gains.k_p = -4.0, &["control", "k_p", "-4"]);
    refused(
        |s| s.ground_effect_strength = f64::INFINITY,
        &["ground_effect_strength", "inf"],
    );
    refused(
        |s| {
            s.deck = RigidMotion::Sines {
                tones: vec![Tone {
                    axis: Axis::Heave,
                    amplitude: 0.1,
                    frequency_hz: 0.0,
                    phase_rad: 0.0,
                }],
            };
        },
        &["deck.tones.frequency_hz", "0"],
    );
    refused(
        |s| s.wind.steady_mps[0] = f64::NAN,
        &["wind.steady_mps", "NaN"],
    );
}

#[test]
fn prop_no_satellites_are_needed_to_land() {
    // Where it is relative to the deck, range, tag and inertial unit tell.
    for mut scenario in [SpaceScenario::default(), heaving(0.3, 0.2)] {
        scenario.sensors.with_gnss = false;
        for landing in landings(&scenario, 8) {
            assert_eq!(landing.outcome, SpaceOutcome::Landed { attempts: 1 });
            let touch = landing.touch.unwrap();
            // As with them: the planner's sink rate is 0.03 m/s, the deck's up to 0.38.
            assert!(touch.v_l_mps < 0.2 && touch.lateral_m < 0.1, "{touch:?}");
        }
    }
    // Away from the deck and back, the tag being lost for a second.
    let mut scenario = heaving(0.05, 0.5);
    scenario.sensors.with_gnss = false;
    scenario.faults.tag_lost = vec![TimeSpan {
        from_s: 0.5,
        to_s: 1.5,
    }];
    for landing in landings(&scenario, 8) {
        assert_eq!(landing.outcome, SpaceOutcome::Landed { attempts: 2 });
    }
}

#[test]
fn prop_a_scenario_survives_its_file() {
    let scenario = heaving(0.3, 0.2);
    let text = toml::to_string(&scenario).unwrap();
    assert!(text.contains("controller = \"dynamic+observer\""), "{text}");
    assert_eq!(toml::from_str::<SpaceScenario>(&text).unwrap(), scenario);
    // Settings may be few; unknown ones are refused by name.
    let few: SpaceScenario = toml::from_str("[control]\ncontroller = \"feedback\"").unwrap();
    assert_eq!(few.control.method, Method::Feedback);
    let error = toml::from_str::<SpaceScenario>("[control]\ncontroller = \"magic\"").unwrap_err();
    assert!(error.to_string().contains("magic"), "{error}");
    let error = toml::from_str::<SpaceScenario>("[sensors]\nsonar = 1").unwrap_err();
    assert!(error.to_string().contains("sonar"), "{error}");
}

#[test]
fn regress_the_rotors_stop_within_a_second_of_the_touch_and_never_above_the_deck() {
    // The decks of the paper, and one at rest.
    for (amplitude, trials) in [(0.0, 20), (0.05, 20), (0.10, 20)] {
        for landing in landings(&heaving(amplitude, 0.5), trials) {
            assert_eq!(landing.outcome, SpaceOutcome::Landed { attempts: 1 });
            let touch = landing.touch.unwrap();
            // A landing ends 0.5 s after its rotors have stopped.
            let stopped_s = landing.end_s - 0.5 - touch.time_s;
            assert!((0.0..1.0).contains(&stopped_s), "{stopped_s} {touch:?}");
        }
    }
}
