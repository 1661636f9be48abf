//! Rows of the table, one by one.

use touchdown_lander::state_machine::{
    Frame, MachineInput, MachineOutput, Maneuver, OperatorRequest, Phase, Reason, StateMachine,
};

use crate::world::{DT, Flight, STANDING_M, good};

pub(crate) fn reach(phase: Phase) -> Flight {
    let mut flight = Flight::new();
    flight.until(|out| out.phase == phase);
    flight
}

/// Steps under a change until the phase leaves `phase`, at most 200 s.
pub(crate) fn leave(
    flight: &mut Flight,
    phase: Phase,
    change: impl Fn(&mut MachineInput<f64>),
) -> (MachineOutput<f64>, f64) {
    for i in 1..=20_000 {
        let out = flight.step(&change);
        if out.phase != phase {
            return (out, DT * f64::from(i));
        }
    }
    panic!("stays in {phase:?}");
}

#[test]
fn analytic_a_landing_without_trouble() {
    let mut flight = Flight::new();
    let mut phases = vec![];
    let mut entered = vec![];
    for i in 0..3000 {
        let out = flight.step(|_| ());
        if phases.last() != Some(&out.phase) {
            phases.push(out.phase);
            entered.push(DT * f64::from(i));
        }
        assert_eq!(out.reason, None);
        assert_eq!(out.go_arounds, 0);
    }
    use Phase::*;
    assert_eq!(phases, [Hold, Wait, Descend, Commit, Touchdown, Disarmed]);
    // Half a second of being ready, counted from the first sample (0 s).
    assert!((entered[1] - 0.5).abs() < 1.5 * DT);
    // The thrust is at half the weight 0.5/3 s after it is taken back, and then the
    // evidence must hold for 0.2 s. Touching began up to 2 cm above the
    // deck: 1 cm of slow fall in between costs at most another 0.15 s.
    let after_contact = entered[5] - entered[4] - (0.5 / 3.0 + 0.2);
    assert!((0.0..0.15).contains(&after_contact), "{after_contact}");
    assert!(flight.world.standing());
}

#[test]
fn analytic_every_abort_of_a_descent() {
    type Change = fn(&mut MachineInput<f64>);
    // What is wrong, the reason given, and the time it takes to count.
    let cases: [(Change, Reason, f64); 17] = [
        (
            |s| s.request = OperatorRequest::Abort,
            Reason::Operator,
            0.0,
        ),
        (|s| s.tag_age_s = 0.31, Reason::TagLost, 0.0),
        (|s| s.tag_age_s = f64::NAN, Reason::TagLost, 0.0),
        (|s| s.tag_age_s = -0.01, Reason::TagLost, 0.0),
        (
            |s| (s.range_age_s, s.tag_age_s, s.height_sd_m) = (0.16, 0.31, 0.031),
            Reason::RangeStale,
            0.0,
        ),
        (|s| s.imu_age_s = 0.06, Reason::ImuStale, 0.0),
        (|s| s.diverged = true, Reason::Diverged, 0.0),
        (|s| s.height_m = f64::NAN, Reason::NotFinite, 0.0),
        (
            |s| s.lateral_error_m = f64::INFINITY,
            Reason::NotFinite,
            0.0,
        ),
        (|s| s.tilt_rad = 0.36, Reason::Tilt, 0.15),
        (|s| s.lateral_error_m = 0.32, Reason::LateralError, 0.15),
        (
            |s| s.relative_velocity_mps = -1.2,
            Reason::ClosingSpeed,
            0.15,
        ),
        (|s| s.saturated = true, Reason::Saturated, 0.3),
        (|s| s.deck_tilt_rad = 0.15, Reason::Deck, 0.0),
        (|s| s.deck_speed_mps = f64::NAN, Reason::Deck, 0.0),
        (|s| s.battery_share = 0.2, Reason::BatteryLow, 0.0),
        (|s| s.battery_share = f64::NAN, Reason::BatteryLow, 0.0),
    ];
    for (change, reason, time_s) in cases {
        let mut flight = reach(Phase::Descend);
        let (out, after) = leave(&mut flight, Phase::Descend, change);
        assert_eq!((out.phase, out.reason), (Phase::GoAround, Some(reason)));
        assert_eq!(out.maneuver, Maneuver::ClimbAway);
        // One step for the sample itself; counting starts with it.
        assert!((after - time_s - DT).abs() < 1.5 * DT, "{reason:?} {after}");
        let counted = u8::from(reason != Reason::Operator);
        assert_eq!(out.go_arounds, counted);
    }
}

#[test]
fn analytic_a_hover_that_sinks_climbs_away_and_that_is_counted() {
    type Change = fn(&mut MachineInput<f64>);
    let low: Change = |s| s.height_m = 0.3;
    let fast: Change = |s| s.relative_velocity_mps = -1.2;
    // Not in order, and so not waiting: ready is what it is not.
    let shaky: Change = |s| s.lateral_speed_mps = 1.0;
    for (phase, change, reason, time_s) in [
        (Phase::Approach, fast, Reason::ClosingSpeed, 0.15),
        (Phase::Hold, low, Reason::Height, 0.0),
        (Phase::Hold, fast, Reason::ClosingSpeed, 0.15),
        (Phase::Wait, low, Reason::Height, 0.0),
    ] {
        let mut flight = Flight::new();
        let aside = |s: &mut MachineInput<f64>| s.lateral_error_m = 0.5;
        match phase {
            Phase::Approach => assert_eq!(flight.step(aside).phase, phase),
            Phase::Hold => assert_eq!(flight.step(shaky).phase, phase),
            _ => flight = reach(phase),
        }
        let (out, after) = leave(&mut flight, phase, |s| {
            if phase == Phase::Approach {
                aside(s);
            }
            change(s);
        });
        assert_eq!((out.phase, out.reason), (Phase::GoAround, Some(reason)));
        assert_eq!(out.maneuver, Maneuver::ClimbAway);
        // One step for the sample itself.
        assert!((after - time_s - DT).abs() < 1.5 * DT, "{phase:?} {after}");
        assert_eq!(out.go_arounds, 1);
    }
    // An approach may begin anywhere, on the deck as well.
    let mut flight = Flight::new();
    flight.world.height_m = STANDING_M;
    assert_eq!(flight.step(|_| ()).phase, Phase::Approach);
    assert_eq!(flight.until(|out| out.phase == Phase::Wait).go_arounds, 0);
    // Climbing away again and again uses up the go-arounds out of a hover: the sixth ends it.
    let mut flight = Flight::new();
    let mut time_s = 0.0;
    let reason = loop {
        let out = flight.step(shaky);
        time_s += DT;
        if out.phase == Phase::Hold && time_s % 10.0 < DT {
            flight.world.height_m = 0.25;
        }
        if out.phase == Phase::GivenUp {
            break out.reason;
        }
        assert!(time_s < 200.0, "{out:?}");
    };
    assert_eq!(reason, Some(Reason::Height));
    // One each 10 s, and what the last climb took.
    assert!((60.0..65.0).contains(&time_s), "{time_s}");
}

#[test]
fn analytic_a_hover_that_sinks_climbs_away_whatever_else_is_wanted() {
    let sinking = |s: &mut MachineInput<f64>| {
        s.lateral_error_m = 0.5;
        s.relative_velocity_mps = -1.2;
    };
    // The battery is low as the sinking begins to count (0.15 s, counted from 0).
    let mut flight = Flight::new();
    for _ in 0..15 {
        assert_eq!(flight.step(sinking).phase, Phase::Approach);
    }
    let low = |s: &mut MachineInput<f64>| s.battery_share = 0.15;
    let out = flight.step(|s| {
        sinking(s);
        low(s);
    });
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::ClosingSpeed))
    );
    // Then it is given up, up there.
    let (out, _) = leave(&mut flight, Phase::GoAround, low);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GivenUp, Some(Reason::BatteryLow))
    );
    // The operator holds it back from landing all the time.
    for phase in [Phase::Approach, Phase::Hold, Phase::Wait] {
        let mut flight = match phase {
            Phase::Approach => Flight::new(),
            _ => reach(phase),
        };
        let stop = |s: &mut MachineInput<f64>| s.request = OperatorRequest::Abort;
        assert_eq!(flight.step(stop).phase, Phase::Hold);
        let (out, _) = leave(&mut flight, Phase::Hold, |s| {
            sinking(s);
            stop(s);
        });
        assert_eq!(
            (out.phase, out.reason),
            (Phase::GoAround, Some(Reason::ClosingSpeed))
        );
        let (out, _) = leave(&mut flight, Phase::GoAround, stop);
        assert_eq!(out.phase, Phase::Hold);
    }
}

#[test]
fn analytic_a_hover_that_swings_is_not_ready() {
    let swings: [fn(&mut MachineInput<f64>); 4] = [
        |s| s.relative_velocity_mps = 0.26,
        |s| s.relative_velocity_mps = -0.26,
        |s| s.lateral_speed_mps = 0.26,
        |s| s.lateral_speed_mps = f64::NAN,
    ];
    for swing in swings {
        let state_machine = StateMachine::<f64>::default();
        let mut state = state_machine.initial();
        for i in 0..500 {
            let mut seen = good();
            // Slow again for too short a time to settle.
            if i % 40 < 20 {
                swing(&mut seen);
            }
            let out = state_machine.step(&mut state, &seen, DT);
            assert!(
                matches!(out.phase, Phase::Approach | Phase::Hold),
                "{out:?}"
            );
        }
    }
}

#[test]
fn analytic_a_hover_says_what_it_waits_for() {
    type Change = fn(&mut MachineInput<f64>);
    let mut flight = reach(Phase::Hold);
    // Of two conditions the first of the list is named.
    let cases: [(Change, Option<Reason>); 5] = [
        (|s| s.wind_slope = 1.0, Some(Reason::Wind)),
        (
            |s| (s.wind_slope, s.tag_age_s) = (1.0, 0.31),
            Some(Reason::TagLost),
        ),
        (|s| s.deck_speed_mps = f64::INFINITY, Some(Reason::Deck)),
        (|s| s.lateral_error_m = 0.5, Some(Reason::LateralError)),
        (|_| (), None),
    ];
    for (change, waits_for) in cases {
        let out = flight.step(change);
        assert_eq!((out.phase, out.waits_for), (Phase::Hold, waits_for));
    }
    // A descent waits for nothing.
    let out = reach(Phase::Descend).step(|s| s.wind_slope = 1.0);
    assert_eq!(out.waits_for, None);
}

#[test]
fn analytic_a_short_excess_is_forgiven() {
    let mut flight = reach(Phase::Descend);
    for _ in 0..10 {
        for i in 0..15 {
            let out = flight.step(|s| {
                if i < 14 {
                    s.tilt_rad = 0.4;
                }
            });
            assert_ne!(out.phase, Phase::GoAround);
        }
    }
}

#[test]
fn analytic_below_the_commit_height_a_lost_tag_is_coasted() {
    let mut flight = reach(Phase::Commit);
    let mut last = None;
    for _ in 0..800 {
        let out = flight.step(|s| {
            s.tag_age_s = f64::INFINITY;
            s.battery_share = 0.1;
            s.deck_tilt_rad = 1.0;
        });
        assert_ne!(out.phase, Phase::GoAround);
        last = Some(out.phase);
    }
    assert_eq!(last, Some(Phase::Disarmed));
}

#[test]
fn analytic_every_abort_of_a_committed_landing() {
    type Change = fn(&mut MachineInput<f64>);
    let cases: [(Change, Reason); 9] = [
        (|s| s.gusty = true, Reason::Wind),
        (|s| s.request = OperatorRequest::Abort, Reason::Operator),
        (
            |s| (s.range_age_s, s.tag_age_s, s.height_sd_m) = (f64::NAN, 1.0, f64::NAN),
            Reason::RangeStale,
        ),
        (|s| s.imu_age_s = 1.0, Reason::ImuStale),
        (|s| s.diverged = true, Reason::Diverged),
        (|s| s.relative_velocity_mps = -0.9, Reason::ClosingSpeed),
        (|s| s.lateral_error_m = 0.3, Reason::LateralError),
        (|s| s.saturated = true, Reason::Saturated),
        // The deck falls away, and the tag is not there to come down again.
        (
            |s| {
                s.height_m = 0.5;
                s.tag_age_s = 2.0;
            },
            Reason::TagLost,
        ),
    ];
    for (change, reason) in cases {
        let mut flight = reach(Phase::Commit);
        let (out, _) = leave(&mut flight, Phase::Commit, change);
        assert_eq!((out.phase, out.reason), (Phase::GoAround, Some(reason)));
    }
    let mut flight = reach(Phase::Commit);
    let (out, _) = leave(&mut flight, Phase::Commit, |s| s.height_m = 0.41);
    assert_eq!(out.phase, Phase::Descend);
    // Floating, never touching: the time for the landing runs out.
    let mut flight = reach(Phase::Commit);
    let (out, after) = leave(&mut flight, Phase::Commit, |s| s.height_m = 0.15);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::Late))
    );
    assert!(
        after < flight.state_machine.landing_s && after > flight.state_machine.landing_s - 10.0
    );
}

#[test]
fn analytic_go_arounds_are_limited_and_reported() {
    let mut flight = Flight::new();
    let mut aborted = 0;
    let mut last = Phase::Approach;
    let mut out = flight.step(|_| ());
    for _ in 0..10_000 {
        // The tag is lost at every descent.
        let descending = last == Phase::Descend;
        out = flight.step(|s| {
            if descending {
                s.tag_age_s = 1.0;
            }
        });
        aborted += u32::from(out.phase == Phase::GoAround && last != Phase::GoAround);
        last = out.phase;
        if out.phase == Phase::GivenUp {
            break;
        }
    }
    // Two more tries, and the third abort gives up.
    assert_eq!(aborted, 3);
    assert_eq!((out.reason, out.go_arounds), (Some(Reason::TagLost), 3));
    let held = flight.step(|_| ());
    assert_eq!(
        held.maneuver,
        Maneuver::Hover {
            height_m: 0.8,
            frame: Frame::Deck
        }
    );
    // The operator starts anew, with all tries; a request that stays set does
    // not start a second time.
    let out = flight.step(|s| s.request = OperatorRequest::Restart);
    assert_eq!((out.phase, out.go_arounds), (Phase::Approach, 0));
    for _ in 0..3000 {
        flight.step(|s| s.request = OperatorRequest::Restart);
    }
    assert_eq!(flight.state.phase(), Phase::Disarmed);
    flight.step(|_| ());
    let out = flight.step(|s| s.request = OperatorRequest::Restart);
    assert_eq!(out.phase, Phase::Approach);
}

#[test]
fn regress_an_operators_abort_does_not_grant_another_try() {
    // Found by the promises' test: an abort asked for as the last climb ends.
    let mut flight = Flight::new();
    let mut last = Phase::Approach;
    for _ in 0..10_000 {
        let out = flight.step(|s| match last {
            Phase::Descend => s.tag_age_s = 1.0,
            Phase::GoAround => s.request = OperatorRequest::Abort,
            _ => (),
        });
        last = out.phase;
        assert!(out.go_arounds <= 3);
    }
    assert_eq!(last, Phase::GivenUp);
    // Short of that limit the operator's abort ends in a hold.
    let mut flight = reach(Phase::Descend);
    let (out, _) = leave(&mut flight, Phase::Descend, |s| {
        s.request = OperatorRequest::Abort;
    });
    assert_eq!(out.phase, Phase::GoAround);
    let (out, _) = leave(&mut flight, Phase::GoAround, |s| {
        s.request = OperatorRequest::Abort;
    });
    assert_eq!(
        (out.phase, out.reason),
        (Phase::Hold, Some(Reason::Operator))
    );
}

#[test]
fn analytic_patience_and_hover() {
    // The planner never says go.
    let mut flight = Flight::new();
    let mut out = flight.step(|s| s.go = false);
    for _ in 0..12_010 {
        out = flight.step(|s| s.go = false);
    }
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GivenUp, Some(Reason::Late))
    );
    // Being held by the operator costs no patience.
    let mut flight = Flight::new();
    for _ in 0..15_000 {
        let out = flight.step(|s| s.request = OperatorRequest::Abort);
        assert_eq!(
            (out.phase, out.reason),
            (Phase::Hold, Some(Reason::Operator))
        );
    }
    flight.until(|out| out.phase == Phase::Disarmed);
    // Waiting, something goes wrong for a moment: from Hold again.
    let mut flight = Flight::new();
    for _ in 0..100 {
        flight.step(|s| s.go = false);
    }
    assert_eq!(flight.state.phase(), Phase::Wait);
    let out = flight.step(|s| s.deck_speed_mps = 1.1);
    assert_eq!((out.phase, out.reason), (Phase::Hold, Some(Reason::Deck)));
    assert_eq!(flight.step(|_| ()).phase, Phase::Hold);
}

#[test]
fn analytic_batteries() {
    // Low: not begun, and given up from where it is.
    for phase in [Phase::Hold, Phase::Wait] {
        let mut flight = reach(phase);
        let out = flight.step(|s| s.battery_share = 0.15);
        assert_eq!(
            (out.phase, out.reason, out.hurry),
            (Phase::GivenUp, Some(Reason::BatteryLow), false)
        );
        // Critical: it lands, whatever the deck does and however often it takes.
        let mut last = Phase::GivenUp;
        let mut aborted = 0;
        for _ in 0..20_000 {
            let out = flight.step(|s| {
                s.battery_share = 0.08;
                s.deck_speed_mps = 2.0;
                if last == Phase::Descend && aborted < 5 {
                    s.tag_age_s = 1.0;
                }
            });
            assert!(out.hurry);
            aborted += i32::from(out.phase == Phase::GoAround && last != Phase::GoAround);
            last = out.phase;
        }
        assert_eq!((last, aborted), (Phase::Disarmed, 5));
    }
}

#[test]
fn analytic_the_operator_disarms_anywhere() {
    use Phase::*;
    for phase in [Hold, Wait, Descend, Commit, Touchdown, Disarmed] {
        let mut flight = reach(phase);
        let out = flight.step(|s| s.request = OperatorRequest::Disarm);
        assert_eq!((out.phase, out.maneuver), (Disarmed, Maneuver::Disarm));
        assert_eq!(out.reason, Some(Reason::Operator));
    }
}
