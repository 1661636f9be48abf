//! What is said of landings that take more than one attempt.

use touchdown_lander::state_machine::Reason;
use touchdown_sim::landing::space::{
    CrashCause, FaultClock, FaultGust, FaultySensor, NanBurst, SpaceLander, SpaceOutcome,
    SpaceScenario, land,
};

#[test]
fn prop_the_hardest_contact_is_told_though_its_descent_was_broken_off() {
    let mut scenario = SpaceScenario::default();
    // Pressed onto the deck at the end of the first descent.
    scenario.faults.gust = Some(FaultGust {
        velocity_mps: [0.0, 0.0, -8.0],
        from_s: 1.0,
        rise_s: 0.2,
        hold_s: 0.3,
    });
    scenario.crash.speed_mps = 5.0;
    let lander = SpaceLander::new(&scenario).unwrap();
    let mut twice = 0;
    for trial in 0..5 {
        let landing = lander.land(trial, 1, true).unwrap();
        let rows = &landing.trace.as_ref().unwrap().rows;
        // By the record: the speed at which the deck was come upon.
        let down =
            |row: &touchdown_sim::landing::space::TraceRow| row.feet_n.iter().sum::<f64>() > 0.0;
        let touches = rows
            .windows(2)
            .filter(|pair| !down(&pair[0]) && down(&pair[1]));
        let recorded = touches
            .map(|pair| -pair[0].relative_mps[2])
            .fold(0.0, f64::max);
        let impact = landing.impact.expect("it has touched");
        // Rows are 10 ms apart: the gust changes the speed by 0.05 m/s in them.
        assert!(
            (impact.speed_mps - recorded).abs() < 0.15,
            "{impact:?} {recorded}"
        );
        assert!(
            impact.tilt_rad >= 0.0 && impact.tilt_rad < 0.35,
            "{impact:?}"
        );
        let touch = landing.touch.unwrap();
        assert!(impact.speed_mps >= touch.v_l_mps - 1e-12);
        if landing.descents > 1 && recorded > 0.3 {
            twice += 1;
            assert!(touch.v_l_mps < 0.2, "{touch:?}");
            assert!(impact.speed_mps > 0.25, "{impact:?}");
        }
    }
    assert!(
        twice > 0,
        "no hard touch in an aborted descent: nothing was tested"
    );
    // Without one, the hardest contact is the touch.
    let calm = SpaceScenario::default().without_noise();
    let landing = land(&calm, 0, 1).unwrap();
    let (impact, touch) = (landing.impact.unwrap(), landing.touch.unwrap());
    assert_eq!(impact.speed_mps, touch.v_l_mps);
}

#[test]
fn prop_a_landing_that_is_taken_up_again_was_not_given_up() {
    // Low in the hover, critical a second after it gave up: then any landing is better.
    let mut scenario = SpaceScenario::default();
    let of = &scenario.control.state_machine;
    scenario.battery_share = of.battery_critical + 0.05;
    scenario.battery_s = 20.0;
    let landing = land(&scenario, 0, 1).unwrap();
    assert!(landing.outcome.landed(), "{:?}", landing.outcome);
    // One that is not taken up has.
    scenario.battery_s = 900.0;
    let landing = land(&scenario, 0, 1).unwrap();
    // For what it gave up then, there having been no descent.
    let reason = Some(Reason::BatteryLow);
    assert_eq!(landing.outcome, SpaceOutcome::GivenUp { reason });
}

#[test]
fn prop_all_sensors_can_be_struck() {
    let mut none = SpaceScenario::default().without_noise();
    none.timeout_s = 1.5;
    let flown = |scenario: &SpaceScenario| {
        let lander = SpaceLander::new(scenario).unwrap();
        let landing = lander.land(0, 1, true).unwrap();
        assert_eq!(
            landing.outcome,
            SpaceOutcome::TimedOut,
            "{:?}",
            scenario.faults
        );
        landing.trace.unwrap().rows
    };
    let still = flown(&none);
    for sensor in [
        FaultySensor::Imu,
        FaultySensor::Attitude,
        FaultySensor::Gyro,
        FaultySensor::Range,
        FaultySensor::Tag,
        FaultySensor::Gnss,
        FaultySensor::Barometer,
        FaultySensor::All,
    ] {
        let mut struck = none.clone();
        struck.faults.since = FaultClock::Start;
        struck.faults.nan = vec![NanBurst {
            sensor,
            from_s: 0.5,
            to_s: 1.0,
        }];
        let rows = flown(&struck);
        // It makes a difference to something that is flown or believed, and leaves no NaN.
        assert!(rows != still, "{sensor:?} changes nothing");
        for row in &rows {
            let believed = row.estimated_m.iter().chain(&row.estimated_mps);
            let all = believed.chain(&row.throttle).all(|x| x.is_finite());
            assert!(all, "{sensor:?}: {row:?}");
        }
    }
}

#[test]
fn prop_what_comes_down_beside_the_deck_has_not_touched_it() {
    // Blown off the deck in the descent and pressed down there.
    let mut scenario = SpaceScenario::default();
    scenario.plant.plate_side_m = 0.6;
    scenario.faults.gust = Some(FaultGust {
        velocity_mps: [14.0, 0.0, -12.0],
        from_s: 0.3,
        rise_s: 0.2,
        hold_s: 2.0,
    });
    let lander = SpaceLander::new(&scenario).unwrap();
    for trial in 0..3 {
        let landing = lander.land(trial, 1, false).unwrap();
        let cause = CrashCause::Missed;
        assert_eq!(
            landing.outcome,
            SpaceOutcome::Crashed { cause },
            "{landing:?}"
        );
        assert_eq!((landing.touch, landing.impact), (None, None));
    }
}
