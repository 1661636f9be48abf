//! The phase of every row of an armed interval: contact, impact, tilted or airborne.

use super::armed_interval::ArmedInterval;
use super::phases::Phase;
use super::record::HALF_WINDOW_S;
use super::stand::clear_m;
use super::{Flight, FlightSettings, ForceFrom};
use crate::thrust::plateau::median;

/// From the start of the motors to the first row that counts (s): they spin up.
/// Five lags of small rotors. Half leaves 8 % of the transient, twice costs half a second of each flight.
const SPIN_UP_S: f64 = 0.3;
/// From the start of a record in flight to the first row that counts (s): the rotors' state is not known before.
/// Seven lags of the motors: 0.1 % of the unknown state is left.
const SETTLE_S: f64 = 0.4;
/// Rows this close to an impact are excluded (s).
/// Legs ring for as long. Twice loses the lowest heights of every landing.
const AROUND_IMPACT_S: f64 = 0.15;
/// A change of the specific force by so much within this time is an impact (gravities, s).
/// No throttle changes the force by so much in 0.02 s; a touch at 0.3 m/s does.
const IMPACT: f64 = 1.5;
const WITHIN_S: f64 = 0.02;
/// A change many times as great as the usual one from row to row is an impact too, and nothing below that is.
/// Rows of a bad airframe differ by its vibration; a blow is far above that.
const VIBRATIONS: f64 = 10.0;
/// Throttle below this share of that of flight, with a force within this of gravity (gravities) for so long (s): the ground
/// carries the vehicle.
/// Half the throttle gives a quarter to a third of the weight.
pub(super) const IDLING: f64 = 0.5;
const CARRIED: f64 = 0.05;
const IDLING_S: f64 = 0.3;
/// Tilt of the rotor axis beyond which heights are unreliable (rad).
/// At 20 degrees a range finder reads 6 % too much and the wake leaves the vehicle. Half loses every turn.
const STEEPEST_RAD: f64 = 0.35;
/// Share of the throttle of flight from which a vehicle has taken off, and below which it has landed, where no height tells.
/// The median of flight is reached only in flight; less marks spin-up as flight.
const LIFTING: f64 = 0.95;
const SINKING: f64 = 0.7;
/// A force well below this share of gravity with running motors is a drop (gravities).
/// Multirotors do not fall freely on purpose; motors that stop do.
const DROP: f64 = 0.3;

/// Marks the rows of an armed interval.
pub(super) fn mark(
    flight: &Flight,
    settings: &FlightSettings,
    run: &ArmedInterval,
    rows: &mut [Phase],
) {
    let time = &flight.time_s;
    let [a, b] = run.rows;
    let clear_m = clear_m(settings);
    let below = |i: usize, clear_m: f64| {
        let stood = run.stood_m;
        stood.is_some_and(|stood| !(flight.height_m[i] > stood + clear_m))
    };
    // Off the ground for good: the last row at or below the clearance in the climb, that is, before it was first
    // three clearances up.
    let up = (a..=b).find(|&i| run.stood_m.is_some() && !below(i, 3.0 * clear_m));
    let lifted = match up {
        Some(up) => (a..up)
            .rev()
            .find(|&i| below(i, clear_m))
            .map_or(a, |i| i + 1),
        None if run.stood_m.is_some() => b + 1,
        None => a + before_lift(flight, run),
    };
    let landed = match run.stood_m {
        Some(_) => b,
        None => b - after_landing(flight, run),
    };
    // What is smoothed knows of the contact for half a window after.
    let smoothed_s = if flight.force_from == ForceFrom::Poses {
        HALF_WINDOW_S
    } else {
        0.0
    };
    let lifted_s = time[lifted.min(b)];
    let from_s = time[a]
        + if run.on_s.is_some() {
            SPIN_UP_S
        } else {
            SETTLE_S
        };
    let leans = |i: usize| {
        flight
            .tilt_rad
            .get(i)
            .is_some_and(|t| t.abs() > STEEPEST_RAD)
    };
    for i in a..=b {
        let close = time[i] - lifted_s < smoothed_s && run.on_s.is_some();
        let outside = i < lifted || i > landed || close || time[i] < from_s;
        rows[i] = if outside || below(i, clear_m) {
            Phase::Contact
        } else if leans(i) {
            Phase::Tilted
        } else {
            Phase::Airborne
        };
    }
    for i in idling(flight, run) {
        rows[i] = Phase::Contact;
    }
    mark_impacts(flight, run, lifted, rows);
}

/// Marks rows in flight around impacts and drops.
fn mark_impacts(flight: &Flight, run: &ArmedInterval, lifted: usize, rows: &mut [Phase]) {
    let (time, force) = (&flight.time_s, &flight.force);
    if force.is_empty() {
        return;
    }
    let [a, b] = run.rows;
    // Vibration is no impact.
    let usual = median((a + 1..=b).map(|i| (force[i] - force[i - 1]).abs())).unwrap_or(0.0);
    let impact = IMPACT.max(VIBRATIONS * usual);
    let mut j = a;
    let hits: Vec<f64> = (a..=b)
        .filter(|&i| {
            while time[i] - time[j] > WITHIN_S {
                j += 1;
            }
            // Slow logs are compared row by row.
            let from = j.min(i.max(a + 1) - 1);
            (from..i).any(|k| (force[i] - force[k]).abs() > impact) || force[i] < DROP
        })
        .filter(|&i| i >= lifted)
        .map(|i| time[i])
        .collect();
    let mut next = 0;
    for i in a..=b {
        while next < hits.len() && hits[next] < time[i] - AROUND_IMPACT_S {
            next += 1;
        }
        let near = hits
            .get(next)
            .is_some_and(|t| (t - time[i]).abs() <= AROUND_IMPACT_S);
        if near && rows[i] == Phase::Airborne {
            rows[i] = Phase::Impact;
        }
    }
}

/// Throttle of flight in an armed interval without a known stand: the median of the throttles above half of the maximum.
pub(super) fn flying(flight: &Flight, [a, b]: [usize; 2]) -> f64 {
    let throttle = &flight.throttle[a..=b];
    let most = throttle.iter().copied().fold(0.0, f64::max);
    median(throttle.iter().copied().filter(|s| *s > 0.5 * most)).unwrap_or(most)
}

/// Rows with motors that turn too slowly to fly, while nothing falls.
fn idling(flight: &Flight, run: &ArmedInterval) -> Vec<usize> {
    let [a, b] = run.rows;
    let slow = IDLING * flying(flight, run.rows);
    let carried = |i: usize| {
        flight.throttle[i] < slow
            && flight
                .force
                .get(i)
                .is_none_or(|f| !((f - 1.0).abs() > CARRIED))
    };
    let mut out = Vec::new();
    let mut i = a;
    while i <= b {
        let from = i;
        while i <= b && carried(i) {
            i += 1;
        }
        if i > from && flight.time_s[i - 1] - flight.time_s[from] >= IDLING_S {
            out.extend(from..i);
        }
        i += 1;
    }
    out
}

/// Rows from the start of the motors to the lift-off, without a height: up to the first throttle of flight.
fn before_lift(flight: &Flight, run: &ArmedInterval) -> usize {
    if run.on_s.is_none() {
        return 0;
    }
    let [a, b] = run.rows;
    let enough = LIFTING * flying(flight, run.rows);
    (a..=b)
        .position(|i| flight.throttle[i] >= enough)
        .unwrap_or(0)
}

/// Rows from the last throttle of flight to the stop of the motors, without a height.
fn after_landing(flight: &Flight, run: &ArmedInterval) -> usize {
    if run.off_s.is_none() {
        return 0;
    }
    let [a, b] = run.rows;
    let enough = SINKING * flying(flight, run.rows);
    (a..=b)
        .rev()
        .position(|i| flight.throttle[i] >= enough)
        .unwrap_or(0)
}
