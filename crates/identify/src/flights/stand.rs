//! Height of the feet on the ground before and after an armed interval.

use super::marking::{IDLING, flying};
use super::{Flight, FlightSettings};
use crate::thrust::plateau::median;

/// Length of the stand before a take-off that its height is taken from (s).
/// Averages the noise of 25 readings at 50 Hz; a vehicle is carried away within seconds.
const STAND_S: f64 = 0.5;
/// Shortest stand after a landing (s).
/// Logs end soon after disarming: twice loses half of the landings.
const STANDS_S: f64 = 0.2;
/// Height above where the feet stood from which the vehicle flies: the greater of both.
/// Noise of a good height sensor.
const CLEAR_M: f64 = 0.005;
/// Legs lift and heights drift by as much. Twice loses the lowest heights of every take-off.
const CLEAR_RADII: f64 = 0.2;

/// Height at the end of a stand, and how far it went over all of it but the landing's first second.
pub(super) fn stood(flight: &Flight, rows: std::ops::Range<usize>) -> (Option<f64>, f64) {
    let (time, height) = (&flight.time_s, &flight.height_m);
    if height.is_empty() || rows.is_empty() {
        return (None, 0.0);
    }
    let (first, last) = (time[rows.start], time[rows.end - 1]);
    let late = rows
        .clone()
        .filter(|&i| time[i] >= last - STAND_S)
        .map(|i| height[i]);
    let landing_s = if rows.start > 0 { 1.0 } else { 0.0 };
    let settled = rows
        .filter(|&i| time[i] >= first + landing_s)
        .map(|i| height[i]);
    let range = crate::fitted::range(settled).unwrap_or([0.0, 0.0]);
    (median(late), range[1] - range[0])
}

/// Height where the feet stand after a run, up to the row `end`: with motors off, or else while they turn too slowly to
/// fly. What falls does not stand.
pub(super) fn stands_after(
    flight: &Flight,
    run: [usize; 2],
    end: usize,
    settings: &FlightSettings,
) -> Option<f64> {
    let (time, height) = (&flight.time_s, &flight.height_m);
    if height.is_empty() {
        return None;
    }
    let [a, b] = run;
    let slow = IDLING * flying(flight, run);
    let idles = (a..=b)
        .rev()
        .take_while(|&i| flight.throttle[i] < slow)
        .count();
    let still = |rows: std::ops::Range<usize>| {
        let (first, last) = (rows.clone().next()?, rows.clone().next_back()?);
        let known = || rows.clone().map(|i| height[i]).filter(|h| h.is_finite());
        let [low, high] = crate::fitted::range(known())?;
        (time[last] - time[first] >= STANDS_S && high - low <= 2.0 * clear_m(settings))
            .then(|| median(known()))
            .flatten()
    };
    // A throttle that ends in a gap means stopped motors only if they were about to stop.
    let stops = idles > 0 || flight.throttle.get(b + 1).is_some_and(|s| s.is_finite());
    // Not the first moments, in which the legs take up the landing.
    let from = (b + 1..end).find(|&i| stops && time[i] - time[b] > 0.5 * STANDS_S);
    let stopped = from.and_then(|from| {
        let to = (from..end).find(|&i| time[i] - time[from] > 2.0 * STAND_S);
        still(from..to.unwrap_or(end))
    });
    stopped.or_else(|| still(b + 1 - idles..b + 1))
}

/// Height above where the feet stood from which the vehicle flies.
pub(super) fn clear_m(settings: &FlightSettings) -> f64 {
    settings
        .rotor_radius_m
        .map_or(CLEAR_M, |r| CLEAR_M.max(CLEAR_RADII * r))
}
