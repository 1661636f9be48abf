//! The segments of flights that a model is fitted to, and what was left out and why.

use serde::Serialize;

use super::armed_interval::ArmedInterval;
use super::drift::Drift;
use super::model::Segment;
use super::phases::{Phase, Phases};
use super::{Flight, FlightSettings, ForceFrom};
use crate::thrust::plateau::median;

/// Fewest rows in flight of a run that is used.
/// Some seven rows for each number of the plain model. Half admits segments whose own scale is noise; twice loses short hops.
pub(super) const FEWEST_ROWS: usize = 50;
/// Drift of the height on the ground before a take-off beyond which heights near the ground are not known (in R).
/// The effect about halves over one radius. On logs without drift nothing moves (measured).
const MOST_DRIFT: f64 = 1.0;
/// Climb rate up to which a vehicle hovers (m/s).
/// Well above the noise of a climb rate, well below a slow descent. Half or twice moves a lag by 0.5 % (measured).
const HOVER_MPS: f64 = 0.15;
/// A force this close to gravity is hover (gravities).
/// Three times the noise of the accelerometer in hover. Half or twice moves a lag by 0.2 % (measured).
pub(super) const HOVER_FORCE: f64 = 0.1;

/// Rows that were not used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excluded {
    /// The log.
    pub log: String,
    /// From (s).
    pub from_s: f64,
    /// To (s).
    pub to_s: f64,
    /// Why.
    pub why: String,
}

/// All runs of all flights.
#[derive(Clone, Debug)]
pub struct Segments {
    /// The runs.
    pub pieces: Vec<Segment>,
    /// Throttle in hover.
    pub hover_throttle: f64,
    /// The unused rows.
    pub left_out: Vec<Excluded>,
}

impl Segments {
    /// Takes time for the drift where not all segments have a voltage, for batteries discharge whether that is logged or
    /// not; returns whether it did.
    pub(super) fn drifts_with_time(&mut self, flights: &[Flight]) -> bool {
        if self.pieces.iter().all(|p| p.drift != Drift::Unknown) {
            return false;
        }
        for piece in &mut self.pieces {
            piece.drift = Drift::of_time(&piece.time_s, flights[piece.flight].time_s[0]);
        }
        true
    }
}

/// Units that segments are in: what is the same for all flights.
struct Units {
    /// Unit of height (m): the rotor radius, where it is known.
    height_m: f64,
    /// Throttle in hover.
    hover_throttle: f64,
    /// Mean battery voltage (V).
    battery_v: f64,
}

impl Units {
    fn of(flights: &[Flight], phases: &[Phases], settings: &FlightSettings) -> Self {
        let airborne = |f: usize, i: usize| phases[f].rows[i] == Phase::Airborne;
        let hovering = |f: usize, i: usize| {
            let (climb, force) = (flights[f].climb_mps.get(i), flights[f].force.get(i));
            airborne(f, i)
                && climb.is_none_or(|v| v.abs() < HOVER_MPS)
                && force.is_none_or(|a| (a - 1.0).abs() < HOVER_FORCE)
        };
        let over = |keep: &dyn Fn(usize, usize) -> bool| {
            median((0..flights.len()).flat_map(|f| {
                (0..flights[f].time_s.len())
                    .filter(move |&i| keep(f, i))
                    .map(move |i| flights[f].throttle[i])
            }))
        };
        let volts = median(flights.iter().enumerate().flat_map(|(f, flight)| {
            flight
                .battery_v
                .iter()
                .enumerate()
                .filter(move |(i, _)| airborne(f, *i))
                .map(|(_, v)| *v)
        }));
        Self {
            height_m: settings.rotor_radius_m.unwrap_or(1.0),
            hover_throttle: over(&hovering).or_else(|| over(&airborne)).unwrap_or(0.5),
            battery_v: volts.unwrap_or(0.0),
        }
    }
}

/// Cuts flights into segments. Heights are in rotor radii where that is known, else in metres.
#[must_use]
pub fn cut(flights: &[Flight], phases: &[Phases], settings: &FlightSettings) -> Segments {
    let units = Units::of(flights, phases, settings);
    let mut out = Segments {
        pieces: Vec::new(),
        hover_throttle: units.hover_throttle,
        left_out: Vec::new(),
    };
    for (index, (flight, phases)) in flights.iter().zip(phases).enumerate() {
        out.left_out.extend(left_out(flight, phases));
        for (number, run) in phases.runs.iter().enumerate() {
            let excluded = |why: String| Excluded {
                log: flight.name.clone(),
                from_s: flight.time_s[run.rows[0]],
                to_s: flight.time_s[run.rows[1]],
                why,
            };
            let least_m = least_height_m(run, &units, settings);
            if let Some(least_m) = least_m {
                out.left_out.push(excluded(format!(
                    "heights below {least_m:.2} m: on the ground before this take-off the height wandered by \
                     {:.2} m, more than {MOST_DRIFT} rotor radius",
                    run.drift_m
                )));
            }
            let piece = Segment {
                flight: index,
                run: number,
                ..segment(flight, phases, run, least_m, &units, settings)
            };
            if piece.rows.len() < FEWEST_ROWS {
                out.left_out.push(excluded(format!(
                    "run {}: {} rows in flight with a specific force, {FEWEST_ROWS} are needed",
                    number + 1,
                    piece.rows.len()
                )));
            } else {
                out.pieces.push(piece);
            }
        }
    }
    out
}

/// The height from which those of an armed interval count (m), where not all do: heights that wandered on the ground are
/// wrong by an unknown length in flight too.
fn least_height_m(run: &ArmedInterval, units: &Units, settings: &FlightSettings) -> Option<f64> {
    let drifted = settings.rotor_radius_m.is_some() && run.drift_m > MOST_DRIFT * units.height_m;
    drifted.then_some(run.drift_m + settings.reference_radii * units.height_m)
}

/// The segment of an armed interval, ready to be simulated.
fn segment(
    flight: &Flight,
    phases: &Phases,
    run: &ArmedInterval,
    least_m: Option<f64>,
    units: &Units,
    settings: &FlightSettings,
) -> Segment {
    let [a, b] = run.rows;
    let least_m = least_m.unwrap_or(f64::NEG_INFINITY);
    // One row of standstill before, so that the first command is a step.
    let from = a.saturating_sub(usize::from(run.on_s.is_some()));
    let rows = (a..=b)
        .filter(|&i| {
            phases.rows[i] == Phase::Airborne
                && flight.force.get(i).is_some_and(|f| f.is_finite())
                && flight.climb_mps.get(i).is_none_or(|v| v.is_finite())
                && flight.height_m.get(i).is_none_or(|z| *z >= least_m)
        })
        .map(|i| i - from);
    let part = |c: &[f64], scale: f64, shift: f64| -> Vec<f64> {
        if c.is_empty() {
            return Vec::new();
        }
        c[from..=b].iter().map(|v| (v - shift) / scale).collect()
    };
    let of_hover = |c: &[f64]| held(part(c, units.hover_throttle, 0.0));
    let (logged, smoothed) = (of_hover(&flight.throttle), of_hover(&flight.command));
    let (throttle, logged_throttle) = match smoothed.is_empty() {
        true => (logged, smoothed),
        false => (smoothed, logged),
    };
    let volts = part(&flight.battery_v, 1.0, units.battery_v);
    Segment {
        flight: 0,
        run: 0,
        rows: rows.collect(),
        time_s: flight.time_s[from..=b].to_vec(),
        throttle,
        logged_throttle,
        height: part(&flight.height_m, units.height_m, 0.0),
        climb_mps: part(&flight.climb_mps, 1.0, 0.0),
        drift: if volts.is_empty() {
            Drift::Unknown
        } else {
            Drift::Voltage(volts)
        },
        on_s: run.on_s,
        force: part(&flight.force, 1.0, 0.0),
        accelerometer: flight.force_from == ForceFrom::Accelerometer,
        range_m: part(&flight.range_m, 1.0, 0.0),
        climb_measured_mps: part(&flight.climb_measured_mps, 1.0, 0.0),
        tilt_rad: part(&flight.tilt_rad, 1.0, 0.0),
        bias_sd: settings
            .height_bias_radii
            .hypot((run.drift_m / units.height_m).min(MOST_DRIFT)),
    }
}

/// Long holes of the throttle are held too: the rows in them do not count.
fn held(mut values: Vec<f64>) -> Vec<f64> {
    let mut last = values
        .iter()
        .copied()
        .find(|v| v.is_finite())
        .unwrap_or(0.0);
    for v in &mut values {
        if v.is_finite() {
            last = *v;
        } else {
            *v = last;
        }
    }
    values
}

/// Stretches that are not flight, with why.
pub(super) fn left_out(flight: &Flight, phases: &Phases) -> Vec<Excluded> {
    let mut out = Vec::new();
    let mut i = 0;
    for run in phases.rows.chunk_by(|a, b| a == b) {
        let (from, to) = (i, i + run.len() - 1);
        i += run.len();
        let why = match run[0] {
            Phase::Airborne => continue,
            Phase::Off => "motors off",
            Phase::Contact => "on the ground, or motors spinning up",
            Phase::Impact => "impact or drop",
            Phase::Tilted => "leaning beyond 20 degrees",
        };
        out.push(Excluded {
            log: flight.name.clone(),
            from_s: flight.time_s[from],
            to_s: flight.time_s[to],
            why: why.to_string(),
        });
    }
    out
}
