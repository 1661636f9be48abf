//! Whether commands act before they are logged.
//!
//! A command that is logged in the row of the measurement that it answers acts from that row on: a model in which it acts earlier
//! takes the answer for a cause, and the cost has a kink at a dead time of zero. So dead times below zero are another model.
//! An autopilot that reports its commands with stamps of its own loop, or over telemetry, logs them late, and has no such kink.

use super::{Problem, Settings, Tracked};
use crate::flights::fit::Fit;
use crate::flights::model::{ModelTerms, Segment};

/// Step across a dead time of zero by which the two models are compared (s): a hundredth of a row of 100 Hz.
const ACROSS_S: f64 = 1e-4;

/// By how much minus twice the log-likelihood has to fall for a dead time that is below zero by less than a row: by chance it falls
/// as much in 1 of 100 logs whose commands act in their row (χ² of one degree of freedom, one-sided).
const EVIDENCE: f64 = 5.4;

/// The start of a fit along trajectories, from one along measured heights: with dead times below zero where the flights are likelier
/// there.
///
/// Along measured heights the throttle goes on lines between its rows, half a row earlier than it is held.
pub(in crate::flights) fn start(
    pieces: &[Segment],
    along_heights: &Fit,
    settings: Settings,
) -> Fit {
    let half_row_s = 0.5 * Segment::median_step_s(pieces);
    let after = with_dead_time(along_heights, |d| (d - half_row_s).max(0.0), false);
    let before = with_dead_time(along_heights, |d| d - half_row_s, true);
    let early = before.value("dead_time").is_some_and(|d| d < -ACROSS_S);
    if early && cost(pieces, &before, settings) < cost(pieces, &after, settings) {
        before
    } else {
        after
    }
}

/// The same, or the model on the other side of a dead time of zero where the fit ended near it: below zero only where the cost falls
/// by [`EVIDENCE`].
pub(super) fn across_zero(pieces: &[Segment], found: Tracked, settings: Settings) -> Tracked {
    let Some(dead_time_s) = found.fit.value("dead_time") else {
        return found;
    };
    let late = found.fit.shape.logged_late;
    let other = if late && dead_time_s > -Segment::median_step_s(pieces) {
        with_dead_time(&found.fit, |d| d.max(0.0), false)
    } else if !late && dead_time_s == 0.0 {
        with_dead_time(&found.fit, |_| -ACROSS_S, true)
    } else {
        return found;
    };
    let problem = Problem::of(pieces, &other, settings);
    if !late && problem.cost(&other.theta, found.noise) >= found.cost {
        return found;
    }
    let Some(other) = problem.track(&other, found.noise, false) else {
        return found;
    };
    let (before, after) = if late { (found, other) } else { (other, found) };
    if before.cost + EVIDENCE < after.cost {
        before
    } else {
        after
    }
}

fn cost(pieces: &[Segment], start: &Fit, settings: Settings) -> f64 {
    Problem::of(pieces, start, settings).cost(&start.theta, super::Noise::first(start))
}

/// The fit with another dead time, above or below zero.
fn with_dead_time(fit: &Fit, of: impl Fn(f64) -> f64, logged_late: bool) -> Fit {
    let mut theta = fit.theta.clone();
    if let Some(i) = fit.index("dead_time") {
        theta[i] = of(theta[i]);
    }
    Fit {
        theta,
        shape: ModelTerms {
            logged_late,
            ..fit.shape
        },
        ..fit.clone()
    }
}
