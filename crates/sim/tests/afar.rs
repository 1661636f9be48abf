//! Starts higher up than the range finder reaches, where a tag is seen seldom and its height is rough.

use touchdown_lander::state_machine::Phase;
use touchdown_sim::deck::rigid::{RigidMotion, SeaSettings};
use touchdown_sim::landing::space::{SpaceLander, SpaceOutcome, SpaceScenario};

#[test]
fn prop_starts_above_the_range_finders_reach_land_as_those_below() {
    let at_sea = |start_m| SpaceScenario {
        deck: RigidMotion::Sea(SeaSettings::default()),
        start_m,
        timeout_s: 150.0,
        ..SpaceScenario::default()
    };
    // The range finder reaches 12 m. From 25 m few images show the tag.
    for start_m in [[0.0, 0.0, 15.0], [5.0, 0.0, 25.0]] {
        let scenario = at_sea(start_m);
        let hold_m = scenario.control.state_machine.hold_height_m;
        let lander = SpaceLander::new(&scenario).unwrap();
        for trial in 0..4 {
            let landing = lander.land(trial, 5, true).unwrap();
            assert_eq!(
                landing.outcome,
                SpaceOutcome::Landed { attempts: 1 },
                "{start_m:?} {trial}"
            );
            // A sea of 0.5 m is calm, and the hover that of a still deck, but for half of the 1.5 m by which a rough one raises it. Rough
            // heights of the approach that count as waves raise it by all of that.
            let rows = landing.trace.unwrap().rows;
            let waits = rows.iter().filter(|row| row.phase == Phase::Wait);
            let highest_m = waits.map(|row| row.relative_m[2]).fold(0.0, f64::max);
            assert!(
                highest_m < hold_m + 0.75,
                "{start_m:?} {trial}: {highest_m} m"
            );
        }
    }
}

#[test]
fn prop_starts_are_in_the_air_and_not_lost() {
    // A third of all draws is too low, and 0.46 lie 5 m or more to the side.
    let mut scenario = SpaceScenario {
        start_m: [0.0, 0.0, 0.4],
        start_sd_m: [4.0, 4.0, 0.6],
        timeout_s: 0.01,
        ..SpaceScenario::default()
    };
    scenario.crash.lost_m = 5.0;
    let lander = SpaceLander::new(&scenario).unwrap();
    let mut heights_m = Vec::new();
    for trial in 0..200 {
        let landing = lander.land(trial, 3, true).unwrap();
        assert!(
            matches!(landing.outcome, SpaceOutcome::TimedOut),
            "{landing:?}"
        );
        heights_m.push(landing.trace.unwrap().rows[0].relative_m[2]);
    }
    // No height stands twice, as those did that were set to the least one.
    heights_m.sort_by(f64::total_cmp);
    let least_m = scenario.landed_height_m + 0.05;
    assert!(heights_m[0] >= least_m, "{}", heights_m[0]);
    assert!(heights_m.windows(2).all(|pair| pair[0] < pair[1]));
    let redrawn: u32 = (0..200)
        .map(|trial| scenario.redrawn_starts(trial, 3))
        .sum();
    // 0.36 of all draws are accepted, so that 1.8 are replaced in a trial, and 360 ± 32 in all; within four standard deviations.
    assert!((230..490).contains(&redrawn), "{redrawn}");
    // The default start is some ten standard deviations above the deck.
    let standard = SpaceScenario::default();
    assert!((0..200).all(|trial| standard.redrawn_starts(trial, 3) == 0));
}
