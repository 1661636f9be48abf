//! Where in a measured motion of the deck a landing starts.

use crate::check;
use crate::deck::spline::MotionSpline;
use crate::error::SimError;

/// Checks that a motion is longer than a landing may take.
pub(super) fn check_length(motion: &MotionSpline, timeout_s: f64) -> Result<(), SimError> {
    let (from_s, to_s) = motion.range_s();
    let needed_s = timeout_s + 1.0;
    check::that(
        to_s - from_s > needed_s,
        "deck",
        &format!("a series of more than {needed_s:.1} s (`timeout_s` and one second)"),
        to_s - from_s,
    )
}

/// The time of a motion at which a landing starts, by a share of 0 to 1 that is drawn.
pub(super) fn measured_start_s(motion: &MotionSpline, timeout_s: f64, share: f64) -> f64 {
    let (from_s, to_s) = motion.range_s();
    from_s + share * (to_s - from_s - timeout_s - 1.0)
}
