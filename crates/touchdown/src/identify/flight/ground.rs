//! Ground effect from flights: what the logs carry, with intervals; what they do not carry is refused.

use serde::Serialize;

use super::choose::{Candidate, Choice};
use super::fit::Fit;
use super::model::{Curve, Piece, Shape};
use super::phases::Phases;
use super::pieces::{LeftOut, cut};
use super::spread::Spread;
use super::{Flight, FlightSettings};
use crate::error::{Error, Result};

/// A curve needs heights below so many rotor radii.
const NEAR_RADII: f64 = 2.0;
/// Least time near the ground (s): a few take-offs.
const LEAST_NEAR_S: f64 = 0.5;
/// Least time out of ground effect (s).
const LEAST_FAR_S: f64 = 1.0;
/// A lag whose standard error is greater than this share of it is not resolved.
const RESOLVED: f64 = 0.4;

/// What the logs do not carry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refused {
    /// What cannot be identified.
    pub what: String,
    /// Why.
    pub found: String,
    /// What to record to cure that.
    pub record: String,
}

/// The ground effect of one vehicle, from its flights.
#[derive(Clone, Debug)]
pub struct GroundEffect {
    /// Rotor radius R (m).
    pub rotor_radius_m: f64,
    /// Flights, taken apart.
    pub phases: Vec<Phases>,
    /// The runs that the model was fitted to.
    pub pieces: Vec<Piece>,
    /// Throttle in hover.
    pub hover_throttle: f64,
    /// The model.
    pub fit: Fit,
    /// Its uncertainty.
    pub spread: Spread,
    /// All models that were tried.
    pub tried: Vec<Candidate>,
    /// Rows that were not used.
    pub left_out: Vec<LeftOut>,
    /// What the logs do not carry.
    pub refused: Vec<Refused>,
    /// Least and greatest height of the rows that count (m).
    pub heights_m: [f64; 2],
}

/// Identifies the ground effect from flights with specific force and height.
///
/// # Errors
/// Logs that carry no ground effect: the message says why, and what to record.
pub fn ground_effect(flights: &[Flight], settings: &FlightSettings) -> Result<GroundEffect> {
    let Some(rotor_radius_m) = settings.rotor_radius_m else {
        return Err(Error::Arguments(
            "the ground effect goes with the rotor radius: expected `rotor_radius_m` in the table [flight] of --settings, \
             found none"
                .to_string(),
        ));
    };
    for flight in flights {
        if flight.height_m.is_empty() {
            let found = "no height";
            return Err(Error::data(&flight.name, "values of `height_m`", found));
        }
        if flight.force.is_empty() {
            return Err(Error::data(
                &flight.name,
                "values of `specific_force_mps2`",
                "none",
            ));
        }
    }
    let phases: Vec<Phases> = flights.iter().map(|f| Phases::of(f, settings)).collect();
    let cut = cut(flights, &phases, settings);
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
    let slowest = flights
        .iter()
        .map(|f| f.throttle_period_s)
        .fold(0.0, f64::max);
    let fast_enough = slowest * settings.least_rate_hz <= 1.0;
    let has = |f: fn(&Piece) -> bool| cut.pieces.iter().any(f);
    let plain = Shape::plain(
        Curve::Exponential,
        cut.pieces.iter().all(|p| !p.climb_mps.is_empty()),
        fast_enough,
    );
    let mut choice = Choice::start(&cut.pieces, plain, settings.reference_radii);
    let with = |choice: &Choice<'_>, change: fn(&mut Shape)| {
        let mut shape = choice.best.shape;
        change(&mut shape);
        shape
    };
    if has(|p| p.on_s.is_some()) {
        let shape = with(&choice, |s| s.settling = true);
        choice.offer("settling after the start", shape, false);
    }
    if cut.pieces.iter().all(|p| !p.battery_v.is_empty()) {
        let shape = with(&choice, |s| s.battery = true);
        choice.offer("battery voltage", shape, false);
    }
    let shape = with(&choice, |s| s.curvature = true);
    choice.offer("second term of throttle", shape, false);
    if fast_enough {
        let before = choice.best.clone();
        let shape = with(&choice, |s| s.wake_lag = true);
        choice.offer("wake lag", shape, true);
        choice.curves();
        choice.colour();
        resolve_lag(&mut choice, &before, settings, &mut refused);
    } else {
        choice.curves();
        refused.push(Refused {
            what: "lags of motors and wake".into(),
            found: format!("throttle logged every {slowest:.3} s"),
            record: format!("throttle at {} Hz or more", settings.least_rate_hz),
        });
    }
    climb_near_ground(&mut choice, settings, &mut refused);
    let fit = choice.best;
    if !fit.converged || fit.theta.iter().any(|v| !v.is_finite()) {
        return Err(Error::data(
            name,
            "data that a model follows from",
            format!("no rest after {} steps", fit.steps),
        ));
    }
    let tried = choice.tried;
    let spread = Spread::of(&fit, &cut.pieces, settings.resamples, settings.seed);
    Ok(GroundEffect {
        rotor_radius_m,
        phases,
        hover_throttle: cut.hover_throttle,
        left_out: cut.left_out,
        pieces: cut.pieces,
        fit,
        spread,
        tried,
        refused,
        heights_m,
    })
}

/// Heights near the ground and out of its effect, both for long enough.
fn check_heights(
    name: &str,
    flights: &[Flight],
    pieces: &[Piece],
    rotor_radius_m: f64,
    settings: &FlightSettings,
) -> Result<[f64; 2]> {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut near_s, mut far_s) = (0.0, 0.0);
    for piece in pieces {
        let step_s = flights[piece.flight].step_s();
        for z in piece.rows.iter().map(|&i| piece.height[i]) {
            range = [range[0].min(z), range[1].max(z)];
            near_s += if z < NEAR_RADII { step_s } else { 0.0 };
            far_s += if z > settings.reference_radii {
                step_s
            } else {
                0.0
            };
        }
    }
    let m = |radii: f64| radii * rotor_radius_m;
    let [lo, hi] = range.map(m);
    if near_s < LEAST_NEAR_S {
        return Err(Error::data(
            name,
            format!(
                "flight below {:.3} m (two rotor radii) for {LEAST_NEAR_S} s or more: record hover of some seconds at 0.5, 1 and 2 \
                 rotor radii, or slow landings",
                m(NEAR_RADII)
            ),
            format!("{near_s:.1} s; heights {lo:.3} to {hi:.3} m"),
        ));
    }
    if far_s < LEAST_FAR_S {
        return Err(Error::data(
            name,
            format!(
                "flight above {:.3} m ({} rotor radii) for {LEAST_FAR_S} s or more, as the reference out of ground effect: \
                 record some seconds of hover there",
                m(settings.reference_radii),
                settings.reference_radii
            ),
            format!("{far_s:.1} s; heights {lo:.3} to {hi:.3} m"),
        ));
    }
    Ok([lo, hi])
}

/// Keeps the wake's lag only where flights left out want it and its interval is narrow enough.
fn resolve_lag(
    choice: &mut Choice<'_>,
    before: &Fit,
    settings: &FlightSettings,
    refused: &mut Vec<Refused>,
) {
    let record = "quick climbs and descents below two rotor radii, back and forth within a second, in several flights";
    if !choice.best.shape.wake_lag {
        refused.push(Refused {
            what: "lag of the wake".into(),
            found: "flights left out are predicted no better with it".into(),
            record: record.into(),
        });
        return;
    }
    let tau = choice.sure("tau", settings);
    if let Some(tau) = tau
        && tau.ci95[0] > 0.0
        && tau.std_error < RESOLVED * tau.value
    {
        return;
    }
    refused.push(Refused {
        what: "lag of the wake".into(),
        found: tau.map_or_else(
            || "no interval".to_string(),
            |t| {
                format!(
                    "{:.3} s, 95 % interval {:.3} to {:.3} s",
                    t.value, t.ci95[0], t.ci95[1]
                )
            },
        ),
        record: record.into(),
    });
    let shape = Shape {
        wake_lag: false,
        ..choice.best.shape
    };
    choice.replace("without the wake's lag", shape, before);
}

/// Keeps a climb damping that differs near the ground only where flights left out want it and it is not zero.
fn climb_near_ground(
    choice: &mut Choice<'_>,
    settings: &FlightSettings,
    refused: &mut Vec<Refused>,
) {
    let mut refuse = |found: String, record: &str| {
        refused.push(Refused {
            what: "effect of climb and sink on the ground effect".into(),
            found,
            record: record.into(),
        });
    };
    if !choice.best.shape.damping {
        return refuse(
            "no climb rate".into(),
            "height or climb rate at 20 Hz or more",
        );
    }
    let record =
        "climbs and descents through the same heights below two rotor radii at 0.1 to 0.5 m/s";
    let lag = choice.sure("tau", settings);
    let before = choice.best.clone();
    let shape = Shape {
        near_damping: true,
        ..before.shape
    };
    if !choice.offer("damping near the ground", shape, true) {
        return refuse(
            "flights left out are predicted no better with it".into(),
            record,
        );
    }
    let near = choice.sure("near_damping", settings);
    // A lag shows as an effect of climb, and the other way round: what moves the lag is not told apart from it.
    let moves_lag = lag
        .zip(choice.best.value("tau"))
        .is_some_and(|(before, after)| (after - before.value).abs() > before.std_error);
    if moves_lag || near.is_none_or(|n| !n.differs_from_zero()) {
        choice.replace("without damping near the ground", before.shape, &before);
        let why = if moves_lag {
            "it cannot be told from the wake's lag"
        } else {
            "its interval holds zero"
        };
        refuse(why.into(), record);
    }
}

fn label(flights: &[Flight]) -> String {
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
