//! Whether the accelerometer has a latency against height and command.
//!
//! Filters of autopilots delay it by some milliseconds, and so do stamps at the end of an average. The force that the motion shows then
//! comes before the force that is felt, which passes for climb damping. A latency is another number of the model: each reading
//! corrects the motion at the time at which it was felt.

use super::{Problem, Settings, Tracked, clock, noises_at_rest};
use crate::flights::fit::Fit;
use crate::flights::model::{ModelTerms, Segment};

/// Latency from which the search starts, if the flights are likelier there than without (s): a tenth of the least that matters.
const FIRST_S: f64 = 1e-4;

/// Latency from which the search for a long one starts (s): the middle of what default filters and logs without stamps have. From 0.1 ms,
/// 0.03 and 0.06 s the search ended at the same numbers.
const FIRST_LONG_S: f64 = 0.05;

/// Longest latency of an accelerometer that is taken for harmless (s). A low-pass filter beyond it takes part of the motion away, and
/// no latency describes that.
const HARMLESS_S: f64 = 0.03;

impl Fit {
    /// The latency of the accelerometer (s), where it is longer than what is harmless behind a filter.
    pub(in crate::flights) fn long_latency_s(&self) -> Option<f64> {
        let latency_s = self.value("accelerometer_latency");
        latency_s.filter(|latency_s| *latency_s > HARMLESS_S)
    }
}

/// The fit with a latency of the accelerometer; `None` where the flights are not likelier with a short one.
///
/// At the minimum without it the slope of the cost by a latency is that with all other numbers at their best. So its sign tells
/// whether a fit with one is worth its time.
///
/// None either above a ground that moves: the latency of its range is unknown, and one of the accelerometer is not identifiable
/// beside that and the dead time.
pub(in crate::flights) fn with_latency(
    pieces: &[Segment],
    found: &Tracked,
    settings: Settings,
) -> Option<Tracked> {
    if found.fit.shape.accelerometer_latency || found.noise.ground.is_some() {
        return None;
    }
    let shape = ModelTerms {
        accelerometer_latency: true,
        ..found.fit.shape
    };
    let at = |latency_s: f64| {
        // The last of the numbers.
        let mut theta = found.fit.theta.clone();
        theta.push(latency_s);
        theta
    };
    let start = Fit {
        shape,
        theta: at(FIRST_S),
        ..found.fit.clone()
    };
    let problem = Problem::of(pieces, &start, settings);
    let cost = |latency_s: f64| problem.cost(&at(latency_s), found.noise);
    if cost(FIRST_S) >= cost(0.0) {
        return None;
    }
    let found = problem.track(&start, found.noise, false)?;
    Some(clock::across_zero(pieces, found, settings))
}

/// The fit with a latency of the accelerometer over a ground at rest, whatever the flights are without one; `None` where its
/// innovations are not white.
///
/// A latency of some rows leaves no white innovations without it, so there is no minimum to start from.
pub(in crate::flights) fn with_long_latency(
    pieces: &[Segment],
    start: &Fit,
    settings: Settings,
) -> Option<Tracked> {
    let mut theta = start.theta.clone();
    theta.push(FIRST_LONG_S);
    let start = Fit {
        shape: ModelTerms {
            accelerometer_latency: true,
            ..start.shape
        },
        theta,
        ..start.clone()
    };
    let problem = Problem::of(pieces, &start, settings);
    noises_at_rest(pieces, &start)
        .into_iter()
        .flatten()
        .filter_map(|noise| problem.track(&start, noise, true))
        .map(|found| clock::across_zero(pieces, found, settings))
        .find(Tracked::is_trusted)
}
