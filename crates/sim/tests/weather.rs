//! Landings in wind, in an airwake, on a deck that rolls, and from high hovers.

use touchdown_lander::state_machine::Reason;
use touchdown_sim::air::airwake::AirwakeSettings;
use touchdown_sim::air::wind::{DrydenSettings, GustSettings, WindSettings};
use touchdown_sim::deck::rigid::{Axis, RigidMotion, SeaSettings, Tone};
use touchdown_sim::landing::space::{SpaceLander, SpaceLanding, SpaceOutcome, SpaceScenario};

/// Number of landed and of crashed among the first landings of a scenario.
fn flown(scenario: &SpaceScenario, landings: u64) -> (usize, usize) {
    let lander = SpaceLander::new(scenario).expect("a valid scenario");
    let outcomes: Vec<_> = (0..landings)
        .map(|trial| lander.land(trial, 5, false).expect("it flies").outcome)
        .collect();
    let count = |of: fn(&_) -> bool| outcomes.iter().filter(|&outcome| of(outcome)).count();
    (count(SpaceOutcome::landed), count(SpaceOutcome::crashed))
}

/// The default sea in a wind.
fn sea(wind: WindSettings) -> SpaceScenario {
    SpaceScenario {
        deck: RigidMotion::Sea(SeaSettings::default()),
        wind,
        timeout_s: 120.0,
        ..SpaceScenario::default()
    }
}

/// Steady wind of 8 m/s with its turbulence.
fn eight_metres_a_second() -> WindSettings {
    WindSettings {
        steady_mps: [8.0, 0.0, 0.0],
        dryden: Some(DrydenSettings::low_altitude(3.0, 8.0).expect("a wind")),
        ..WindSettings::default()
    }
}

#[test]
fn regress_wind_of_eight_metres_a_second_with_its_turbulence() {
    // Before the start was trimmed and contact went by the lowest foot, 1 of 40 landed.
    let (landed, _) = flown(&sea(eight_metres_a_second()), 8);
    // 99 of 100 land; one in eight may be the other.
    assert!(landed >= 7, "{landed} of 8");
}

#[test]
fn regress_who_leans_into_the_wind_sets_the_other_feet_down_softly() {
    let scenario = sea(eight_metres_a_second());
    let lander = SpaceLander::new(&scenario).expect("a valid scenario");
    let hard = (0..40)
        .map(|trial| lander.land(trial, 6, false).expect("it flies"))
        .filter(|landing| landing.impact.is_none_or(|impact| impact.speed_mps > 0.3))
        .count();
    // These are 2; 28 where the thrust vanishes within 0.2 s and the vehicle levels. A tenth of more landings are hard (20 of 200,
    // `wind.toml` with seed 9101): the bound is twice that.
    assert!(hard <= 8, "{hard} of 40");
}

#[test]
fn prop_a_gust_that_would_push_the_vehicle_off_its_feet_is_waited_for() {
    // In 9 m/s the trim leans by less than the slope of 0.5 from which a gust counts, in 14 m/s by more.
    let mut scenario = sea(WindSettings {
        steady_mps: [9.0, 0.0, 0.0],
        ..WindSettings::default()
    });
    let lander = SpaceLander::new(&scenario).expect("a valid scenario");
    let touch_s = |landing: SpaceLanding| landing.touch.expect("it touches").time_s;
    for trial in 0..4 {
        let calm_s = touch_s(lander.land(trial, 5, false).expect("it flies"));
        let gust = GustSettings {
            velocity_mps: [5.0, 0.0, 0.0],
            start_s: calm_s - 1.2,
            rise_s: 0.8,
            hold_s: 2.0,
        };
        scenario.wind.gust = Some(gust);
        let gusty = SpaceLander::new(&scenario).expect("a valid scenario");
        let landing = gusty.land(trial, 5, false).expect("it flies");
        let over_s = gust.start_s + gust.rise_s + gust.hold_s;
        assert!(landing.outcome.landed(), "{landing:?}");
        assert!(
            landing
                .aborts
                .iter()
                .any(|a| a.reason == Some(Reason::Wind)),
            "{landing:?}"
        );
        assert!(touch_s(landing) > over_s);
    }
}

#[test]
fn prop_a_wind_that_is_always_so_strong_is_landed_in() {
    // Its slope is beyond 0.5, as a gust's may not be.
    let scenario = sea(WindSettings {
        steady_mps: [13.5, 0.0, 0.0],
        ..WindSettings::default()
    });
    let lander = SpaceLander::new(&scenario).expect("a valid scenario");
    for trial in 0..8 {
        let landing = lander.land(trial, 5, false).expect("it flies");
        assert!(landing.outcome.landed(), "{landing:?}");
        // The deck's motion and noise make a gust of it once in fifty landings.
        assert!(landing.descents <= 2, "{landing:?}");
    }
}

#[test]
fn regress_the_airwake_of_a_deckhouse() {
    let wind = WindSettings {
        steady_mps: [0.0, 8.0, 0.0],
        airwake: Some(AirwakeSettings {
            house_height_m: 4.0,
            distance_m: 8.0,
        }),
        ..WindSettings::default()
    };
    let (landed, crashed) = flown(&sea(wind), 4);
    assert_eq!((landed, crashed), (4, 0));
}

#[test]
fn regress_a_deck_that_rolls_by_eight_degrees() {
    let tone = |axis, amplitude, phase_rad| Tone {
        axis,
        amplitude,
        frequency_hz: 0.15,
        phase_rad,
    };
    let scenario = SpaceScenario {
        deck: RigidMotion::Sines {
            tones: vec![tone(Axis::Heave, 0.3, 0.0), tone(Axis::Roll, 0.1396, 1.0)],
        },
        timeout_s: 120.0,
        ..SpaceScenario::default()
    };
    assert_eq!(flown(&scenario, 6), (6, 0));
}

#[test]
fn regress_hovers_at_one_and_a_half_and_two_metres() {
    for height_m in [1.5, 2.0] {
        let mut scenario = SpaceScenario::default();
        scenario.control.state_machine.hold_height_m = height_m;
        assert_eq!(flown(&scenario, 4), (4, 0), "{height_m} m");
    }
    let mut high = SpaceScenario::default();
    high.control.state_machine.hold_height_m = 8.0;
    let refused = SpaceLander::new(&high)
        .expect_err("out of reach")
        .to_string();
    assert!(refused.contains("hold_height_m"), "{refused}");
}
