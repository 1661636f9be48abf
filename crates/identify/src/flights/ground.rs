//! Ground effect from flights: what the logs identify, with intervals; what they do not identify is refused.

use serde::Serialize;
use touchdown_model::Card;

use super::fit::Fit;
use super::hover::{self, Hover, ThrustLaw};
use super::lag::lag;
use super::model::{Curve, ModelTerms, Segment};
use super::phases::Phases;
use super::record::forces_from;
use super::resampling::Resampling;
use super::resolve::{climb_near_ground, resolve_lag, wants_lag};
use super::segments::{Excluded, cut};
use super::selection::{Candidate, ModelSelection};
use super::thrust::follows;
use super::{Flight, FlightSettings, ForceFrom};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::refusal::{NoForce, Refusal};

/// A curve needs heights below this number of rotor radii, where the effect is several per cent of thrust. Half refuses vehicles
/// with long legs; twice accepts flights without ground effect, which fail later.
pub(super) const CURVE_NEAR_RADII: f64 = 2.0;
/// Least time near the ground (s): a few take-offs.
/// Half is a single bounce; twice refuses quick take-offs that do identify the effect together.
const LEAST_NEAR_S: f64 = 0.5;
/// Least spread of heights near the ground, in rotor radii.
/// The effect falls by a quarter to a third over it. Half leaves slope and height error confounded.
const LEAST_SPREAD_RADII: f64 = 0.5;
/// Least time out of ground effect (s).
/// Sixteen lags of the motors, so that the scale is of settled thrust.
const LEAST_FAR_S: f64 = 1.0;

/// What a ground effect was identified from.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// The accelerometer's specific force.
    Accelerometer,
    /// Specific force from derivatives of climb rate or height.
    Poses,
    /// Hovers at rest.
    Hovers {
        /// What the thrust out of ground effect is taken from.
        law: ThrustLaw,
    },
}

impl Basis {
    /// The description of a card.
    pub(super) fn description(self) -> &'static str {
        match self {
            Self::Accelerometer => {
                "Identified from flights, relative to flight out of ground effect."
            }
            Self::Poses => {
                "Identified from poses of flights, without accelerometer, relative to flight out of ground effect."
            }
            Self::Hovers { .. } => {
                "Identified from hovers at rest, relative to hover out of ground effect."
            }
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Accelerometer => "specific force of the accelerometer",
            Self::Poses => "specific force from poses",
            Self::Hovers { law } => match law {
                ThrustLaw::RotorSpeed => "hovers at rest, thrust by rotor speed",
                ThrustLaw::Card => "hovers at rest, thrust by the card",
                ThrustLaw::Throttle => "hovers at rest, thrust by a power of throttle",
            },
        }
    }
}

/// The ground effect of one vehicle, from its flights.
#[derive(Clone, Debug)]
pub struct GroundEffect {
    /// What it is from.
    pub basis: Basis,
    /// Rotor radius R (m).
    pub rotor_radius_m: f64,
    /// Flights, taken apart.
    pub phases: Vec<Phases>,
    /// The runs that the model was fitted to.
    pub pieces: Vec<Segment>,
    /// Throttle in hover.
    pub hover_throttle: f64,
    /// The model.
    pub fit: Fit,
    /// Its uncertainty.
    pub spread: Resampling,
    /// The wake's lag (s), where it was resolved.
    pub(super) lag: Option<Estimate>,
    /// Whether thrust may drift with time, for no voltage is known.
    pub drift_of_time: bool,
    /// All models that were tried.
    pub tried: Vec<Candidate>,
    /// Rows that were not used.
    pub left_out: Vec<Excluded>,
    /// What the logs do not identify.
    pub refused: Vec<Refusal>,
    /// Least and greatest height of the rows that count (m).
    pub heights_m: [f64; 2],
    /// The hovers that it is from, if it is from hovers.
    pub hovers: Vec<Hover>,
}

/// Identifies the ground effect from flights with height: by the accelerometer where all have one and the throttle is
/// quick enough; else by acceleration from their poses, or by hovers at rest.
///
/// # Errors
/// Logs that identify no ground effect: the message says why, and what to record.
pub fn ground_effect(flights: &[Flight], settings: &FlightSettings) -> Result<GroundEffect> {
    ground_effect_with(flights, settings, None)
}

/// As [`ground_effect`], with a card that gives thrust by throttle out of ground effect: hovers without rotor speeds know it
/// otherwise only roughly, and nothing else asks for it.
///
/// # Errors
/// As there.
pub fn ground_effect_with(
    flights: &[Flight],
    settings: &FlightSettings,
    card: Option<&Card>,
) -> Result<GroundEffect> {
    let Some(rotor_radius_m) = settings.rotor_radius_m else {
        return Err(Error::Arguments(
            "the ground effect scales with the rotor radius: expected `rotor_radius_m` in the table [flight] of --settings, \
             found none"
                .to_string(),
        ));
    };
    if let Some(flight) = flights.iter().find(|f| f.height_m.is_empty()) {
        return Err(Error::data(
            &flight.name,
            "values of `height_m`: record a range finder, motion capture or another height above the ground",
            "no height",
        ));
    }
    let from = forces_from(flights)?;
    if from == ForceFrom::Accelerometer {
        let slowest = slowest_throttle_s(flights);
        if slowest * settings.least_rate_hz <= 1.0 {
            return from_force(flights, settings, rotor_radius_m, Basis::Accelerometer);
        }
        // Between its samples a slow throttle is not known: what moves then is no answer to what was logged.
        let why = NoForce::SlowThrottle {
            period_s: slowest,
            least_rate_hz: settings.least_rate_hz,
        };
        return hover::ground_effect(flights, settings, rotor_radius_m, card, why);
    }
    let why = NoForce::NotMeasured;
    let by_hovers = || hover::ground_effect(flights, settings, rotor_radius_m, card, why);
    if from != ForceFrom::Poses {
        return by_hovers();
    }
    let by_poses = || from_force(flights, settings, rotor_radius_m, Basis::Poses);
    // Where thrust by rotor speed or throttle is known, hovers need nothing else.
    if card.is_some() || flights.iter().all(|f| !f.rotor_rpm.is_empty()) {
        by_hovers().or_else(|_| by_poses())
    } else {
        by_poses().or_else(|e| by_hovers().map_err(|_| e))
    }
}

/// From specific force.
fn from_force(
    flights: &[Flight],
    settings: &FlightSettings,
    rotor_radius_m: f64,
    basis: Basis,
) -> Result<GroundEffect> {
    let phases: Vec<Phases> = flights.iter().map(|f| Phases::of(f, settings)).collect();
    let mut cut = cut(flights, &phases, settings);
    let name = label(flights);
    if cut.pieces.is_empty() {
        let why: Vec<&str> = cut.left_out.iter().map(|l| l.why.as_str()).collect();
        return Err(Error::data(
            name,
            "a stretch of flight: motors running, clear of the ground, with height and specific force",
            format!("none ({})", distinct(&why).join("; ")),
        ));
    }
    let heights_m = check_heights(&name, flights, &cut.pieces, rotor_radius_m, settings)?;
    let mut refused = Vec::new();
    let drift_of_time = cut.drifts_with_time(flights);
    let choice = select(&cut.pieces, basis, drift_of_time, settings, &mut refused);
    let fit = choice.best;
    if !fit.converged || fit.theta.iter().any(|v| !v.is_finite()) {
        return Err(Error::data(
            name,
            "data that identify a model",
            format!("no convergence after {} steps", fit.steps),
        ));
    }
    let tried = choice.tried;
    let spread = Resampling::of(&fit, &cut.pieces, settings.resamples, settings.seed);
    follows(&name, cut.hover_throttle, &fit, &cut.pieces, &spread, None)?;
    let found = GroundEffect {
        basis,
        drift_of_time,
        hovers: Vec::new(),
        rotor_radius_m,
        lag: lag(&fit, &cut.pieces, &spread),
        phases,
        hover_throttle: cut.hover_throttle,
        left_out: cut.left_out,
        pieces: cut.pieces,
        fit,
        spread,
        tried,
        refused,
        heights_m,
    };
    found.check_significant(&name, settings)?;
    Ok(found)
}

/// The model that predicts held-out flights best; what the flights do not identify is added to `refused`.
fn select<'a>(
    pieces: &'a [Segment],
    basis: Basis,
    drift_of_time: bool,
    settings: &FlightSettings,
    refused: &mut Vec<Refusal>,
) -> ModelSelection<'a> {
    let plain = ModelTerms::plain(
        Curve::Exponential,
        pieces.iter().all(|p| !p.climb_mps.is_empty()),
        true,
    );
    let mut choice = ModelSelection::start(pieces, plain, settings.reference_radii);
    choice.offer_motors(drift_of_time);
    if basis == Basis::Poses {
        choice.curves();
        refused.extend([Refusal::LagsFromPoses, Refusal::ClimbFromPoses]);
        return choice;
    }
    // A pilot who answers disturbances hides a lag from a model that does not know of them: so first with it, until the
    // disturbance is known.
    let before = choice.best.clone();
    let shape = ModelTerms {
        wake_lag: true,
        ..before.shape
    };
    choice.replace("wake lag", shape, &before);
    choice.colour();
    let lags = wants_lag(&mut choice, refused);
    choice.curves();
    choice.colour();
    if lags {
        resolve_lag(&mut choice, settings, refused);
    }
    climb_near_ground(&mut choice, settings, refused);
    choice
}

impl GroundEffect {
    /// Checks that thrust near the ground is significantly greater than out of ground effect.
    pub(super) fn check_significant(&self, name: &str, settings: &FlightSettings) -> Result<()> {
        let lowest = (self.heights_m[0] / self.rotor_radius_m).max(0.5);
        let height_m = lowest * self.rotor_radius_m;
        let extra = self.of_curve(|v| v.at_rest(lowest) - v.at_rest(settings.reference_radii));
        let Some(near) = extra.filter(|e| !(e.ci95[0] > 0.0)) else {
            return Ok(());
        };
        let [lo, hi] = near.ci95.map(|v| 100.0 * v);
        Err(Error::data(
            name,
            "flights with a significant ground effect: record hovers and slow passes at 0.5, 1, 2 and 6 rotor radii in \
             several flights",
            format!(
                "extra lift of {:.1} % at {height_m:.3} m, 95 % interval {lo:.1} to {hi:.1} %",
                100.0 * near.value
            ),
        ))
    }
}

/// The longest sampling period of a throttle. A constant throttle has none: the motors are off, which is reported elsewhere.
pub(super) fn slowest_throttle_s(flights: &[Flight]) -> f64 {
    let periods = flights.iter().map(|f| f.throttle_period_s);
    periods.filter(|p| p.is_finite()).fold(0.0, f64::max)
}

/// How long, and over which heights (in R), segments fly near the ground and out of its effect.
struct Coverage {
    heights: [f64; 2],
    near_s: f64,
    far_s: f64,
    /// Time near the ground, and its heights, in segments that fly out of ground effect as well: every segment has a scale
    /// of its own, and only one that has both identifies scale and curve.
    whole_s: f64,
    near_heights: [f64; 2],
}

impl Coverage {
    fn of(flights: &[Flight], pieces: &[Segment], settings: &FlightSettings) -> Self {
        const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut out = Self {
            heights: NONE,
            near_s: 0.0,
            far_s: 0.0,
            whole_s: 0.0,
            near_heights: NONE,
        };
        for piece in pieces {
            let step_s = flights[piece.flight].step_s();
            let (mut near, mut far) = (0.0, 0.0);
            let mut near_heights = NONE;
            for z in piece.rows.iter().map(|&i| piece.height[i]) {
                widen(&mut out.heights, [z, z]);
                if z < CURVE_NEAR_RADII {
                    near += step_s;
                    widen(&mut near_heights, [z, z]);
                }
                far += if z > settings.reference_radii {
                    step_s
                } else {
                    0.0
                };
            }
            out.near_s += near;
            out.far_s += far;
            if far >= LEAST_FAR_S {
                out.whole_s += near;
                widen(&mut out.near_heights, near_heights);
            }
        }
        out
    }
}

fn widen(range: &mut [f64; 2], by: [f64; 2]) {
    *range = [range[0].min(by[0]), range[1].max(by[1])];
}

/// Heights near the ground and out of its effect, both for long enough; gives the least and the greatest (m).
fn check_heights(
    name: &str,
    flights: &[Flight],
    pieces: &[Segment],
    rotor_radius_m: f64,
    settings: &FlightSettings,
) -> Result<[f64; 2]> {
    let m = |radii: f64| radii * rotor_radius_m;
    let (near_m, far_m) = (m(CURVE_NEAR_RADII), m(settings.reference_radii));
    let flown = Coverage::of(flights, pieces, settings);
    let Coverage {
        near_s,
        far_s,
        whole_s,
        ..
    } = flown;
    let [lo, hi] = flown.heights.map(m);
    let [near_lo, near_hi] = flown.near_heights.map(m);
    let (expected, found) = if near_s < LEAST_NEAR_S {
        (
            format!(
                "flight below {near_m:.3} m (two rotor radii) for {LEAST_NEAR_S} s or more: record hover of some seconds at 0.5, 1 and 2 \
                 rotor radii, or slow landings"
            ),
            format!("{near_s:.1} s; heights {lo:.3} to {hi:.3} m"),
        )
    } else if far_s < LEAST_FAR_S {
        (
            format!(
                "flight above {far_m:.3} m ({} rotor radii) for {LEAST_FAR_S} s or more, as the reference out of ground effect: \
                 record some seconds of hover there",
                settings.reference_radii
            ),
            format!("{far_s:.1} s; heights {lo:.3} to {hi:.3} m"),
        )
    } else if whole_s < LEAST_NEAR_S {
        (
            format!(
                "flights both below {near_m:.3} m and above {far_m:.3} m for {LEAST_NEAR_S} s and {LEAST_FAR_S} s without landing in between: thrust \
                 differs from run to run of the motors, and near and far of different runs do not compare"
            ),
            format!(
                "{near_s:.1} s near and {far_s:.1} s far, of which {whole_s:.1} s near in runs that have both"
            ),
        )
    } else if near_hi - near_lo < m(LEAST_SPREAD_RADII) {
        (
            format!(
                "heights below {near_m:.3} m (two rotor radii) that differ by {:.3} m or more: record hover at 0.5, 1 and 2 rotor radii, \
                 or slow landings",
                m(LEAST_SPREAD_RADII)
            ),
            format!("{near_lo:.3} to {near_hi:.3} m"),
        )
    } else {
        return Ok([lo, hi]);
    };
    Err(Error::data(name, expected, found))
}

pub(super) fn label(flights: &[Flight]) -> String {
    match flights {
        [one] => one.name.clone(),
        many => format!("{} flights together", many.len()),
    }
}

fn distinct<'a>(all: &[&'a str]) -> Vec<&'a str> {
    let mut out: Vec<&str> = Vec::new();
    for text in all {
        if !out.contains(text) {
            out.push(text);
        }
    }
    out
}
