//! Vehicles that see neither the deck nor satellites.

use touchdown_lander::state_machine::Reason;
use touchdown_sim::deck::rigid::{RigidMotion, SeaSettings};
use touchdown_sim::landing::space::{
    FaultClock, SpaceLander, SpaceOutcome, SpaceScenario, TimeSpan,
};

/// No satellites, and no tag from a time on.
fn lose(scenario: &mut SpaceScenario, from_s: f64) {
    scenario.sensors.with_gnss = false;
    scenario.faults.since = FaultClock::Start;
    scenario.faults.tag_lost = vec![TimeSpan { from_s, to_s: 1e3 }];
}

#[test]
fn prop_who_knows_only_how_fast_it_climbs_climbs_and_gives_up() {
    let mut scenario = SpaceScenario {
        timeout_s: 40.0,
        ..SpaceScenario::default()
    };
    lose(&mut scenario, 0.0);
    let safe_m = scenario.control.state_machine.safe_height_m;
    for wind_mps in [0.0, 3.0, 8.0] {
        scenario.wind.steady_mps = [wind_mps, 0.0, 0.0];
        let lander = SpaceLander::new(&scenario).unwrap();
        for trial in 0..4 {
            let landing = lander.land(trial, 23, true).unwrap();
            let reason = Some(Reason::TagLost);
            assert_eq!(landing.outcome, SpaceOutcome::GivenUp { reason }, "{trial}");
            let rows = landing.trace.unwrap().rows;
            let late = rows.iter().filter(|row| row.time_s > 10.0);
            let lowest_m = late.map(|row| row.position_m[2]).fold(f64::MAX, f64::min);
            // The barometer holds it to a few decimetres.
            assert!(lowest_m > safe_m - 0.5, "{trial}: {lowest_m} m");
            // It keeps the trim that it started in, and drifts by errors of the attitude of up to 0.02 rad: the air's drag holds
            // that below 0.5 m/s. A level vehicle drifts with the wind.
            let end = rows.last().unwrap();
            let drift_mps = end.velocity_mps[0].hypot(end.velocity_mps[1]);
            assert!(drift_mps < 0.5, "{trial}: {drift_mps} m/s");
        }
    }
}

#[test]
fn prop_who_loses_sight_of_a_sea_stays_near_and_above_it() {
    let mut scenario = SpaceScenario {
        deck: RigidMotion::Sea(SeaSettings::default()),
        timeout_s: 60.0,
        ..SpaceScenario::default()
    };
    lose(&mut scenario, 8.0);
    let lander = SpaceLander::new(&scenario).unwrap();
    let mut unseeing = 0;
    for trial in 0..40 {
        let landing = lander.land(trial, 31, true).unwrap();
        if matches!(landing.outcome, SpaceOutcome::Landed { .. }) {
            continue;
        }
        let reason = Some(Reason::TagLost);
        assert_eq!(landing.outcome, SpaceOutcome::GivenUp { reason }, "{trial}");
        unseeing += 1;
        let rows = landing.trace.unwrap().rows;
        let [first, last] = [rows.first(), rows.last()].map(|row| row.unwrap().position_m);
        // It balances the mean disturbance of the last seconds, whose error the air's drag limits: 0.05 N are 0.25 m/s, in 30 s 7 m. One
        // that balances what it felt when it lost sight flies away, up to 20 m.
        let drift_m = (last[0] - first[0]).hypot(last[1] - first[1]);
        assert!(drift_m < 8.0, "{trial}: {drift_m} m");
        // By the barometer, a metre or less below the safe height.
        assert!(last[2] > 1.5, "{trial}: {} m", last[2]);
    }
    assert!(unseeing >= 8, "{unseeing} saw nothing");
}

#[test]
fn prop_an_error_of_the_accelerometer_is_no_wind() {
    let mut scenario = SpaceScenario {
        timeout_s: 50.0,
        ..SpaceScenario::default()
    };
    lose(&mut scenario, 8.0);
    // Never calm enough to land before 8 s.
    scenario.control.state_machine.deck_speed_mps = 1e-6;
    scenario.sensors.imu.bias_sd_mps2 = 0.2;
    for wind_mps in [0.0, 4.0] {
        scenario.wind.steady_mps = [wind_mps, 0.0, 0.0];
        let lander = SpaceLander::new(&scenario).unwrap();
        for trial in 0..8 {
            let landing = lander.land(trial, 47, true).unwrap();
            let reason = Some(Reason::TagLost);
            assert_eq!(landing.outcome, SpaceOutcome::GivenUp { reason }, "{trial}");
            let rows = landing.trace.unwrap().rows;
            let [first, last] = [rows.first(), rows.last()].map(|row| row.unwrap().position_m);
            let drift_m = (last[0] - first[0]).hypot(last[1] - first[1]);
            // In the 2 s in which it counts on its velocity an error of 0.2 m/s² makes 0.4 m/s, which the drag and the correction end
            // after about 2 and 6 s. An error that is balanced as wind moves it by up to 9 m.
            assert!(drift_m < 4.5, "{wind_mps} m/s, {trial}: {drift_m} m");
        }
    }
}
