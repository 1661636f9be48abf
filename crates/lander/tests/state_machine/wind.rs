//! Rows of the table for gusts.

use touchdown_lander::state_machine::{MachineInput, Phase, Reason};

use crate::table::{leave, reach};
use crate::world::Flight;

#[test]
fn analytic_a_gust_before_the_touch_is_waited_for() {
    type Change = fn(&mut MachineInput<f64>);
    let gust: Change = |s| s.gusty = true;
    // It does not end a landing that has begun to touch, that cannot wait, or that finds no other moment.
    let low = |height_m: f64| {
        let mut flight = reach(Phase::Commit);
        flight.world.height_m = height_m;
        flight.step(gust).phase
    };
    assert_eq!((low(0.14), low(0.125)), (Phase::GoAround, Phase::Commit));
    let goes_on: [Change; 3] = [
        |s| (s.gusty, s.battery_share) = (true, 0.15),
        |s| (s.gusty, s.battery_share) = (true, 0.05),
        |s| (s.gusty, s.hold_extra_m) = (true, 0.1),
    ];
    for change in goes_on {
        let mut flight = reach(Phase::Commit);
        let (out, _) = leave(&mut flight, Phase::Commit, change);
        assert_eq!(out.phase, Phase::Touchdown);
    }
    // Ten tries more than without a gust; the others do not count against them.
    let mut flight = Flight::new();
    let mut out = flight.step(|_| ());
    for _ in 0..60_000 {
        let (committed, aborted) = (out.phase == Phase::Commit, out.go_arounds);
        out = flight.step(|s| match committed {
            true if aborted < 2 => s.saturated = true,
            true => gust(s),
            false => (),
        });
        if out.phase == Phase::GivenUp {
            break;
        }
    }
    assert_eq!(
        (out.phase, out.reason, out.go_arounds),
        (Phase::GivenUp, Some(Reason::Wind), 13)
    );
}
