//! What the machine does where it does not see the deck, or sees it with one sensor only.

use touchdown_lander::state_machine::{Frame, MachineInput, Maneuver, Phase, Reason};

use crate::table::{leave, reach};
use crate::world::{DT, Flight};

#[test]
fn analytic_who_does_not_see_the_deck_climbs_waits_and_gives_up() {
    let unseen = |s: &mut MachineInput<f64>| s.tag_age_s = f64::INFINITY;
    let mut flight = Flight::new();
    let machine = flight.state_machine;
    let (out, after) = leave(&mut flight, Phase::Approach, unseen);
    assert_eq!(
        (out.phase, out.reason, out.go_arounds),
        (Phase::GoAround, Some(Reason::TagLost), 1)
    );
    assert!((after - machine.lost_s).abs() < 2.0 * DT, "{after}");
    let (out, climbed) = leave(&mut flight, Phase::GoAround, unseen);
    assert_eq!(out.phase, Phase::Approach);
    let height_m = flight.world.height_m;
    assert!((height_m - machine.safe_height_m).abs() < 0.2, "{height_m}");
    // There it waits, without another climb.
    let (out, waited) = leave(&mut flight, Phase::Approach, unseen);
    assert_eq!(
        (out.phase, out.reason, out.go_arounds),
        (Phase::GivenUp, Some(Reason::TagLost), 1)
    );
    let in_all = after + climbed + waited;
    assert!((in_all - machine.search_s).abs() < 3.0 * DT, "{in_all}");
    assert_eq!(
        out.maneuver,
        Maneuver::Hover {
            height_m: 0.8,
            frame: Frame::World
        }
    );
}

#[test]
fn analytic_over_a_rough_sea_a_hover_climbs_before_the_deck_can_strike() {
    // From 1 m above the height of a touchdown, over a deck of 2 m/s: a quarter of 0.5 s.
    let unseen = |s: &mut MachineInput<f64>| {
        s.tag_age_s = 1.0;
        s.hold_extra_m = 1.3;
        s.height_m = 1.12;
    };
    let mut flight = reach(Phase::Wait);
    let (out, after) = leave(&mut flight, Phase::Hold, unseen);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::TagLost))
    );
    assert!((after - 0.125).abs() < 3.0 * DT, "{after}");
}

#[test]
fn analytic_a_hover_that_loses_the_deck_climbs_once_for_each_loss() {
    let mut flight = reach(Phase::Wait);
    let unseen = |s: &mut MachineInput<f64>| s.tag_age_s = 1.0;
    for lost in 1..=2 {
        let mut out = flight.step(unseen);
        for _ in 0..1000 {
            out = flight.step(unseen);
        }
        assert_eq!((out.phase, out.go_arounds), (Phase::Approach, lost));
        flight.until(|out| out.phase == Phase::Hold);
    }
}

#[test]
fn analytic_without_a_height_it_climbs_for_the_time_of_a_climb() {
    let mut flight = Flight::new();
    let machine = flight.state_machine;
    let blind = |s: &mut MachineInput<f64>| {
        (s.tag_age_s, s.range_age_s, s.height_sd_m) = (1.0, 1.0, 10.0);
    };
    let (out, _) = leave(&mut flight, Phase::Approach, blind);
    assert_eq!(
        (out.phase, out.reason),
        (Phase::GoAround, Some(Reason::RangeStale))
    );
    let (out, after) = leave(&mut flight, Phase::GoAround, blind);
    assert_eq!(out.phase, Phase::Approach);
    assert!((after - machine.climb_s).abs() < 2.0 * DT, "{after}");
}

#[test]
fn analytic_who_has_given_up_at_the_deck_and_loses_sight_of_it_climbs() {
    let mut flight = reach(Phase::Wait);
    let low = flight.step(|s| s.battery_share = 0.15);
    assert_eq!(low.phase, Phase::GivenUp);
    let mut highest_m = 0.0_f64;
    let mut out = low;
    for _ in 0..2000 {
        out = flight.step(|s| {
            s.battery_share = 0.15;
            s.tag_age_s = 1.0;
        });
        assert_eq!(out.phase, Phase::GivenUp);
        highest_m = highest_m.max(flight.world.height_m);
    }
    let safe_m = flight.state_machine.safe_height_m;
    assert!((0.0..0.2).contains(&(highest_m - safe_m)), "{highest_m}");
    assert!(matches!(
        out.maneuver,
        Maneuver::Hover {
            frame: Frame::World,
            ..
        }
    ));
}

#[test]
fn analytic_the_tag_alone_lands() {
    let mut flight = Flight::new();
    let mut last = Phase::Approach;
    for _ in 0..3000 {
        let commit = last == Phase::Commit || last == Phase::Touchdown;
        let out = flight.step(|s| {
            s.range_age_s = f64::INFINITY;
            // At the deck the tag is out of view; the IMU carries the height on.
            if commit {
                (s.tag_age_s, s.height_sd_m) = (1.0, 0.02);
            }
        });
        assert_ne!(out.phase, Phase::GoAround);
        last = out.phase;
    }
    assert_eq!(last, Phase::Disarmed);
}
