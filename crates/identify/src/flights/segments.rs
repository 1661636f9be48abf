//! Flights taken apart into runs that a model is fitted to, and what was left out and why.

use serde::Serialize;

use super::hover::DRIFT_S;
use super::model::Segment;
use super::phases::{Phase, Phases};
use super::{Flight, FlightSettings};
use crate::thrust::plateau::median;

/// Fewest rows in flight of a run that is used.
pub(super) const FEWEST_ROWS: usize = 50;
/// Drift of the height on the ground before a take-off beyond which it says nothing of heights near the ground (in R).
const MOST_DRIFT: f64 = 1.0;
/// Climb rate up to which a vehicle hovers (m/s).
const HOVER_MPS: f64 = 0.15;
/// A force this close to gravity is hover (gravities).
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
    /// What was left out.
    pub left_out: Vec<Excluded>,
}

impl Segments {
    /// Puts time where voltages are where not all runs have one, for batteries empty whether that is logged or not; says
    /// whether it did.
    pub(super) fn drifts_with_time(&mut self, flights: &[Flight]) -> bool {
        if self.pieces.iter().all(|p| !p.battery_v.is_empty()) {
            return false;
        }
        for piece in &mut self.pieces {
            let start_s = flights[piece.flight].time_s[0];
            let time = piece.time_s.iter();
            piece.battery_v = time.map(|t| (t - start_s) / DRIFT_S).collect();
        }
        true
    }
}

/// Cuts flights into runs. Heights are in rotor radii where that is known, else in metres.
#[must_use]
pub fn cut(flights: &[Flight], phases: &[Phases], settings: &FlightSettings) -> Segments {
    let unit_m = settings.rotor_radius_m.unwrap_or(1.0);
    let airborne = |f: usize, i: usize| phases[f].rows[i] == Phase::Airborne;
    let hovering = |f: usize, i: usize| {
        airborne(f, i)
            && flights[f]
                .climb_mps
                .get(i)
                .is_none_or(|v| v.abs() < HOVER_MPS)
            && flights[f]
                .force
                .get(i)
                .is_none_or(|a| (a - 1.0).abs() < HOVER_FORCE)
    };
    let over = |keep: &dyn Fn(usize, usize) -> bool| {
        median((0..flights.len()).flat_map(|f| {
            (0..flights[f].time_s.len())
                .filter(move |&i| keep(f, i))
                .map(move |i| flights[f].throttle[i])
        }))
    };
    let hover_throttle = over(&hovering).or_else(|| over(&airborne)).unwrap_or(0.5);
    let volts = median(flights.iter().enumerate().flat_map(|(f, flight)| {
        flight
            .battery_v
            .iter()
            .enumerate()
            .filter(move |(i, _)| airborne(f, *i))
            .map(|(_, v)| *v)
    }))
    .unwrap_or(0.0);
    let mut out = Segments {
        pieces: Vec::new(),
        hover_throttle,
        left_out: Vec::new(),
    };
    for (index, (flight, phases)) in flights.iter().zip(phases).enumerate() {
        out.left_out.extend(left_out(flight, phases));
        for (number, run) in phases.runs.iter().enumerate() {
            let [a, b] = run.rows;
            let command = if flight.command.is_empty() {
                &flight.throttle
            } else {
                &flight.command
            };
            // Heights that wandered on the ground are wrong by an unknown length in flight too.
            let drifted = settings.rotor_radius_m.is_some() && run.drift_m > MOST_DRIFT * unit_m;
            let least_m = if drifted {
                run.drift_m + settings.reference_radii * unit_m
            } else {
                f64::NEG_INFINITY
            };
            if drifted {
                out.left_out.push(Excluded {
                    log: flight.name.clone(),
                    from_s: flight.time_s[a],
                    to_s: flight.time_s[b],
                    why: format!(
                        "heights below {least_m:.2} m: on the ground before this take-off the height wandered by \
                         {:.2} m, more than {MOST_DRIFT} rotor radius",
                        run.drift_m
                    ),
                });
            }
            // One row of standstill before, so that the first command is a step.
            let from = a.saturating_sub(usize::from(run.on_s.is_some()));
            let rows: Vec<usize> = (a..=b)
                .filter(|&i| {
                    phases.rows[i] == Phase::Airborne
                        && flight.force.get(i).is_some_and(|f| f.is_finite())
                        && flight.climb_mps.get(i).is_none_or(|v| v.is_finite())
                        && flight.height_m.get(i).is_none_or(|z| *z >= least_m)
                })
                .map(|i| i - from)
                .collect();
            if rows.len() < FEWEST_ROWS {
                out.left_out.push(Excluded {
                    log: flight.name.clone(),
                    from_s: flight.time_s[a],
                    to_s: flight.time_s[b],
                    why: format!(
                        "run {}: {} rows in flight with a specific force, {FEWEST_ROWS} are needed",
                        number + 1,
                        rows.len()
                    ),
                });
                continue;
            }
            let part = |c: &[f64], scale: f64, shift: f64| -> Vec<f64> {
                if c.is_empty() {
                    return Vec::new();
                }
                c[from..=b].iter().map(|v| (v - shift) / scale).collect()
            };
            out.pieces.push(Segment {
                flight: index,
                run: number,
                time_s: flight.time_s[from..=b].to_vec(),
                throttle: held(part(command, hover_throttle, 0.0)),
                height: part(&flight.height_m, unit_m, 0.0),
                climb_mps: part(&flight.climb_mps, 1.0, 0.0),
                battery_v: part(&flight.battery_v, 1.0, volts),
                on_s: run.on_s,
                force: part(&flight.force, 1.0, 0.0),
                rows,
                bias_sd: settings
                    .height_bias_radii
                    .hypot((run.drift_m / unit_m).min(MOST_DRIFT)),
            });
        }
    }
    out
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
