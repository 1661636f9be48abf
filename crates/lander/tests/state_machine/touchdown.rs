//! Rows of the table for a vehicle on the deck.

use std::f64::consts::TAU;

use touchdown_lander::state_machine::{MachineInput, OperatorRequest, Phase, Reason};

use crate::table::{leave, reach};
use crate::world::{DT, Flight, STANDING_M, World};

#[test]
fn analytic_what_ends_a_touchdown() {
    // A bounce: off the deck for 0.2 s, then down once more.
    let mut flight = reach(Phase::Touchdown);
    let (out, after) = leave(&mut flight, Phase::Touchdown, |s| s.height_m = 0.2);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::Commit, Some(Reason::Bounce))
    );
    assert!((after - 0.2 - DT).abs() < 1.5 * DT);
    flight.until(|out| out.phase == Phase::Disarmed);

    // A range finder stuck at 0.1 m in the air: the IMU feels the fall.
    let mut flight = reach(Phase::Touchdown);
    flight.world = World {
        height_m: 3.0,
        ..World::new()
    };
    let (out, _) = leave(&mut flight, Phase::Touchdown, |s| {
        s.height_m = 0.1;
        s.relative_velocity_mps = 0.0;
    });
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::NotSupported))
    );
    // Thrust falls by 3 /s: below a half after 0.17 s, felt for 0.05 s. Falling
    // 0.1 s at a third of g costs a tenth of a metre, not two.
    assert!(flight.world.height_m > 2.8, "{}", flight.world.height_m);

    // Blind on the deck: no evidence, and no staying either.
    let mut flight = reach(Phase::Touchdown);
    let (out, _) = leave(&mut flight, Phase::Touchdown, |s| s.height_m = f64::NAN);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::NotFinite))
    );
    let mut flight = reach(Phase::Touchdown);
    let (out, _) = leave(&mut flight, Phase::Touchdown, |s| {
        s.request = OperatorRequest::Abort;
    });
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::Operator))
    );
}

#[test]
fn analytic_who_leans_on_one_foot_is_not_down() {
    // On the deck, with one foot lower than the others by this, m, and this thrust over the weight.
    let leaning = |drop_m: f64, thrust_share: f64| {
        move |s: &mut MachineInput<f64>| {
            s.foot_drop_m = drop_m;
            s.height_m = STANDING_M + drop_m;
            s.thrust_share = thrust_share;
            s.load_factor = 1.0;
        }
    };
    // The rotors run on while the thrust is above a tenth of the weight. Without the rule they stop 0.2 s after it is
    // below a half.
    let mut flight = reach(Phase::Touchdown);
    for _ in 0..200 {
        let out = flight.step(leaning(0.015, 0.11));
        assert_eq!(out.phase, Phase::Touchdown);
    }
    // Level within `leaning_m` at the same thrust, or with almost no thrust: 0.2 s of evidence.
    let mut almost_off = reach(Phase::Touchdown);
    for (flight, drop_m, thrust_share) in
        [(&mut flight, 0.009, 0.11), (&mut almost_off, 0.015, 0.09)]
    {
        let (out, after) = leave(flight, Phase::Touchdown, leaning(drop_m, thrust_share));
        assert_eq!(out.phase, Phase::Disarmed);
        assert!((after - 0.2 - DT).abs() < 1.5 * DT, "{after}");
    }
}

#[test]
fn analytic_a_deck_that_shakes_carries_a_vehicle_that_stands() {
    // Almost no thrust, and a load that goes up and down with the deck at 12 Hz.
    let shaking = |flight: &mut Flight, thrust_share: f64, least_load: f64| {
        (0..100).find_map(|i| {
            let share = (TAU * 12.0 * DT * f64::from(i)).sin();
            let out = flight.step(|s| {
                s.thrust_share = thrust_share;
                s.load_factor = 1.0 + (1.0 - least_load) * share;
            });
            (out.phase == Phase::Disarmed).then_some(f64::from(i) * DT)
        })
    };
    let after = shaking(&mut reach(Phase::Touchdown), 0.04, 0.3).unwrap();
    assert!((after - 0.2 - DT).abs() < 1.5 * DT, "{after}");
    // More thrust may carry more itself, and a load below a fifth of the weight beyond it is that of a fall.
    for (thrust_share, least_load) in [(0.15, 0.3), (0.04, 0.2)] {
        let mut flight = reach(Phase::Touchdown);
        assert_eq!(shaking(&mut flight, thrust_share, least_load), None);
    }
}

#[test]
fn analytic_what_is_no_touchdown() {
    type Change = fn(&mut MachineInput<f64>);
    // Sliding, sinking, or above the deck: low as it is, it is not taken for one.
    let cases: [Change; 4] = [
        |s| s.lateral_speed_mps = 0.26,
        |s| s.relative_velocity_mps = -0.13,
        |s| s.relative_velocity_mps = 0.13,
        |s| s.height_m = 0.121,
    ];
    for change in cases {
        let mut flight = reach(Phase::Commit);
        let (out, _) = leave(&mut flight, Phase::Commit, change);
        assert_eq!(out.phase, Phase::GoAround);
        // And one that had begun ends as a bounce.
        let mut flight = reach(Phase::Touchdown);
        let (out, _) = leave(&mut flight, Phase::Touchdown, change);
        assert_eq!(out.phase, Phase::Commit);
    }
}

#[test]
fn analytic_a_contact_switch_decides() {
    // It says no: never a touchdown.
    let mut flight = reach(Phase::Commit);
    let (out, _) = leave(&mut flight, Phase::Commit, |s| s.contact = Some(false));
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::Late))
    );
    // It says yes: the thrust need not be down for the evidence.
    let mut flight = reach(Phase::Touchdown);
    flight.world.height_m = STANDING_M;
    flight.world.velocity_mps = 0.0;
    let (out, after) = leave(&mut flight, Phase::Touchdown, |s| {
        s.contact = Some(true);
        s.thrust_share = 0.9;
    });
    assert_eq!(out.phase, Phase::Disarmed);
    assert!((after - 0.2 - DT).abs() < 1.5 * DT, "{after}");
}
