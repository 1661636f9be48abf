//! What a rough sea changes, against hand-computed figures.

use touchdown_flight::Vector;
use touchdown_flight::reference::ReferencePoint;

use super::Sea;
use crate::computer::Computer;
use crate::computer::tests::{DT, State, computer};
use crate::space_controller::{Motion, Target};

/// Sums of some hundred roundings.
const ROUNDING: f64 = 1e-12;

/// A computer and its state in a sea whose deck has moved at a speed.
fn in_a_sea(rough_mps: f64) -> (Computer<f64>, State) {
    let computer = computer();
    let mut state: State = computer.initial(0.5);
    state.sea = Sea {
        rough_mps,
        ..Sea::default()
    };
    (computer, state)
}

#[test]
fn analytic_without_a_tag_a_descent_at_the_deck_gets_ahead_of_its_plan() {
    // 0.5 m/s beyond a calm sea: 0.075 m/s faster. No tag was ever seen.
    let (computer, mut state) = in_a_sea(1.2);
    let planned = Target {
        vertical: ReferencePoint {
            height_m: 0.2,
            velocity_mps: -0.03,
            ..ReferencePoint::default()
        },
        ..Target::default()
    };
    let mut flown = |committed, steps: u32| {
        let mut target = planned;
        for _ in 0..steps {
            target = planned;
            computer.press_on(&mut state, committed, &mut target, DT);
        }
        (
            target.vertical.height_m - 0.2,
            target.vertical.velocity_mps + 0.03,
        )
    };
    let (ahead_m, faster_mps) = flown(true, 100);
    assert!((ahead_m + 0.075).abs() < ROUNDING, "{ahead_m}");
    assert!((faster_mps + 0.075).abs() < ROUNDING, "{faster_mps}");
    // It ends where the plan itself ends, `press_m` (0.15 m) on, to a step.
    let (ahead_m, faster_mps) = flown(true, 1000);
    assert!((ahead_m + 0.15).abs() < 0.075 * DT + ROUNDING, "{ahead_m}");
    assert!(faster_mps.abs() < ROUNDING);
    // Any other manoeuvre begins anew.
    assert_eq!(flown(false, 1), (0.0, 0.0));
    let (ahead_m, _) = flown(true, 1);
    assert!((ahead_m + 0.075 * DT).abs() < ROUNDING, "{ahead_m}");
    // A calm sea changes nothing.
    let (computer, mut state) = in_a_sea(0.5);
    let mut target = planned;
    computer.press_on(&mut state, true, &mut target, DT);
    assert_eq!(target, planned);
}

#[test]
fn analytic_a_descent_onto_a_deck_under_way_ends_faster() {
    // 0.01 of the deck's speed, at most 5/12 of the greatest speed of a touchdown, 0.12 m/s, and what wind leaves of that.
    for (course_mps, windy_mps, sink_mps) in [
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.02),
        (10.0, 0.0, 0.05),
        (10.0, 0.09, 0.03),
        (15.0, 0.2, 0.0),
    ] {
        let sea = Sea::<f64> {
            course_mps,
            ..Sea::default()
        };
        let found_mps = sea.course_sink_mps(windy_mps, 0.12);
        assert!((found_mps - sink_mps).abs() < ROUNDING, "{course_mps}");
    }
}

#[test]
fn analytic_who_climbs_away_from_a_deck_that_rises_gains_on_it() {
    let (computer, state) = in_a_sea(1.0);
    let away = |deck_mps: f64, height_m: f64| {
        let motion = Motion {
            position_m: Vector::UP * height_m,
            vehicle_velocity_mps: Vector::UP * 0.2,
            relative_velocity_mps: Vector::UP * (0.2 - deck_mps),
            ..Motion::default()
        };
        let guidance = computer.guidance_away(&state, &motion);
        (guidance.climb_mps, guidance.away_mps2)
    };
    let close = |(climb, away): (f64, f64), (climb_is, away_is): (f64, f64)| {
        (climb - climb_is).abs() < ROUNDING && (away - away_is).abs() < ROUNDING
    };
    // 0.5 m/s and 3 m/s², with 0.3 m/s beyond a calm sea, or the deck's own speed upwards if that is greater, at most 2 m/s.
    assert!(close(away(-1.0, 0.3), (0.8, 3.3)));
    assert!(close(away(1.6, 0.3), (2.1, 4.6)));
    assert!(close(away(2.8, 0.3), (2.5, 5.0)));
    // Up there the deck does not come.
    assert!(close(away(2.8, 9.0), (0.5, 3.0)));
}

#[test]
fn analytic_a_high_start_waits_until_the_deck_was_watched() {
    let (computer, mut state) = in_a_sea(0.0);
    // The hover is 0.8 m high. 0.2 m more is what gusts move; 0.9 m is a start, and 3 m more than may be waited at.
    let mut extra_m = |height_m| computer.hold_extra_m(&mut state, 0.0, height_m, DT);
    assert_eq!(extra_m(1.0), 0.0);
    assert!((extra_m(1.7) - 0.9).abs() < ROUNDING);
    // Who sinks below is brought back.
    assert!((extra_m(1.2) - 0.9).abs() < ROUNDING);
    assert!((extra_m(3.8) - 1.5).abs() < ROUNDING);
    state.flown_s = computer.watch_s;
    assert_eq!(
        computer.hold_extra_m(&mut state, 0.0, 3.8, DT),
        0.0,
        "watched"
    );
}

#[test]
fn analytic_a_descent_counts_rising_lift_late_over_a_deck_that_moves() {
    let over = |seen_mps: f64, rough_mps: f64| Sea {
        seen_mps,
        rough_mps,
        ..Sea::default()
    };
    // 0.8 s²/m, at most 0.4 s; all of it where the feet may touch.
    assert_eq!(over(0.0, 0.0).lift_rise_s(false), 0.0);
    assert!((over(0.25, 0.3).lift_rise_s(false) - 0.2).abs() < ROUNDING);
    assert_eq!(over(0.6, 0.65).lift_rise_s(false), 0.4);
    assert_eq!(over(0.0, 0.0).lift_rise_s(true), 0.4);
    // In a rough sea a descent ends whether soft or not.
    assert_eq!(over(0.6, 0.8).lift_rise_s(true), 0.0);
}

#[test]
fn analytic_a_forecast_counts_as_far_as_the_measured_velocity_bears_it_out() {
    // A forecast of 0.2 m/s, and a measured velocity that differs.
    let sea = |differs_mps: f64, seen_mps: f64, forgetting_per_s: f64| {
        let mut sea = Sea {
            seen_mps,
            ..Sea::default()
        };
        sea.compare(0.2, 0.2 + differs_mps, forgetting_per_s);
        sea
    };
    let left = |differs_mps: f64, seen_mps: f64, forgetting_per_s: f64| {
        sea(differs_mps, seen_mps, forgetting_per_s).plausible_mps2(0.8)
    };
    assert!((left(0.0, 0.3, 0.5) - 0.8).abs() < ROUNDING);
    // σ = 0.06 m/s over a calm deck, √(0.06² + 0.08²) = 0.1 m/s where it moved by 0.08/0.15 m/s: half is left.
    for (sigma, seen_mps) in [(0.06, 0.0), (0.1, 0.08 / 0.15)] {
        for sign in [1.0, -1.0] {
            assert!((left(sign * sigma, seen_mps, 0.1) - 0.4).abs() < ROUNDING);
            // Beyond 0.1/s all of the difference counts, and at half of it half of its square.
            assert!((left(sign * sigma, seen_mps, 0.5) - 0.4).abs() < ROUNDING);
            assert!((left(sign * sigma, seen_mps, 0.05) - 0.8 / 1.5).abs() < ROUNDING);
        }
    }
    // The forecast of a tone counts whatever is measured, and one beside an unknown velocity too.
    assert!((left(0.5, 0.3, 0.0) - 0.8).abs() < ROUNDING);
    assert!((left(f64::NAN, 0.3, 0.5) - 0.8).abs() < ROUNDING);
    // A rough sea goes by its greatest speed alone.
    let rough = Sea {
        rough_mps: 1.0,
        ..sea(0.5, 1.0, 0.5)
    };
    assert_eq!(rough.plausible_mps2(1.5), 1.5);
    assert_eq!(rough.plausible_mps2(3.0), 2.0);
}
