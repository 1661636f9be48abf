//! Hovers at rest: segments of flight in which thrust equals weight.

use serde::Serialize;
use touchdown_model::Card;

use super::phases::{Phase, Phases};
use super::{Flight, FlightSettings};
use crate::error::Result;
use crate::thrust::at_rest;

/// Climb rate up to which a vehicle is at rest (m/s).
/// At 0.1 m/s climb damping changes thrust by 0.7 %, less than a hover's noise. Twice doubles that bias.
pub(super) const REST_MPS: f64 = 0.1;
/// Shortest and longest hover that is one point (s).
/// Twice [`ENDS_S`] and a tenth of a second. Half would leave spin-up and settling in the mean.
pub(super) const SHORTEST_S: f64 = 0.8;
/// A longer hover gives several points, which keeps slow drifts out of one mean. It changes weights, not means.
const LONGEST_S: f64 = 3.0;
/// Time excluded at both ends of a hover (s), less if the hover is short.
/// Four lags of the motors (0.06 s) and one period of a slow speed sensor. Half leaves a tenth of the transient.
pub(super) const ENDS_S: f64 = 0.35;
/// Heights of one hover: within this of the first ones' mean, the greater of both (m, R).
/// Noise of heights of small vehicles, for which a share of the radius is too narrow.
const BAND_M: f64 = 0.01;
/// The effect changes by a tenth over it. Twice mixes heights that differ.
const BAND_RADII: f64 = 0.2;
/// What the motors' thrust out of ground effect is taken from.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ThrustLaw {
    /// Thrust is proportional to the square of the rotor speed.
    RotorSpeed,
    /// A thrust card.
    Card,
    /// Thrust is proportional to an unknown power of throttle: 1.5, with a standard deviation of 0.3.
    Throttle,
}

/// A hover at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hover {
    /// The log.
    pub log: String,
    /// Index of the flight.
    #[serde(skip)]
    pub flight: usize,
    /// Index of the armed interval.
    #[serde(skip)]
    pub run: usize,
    /// From (s).
    pub from_s: f64,
    /// To (s).
    pub to_s: f64,
    /// Mean height as logged (m).
    pub height_m: f64,
    /// Mean throttle.
    pub throttle: f64,
    /// Thrust over that out of ground effect at the same throttle or rotor speed.
    pub ratio: f64,
    /// Root of the thrust out of ground effect, in any unit.
    #[serde(skip)]
    pub(super) root: f64,
    /// Thrust over weight that the motion asks for.
    #[serde(skip)]
    pub(super) load: f64,
    /// Mean voltage (V).
    #[serde(skip)]
    pub(super) battery_v: Option<f64>,
}

/// The root of the thrust out of ground effect of every row, and what it is from.
pub(super) fn roots(flight: &Flight, card: Option<&Card>) -> Result<(ThrustLaw, Vec<f64>)> {
    if let Some(card) = card {
        let thrust = at_rest(card, &flight.throttle, &flight.battery_v)?;
        return Ok((
            ThrustLaw::Card,
            thrust.iter().map(|t| t.max(0.0).sqrt()).collect(),
        ));
    }
    if flight.rotor_rpm.is_empty() {
        Ok((ThrustLaw::Throttle, flight.throttle.clone()))
    } else {
        Ok((ThrustLaw::RotorSpeed, flight.rotor_rpm.clone()))
    }
}

/// All hovers of a flight.
pub(super) fn hovers(
    index: usize,
    flight: &Flight,
    phases: &Phases,
    root: &[f64],
    settings: &FlightSettings,
) -> Vec<Hover> {
    let band_m = BAND_M.max(BAND_RADII * settings.rotor_radius_m.unwrap_or(0.0));
    let time = &flight.time_s;
    let rests = |i: usize| {
        phases.rows[i] == Phase::Airborne
            && flight.climb_mps.get(i).is_some_and(|v| v.abs() <= REST_MPS)
            && flight.height_m.get(i).is_some_and(|z| z.is_finite())
            && root[i].is_finite()
    };
    let mut out = Vec::new();
    for (number, run) in phases.runs.iter().enumerate() {
        let [mut i, b] = run.rows;
        while i <= b {
            let (from, mut sum) = (i, 0.0);
            while i <= b && rests(i) && time[i] - time[from] <= LONGEST_S {
                let count = (i - from) as f64;
                let step_s = if i > from { time[i] - time[i - 1] } else { 0.0 };
                let z = flight.height_m[i];
                if step_s > 0.5 || count > 0.0 && (z - sum / count).abs() > band_m {
                    break;
                }
                sum += z;
                i += 1;
            }
            if i == from {
                i += 1;
                continue;
            }
            let to = i - 1;
            let long_s = time[to] - time[from];
            if long_s < SHORTEST_S {
                continue;
            }
            // The ends are not at rest yet: motors, and rotor speeds reported three times a second, come after.
            let ends_s = ENDS_S.min(0.5 * (long_s - 0.5 * SHORTEST_S));
            let inner = |i: &usize| (time[from] + ends_s..=time[to] - ends_s).contains(&time[*i]);
            let (Some(from), Some(to)) = ((from..=to).find(inner), (from..=to).rfind(inner)) else {
                continue;
            };
            let long_s = time[to] - time[from];
            let mean = |c: &[f64]| -> Option<f64> {
                let known: Vec<f64> = c
                    .get(from..=to)?
                    .iter()
                    .copied()
                    .filter(|v| v.is_finite())
                    .collect();
                (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
            };
            let rise = flight.climb_mps[to] - flight.climb_mps[from];
            let lean = mean(&flight.tilt_rad).map_or(1.0, f64::cos);
            let (Some(height_m), Some(throttle), Some(root)) =
                (mean(&flight.height_m), mean(&flight.throttle), mean(root))
            else {
                continue;
            };
            out.push(Hover {
                log: flight.name.clone(),
                flight: index,
                run: number,
                from_s: time[from],
                to_s: time[to],
                height_m,
                throttle,
                ratio: f64::NAN,
                root,
                load: (1.0 + rise / (long_s.max(0.1) * settings.gravity_mps2)) / lean,
                battery_v: mean(&flight.battery_v),
            });
        }
    }
    out
}
