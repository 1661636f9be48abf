//! Landings by the lane.

use touchdown_sim::air::wind::{DrydenSettings, GustSettings, WindSettings};
use touchdown_sim::deck::rigid::{Axis, RigidMotion, Tone};
use touchdown_sim::landing::space::{Batch, Case, CrashCause, SpaceOutcome, SpaceScenario};

fn sea() -> SpaceScenario {
    SpaceScenario {
        wind: WindSettings {
            steady_mps: [1.0, 0.5, 0.0],
            dryden: DrydenSettings::low_altitude(6.0, 3.0).ok(),
            gust: None,
            airwake: None,
        },
        ..Case::Sea.scenario()
    }
}

#[test]
fn prop_a_lane_is_a_landing_alone_however_trials_are_divided() {
    let batch = Batch::new(&sea()).expect("a valid scenario");
    let whole = batch.land(0..19, 7).expect("a checked scenario");
    assert_eq!(whole.len(), 19);
    // Bit for bit: the same operations in the same order, none contracted.
    for (trial, landing) in (0..).zip(&whole) {
        assert_eq!(landing.trial_index, trial);
        let alone = batch.land_one(trial, 7).expect("a checked scenario");
        assert_eq!(landing, &alone);
    }
    for split in [1, 4, 13] {
        let mut parts = batch.land(0..split, 7).expect("a checked scenario");
        parts.extend(batch.land(split..19, 7).expect("a checked scenario"));
        assert_eq!(parts, whole);
    }
    let other = batch.land(0..3, 8).expect("a checked scenario");
    assert_ne!(other[0], whole[0]);
    assert!(batch.land(5..5, 7).expect("none to fly").is_empty());
}

#[test]
fn prop_it_lands_softly_on_the_papers_deck() {
    let batch = Batch::new(&Case::Paper.scenario()).expect("a valid scenario");
    for landing in batch.land(0..24, 1).expect("a checked scenario") {
        assert!(landing.outcome.landed(), "{landing:?}");
        let touch = landing.touch.expect("it touched");
        // The plan's sink rate is 0.03 m/s; with true states and turbulence of 3 % the
        // speed stays within a few times that.
        assert!(touch.v_l_mps < 0.15, "{touch:?}");
        assert!(touch.lateral_m < 0.1, "{touch:?}");
    }
}

#[test]
fn prop_what_comes_down_beside_the_deck_has_not_touched_it() {
    // Blown off a small deck, and down.
    let mut scenario = SpaceScenario {
        wind: WindSettings {
            steady_mps: [0.0; 3],
            dryden: None,
            // More than the thrust reserve holds, and not there at the trimmed start.
            gust: Some(GustSettings {
                velocity_mps: [30.0, 0.0, -12.0],
                start_s: 0.1,
                rise_s: 0.2,
                hold_s: 100.0,
            }),
            airwake: None,
        },
        ..SpaceScenario::default()
    };
    scenario.plant.plate_side_m = 0.6;
    let batch = Batch::new(&scenario).expect("a valid scenario");
    for landing in batch.land(0..4, 1).expect("a checked scenario") {
        let cause = CrashCause::Missed;
        assert_eq!(landing.outcome, SpaceOutcome::Crashed { cause });
        assert_eq!((landing.touch, landing.impact), (None, None));
    }
}

#[test]
fn prop_what_has_no_lanes_is_named() {
    let of = |scenario: &SpaceScenario| {
        let error = Batch::new(scenario).expect_err("it has no lanes");
        error.to_string()
    };
    let triangle = SpaceScenario {
        deck: RigidMotion::Triangle {
            amplitude_m: 0.1,
            speed_mps: 0.2,
            phase_rad: 0.0,
        },
        ..SpaceScenario::default()
    };
    let said = of(&triangle);
    assert!(said.contains("deck.kind") && said.contains("found triangle"));
    // (ω 0.1 s)⁶/46 080 at 8 Hz.
    let tone = |frequency_hz| SpaceScenario {
        deck: RigidMotion::Sines {
            tones: vec![Tone {
                axis: Axis::Heave,
                amplitude: 0.01,
                frequency_hz,
                phase_rad: 0.0,
            }],
        },
        ..SpaceScenario::default()
    };
    let said = of(&tone(8.0));
    assert!(
        said.contains("`deck`") && said.contains("found 0.350"),
        "{said}"
    );
    assert!(Batch::new(&tone(2.0)).is_ok());
    // What is not flown is not passed over.
    for case in Case::FAULTS {
        let scenario = case.scenario();
        let said = of(&scenario);
        assert!(said.contains("`faults."), "{said}");
        assert!(!said.contains("NaN"), "{said}");
    }
    let odd = SpaceScenario {
        control_period_s: 0.03,
        ..SpaceScenario::default()
    };
    assert!(of(&odd).contains("control_period_s") && of(&odd).contains("0.03"));
}
