//! Thrust from flights: mass times specific force, where the vehicle flies and the ground is far.

use touchdown_trial::Trial;

use super::fit::Fit;
use super::ground::{Basis, GroundEffect, label, slowest_throttle_s};
use super::model::{Curve, ModelTerms, Segment};
use super::phases::{Phase, Phases};
use super::record::forces_from;
use super::resampling::Resampling;
use super::result::FlightResult;
use super::segments::cut;
use super::selection::ModelSelection;
use super::{Flight, FlightSettings, ForceFrom};
use crate::error::{Error, Result, VehicleNumber};
use crate::refusal::Refusal;
use crate::settings::IdentificationSettings;
use crate::warning::{Warning, sentences};
use crate::{FittedCard, Origin};

/// The thrust card of flights that have thrust by [`with_thrust`], and the whole result. What it measured is the thrust of
/// all rotors.
///
/// # Errors
/// Those of [`Flight::of`] and [`thrust_alone`], and flights without mass or specific force.
pub fn thrust_of_flights(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<(FittedCard, FlightResult)> {
    let flights: Vec<Flight> = trials
        .iter()
        .map(|trial| Flight::of(trial, &settings.flight))
        .collect::<Result<_>>()?;
    let found = thrust_alone(&flights, &settings.flight)?;
    let mut made = found.thrust_of(settings, origin).ok_or_else(|| {
        Error::Arguments(
            "expected the mass and the specific force for thrust from flights, found none"
                .to_string(),
        )
    })?;
    let refused = found.refused.iter().cloned();
    made.warnings.extend(refused.map(Warning::NotIdentified));
    let notes = flights.iter().flat_map(|f| f.notes.iter().cloned());
    made.warnings.extend(notes);
    made.card.warnings = sentences(&made.warnings);
    made.card.measured_rotors = settings.vehicle.rotors;
    Ok((made, found.result(&flights, &settings.flight)))
}

/// The trial with `thrust_n` from specific force and mass. On the ground, around impacts, leaning, and in ground effect
/// (where height and rotor radius are known) thrust is a gap. How many rows are left is noted in the provenance.
///
/// # Errors
/// No mass, no specific force, or no row in flight.
pub fn with_thrust(
    trial: &Trial,
    settings: &FlightSettings,
    mass_kg: Option<f64>,
) -> Result<Trial> {
    let mass_kg = settings.mass_kg.or(mass_kg).ok_or_else(no_mass)?;
    let flight = Flight::of(trial, settings)?;
    if flight.force.is_empty() {
        return Err(without_force(trial.name(), &flight, settings));
    }
    let phases = Phases::of(&flight, settings);
    let reference_m = settings
        .rotor_radius_m
        .map(|r| r * settings.reference_radii);
    // The flight's clock may be coarser than the trial's.
    let measured = trial.channel("specific_force_mps2");
    let derived = flight.force_from == ForceFrom::Poses;
    let mut at = 0;
    let thrust: Vec<f64> = trial
        .time_s()
        .iter()
        .enumerate()
        .map(|(i, &t)| {
            while at + 1 < flight.time_s.len() && flight.time_s[at + 1] <= t {
                at += 1;
            }
            let near =
                reference_m.is_some_and(|m| flight.height_m.get(at).is_some_and(|z| !(*z > m)));
            if phases.rows[at] != Phase::Airborne || near {
                return f64::NAN;
            }
            mass_kg
                * match measured {
                    Some(force) if !derived => force[i],
                    _ => flight.force[at] * settings.gravity_mps2,
                }
        })
        .collect();
    let used = thrust.iter().filter(|t| t.is_finite()).count();
    if used == 0 {
        return Err(no_flight(trial.name(), &flight, &phases, reference_m));
    }
    let what = if derived {
        "specific force from poses"
    } else {
        "specific force"
    };
    // The motors' own throttles are kept; a mean is what a flight has at least.
    let mean = super::channels::effort(trial)?.0;
    let mut out = trial.clone();
    out.insert("thrust_n", thrust)?;
    if out.channel("throttle").is_none() {
        out.insert("throttle", mean)?;
    }
    out.note(format!(
        "thrust is {mass_kg} kg times {what} in {used} of {} rows, in flight out of ground effect",
        trial.len()
    ));
    Ok(out)
}

/// A flight whose mass nobody states.
pub(super) fn no_mass() -> Error {
    Error::Unstated(VehicleNumber::Mass)
}

/// A flight without specific force, and without poses that it could be derived from.
pub(super) fn without_force(name: &str, flight: &Flight, settings: &FlightSettings) -> Error {
    let mut found = vec!["neither".to_string()];
    found.extend(sentences(&flight.notes));
    Error::data(
        name,
        format!(
            "`specific_force_mps2` (the accelerometer along the rotor axis), or heights and throttle at {} Hz or more to derive \
             it from",
            settings.least_rate_hz
        ),
        found.join("; "),
    )
}

/// A lag of the motors whose standard error is greater than this share of it is not resolved.
/// As for the wake.
const RESOLVED: f64 = 0.4;
/// Elasticity of thrust by throttle that rotors have: 1 for a command of thrust, 2 for one of speed, and some room.
/// Outside it no multirotor hovers: half of 0.6 would pass vibration for thrust.
const ROTORS: [f64; 2] = [0.6, 3.0];
/// Least share of the variance of specific force that throttle must explain.
/// Hover alone explains more; less is noise that happens to correlate.
const LEAST_EXPLAINED: f64 = 0.02;

/// Identifies throttle to thrust from flights, out of ground effect where heights and rotor radius are known: elasticity,
/// lag and dead time of the motors, battery, climb; with what the logs do not identify.
///
/// # Errors
/// Logs without flight, some with and some without accelerometer, or thrust that does not follow the throttle.
pub fn thrust_alone(flights: &[Flight], settings: &FlightSettings) -> Result<GroundEffect> {
    let basis = match forces_from(flights)? {
        ForceFrom::Accelerometer => Basis::Accelerometer,
        _ => Basis::Poses,
    };
    let phases: Vec<Phases> = flights.iter().map(|f| Phases::of(f, settings)).collect();
    let mut cut = cut(flights, &phases, settings);
    let name = label(flights);
    if let Some(r) = settings.rotor_radius_m {
        for piece in cut.pieces.iter_mut().filter(|p| !p.height.is_empty()) {
            let height = &piece.height;
            piece.rows.retain(|&i| height[i] > settings.reference_radii);
        }
        cut.pieces
            .retain(|p| p.rows.len() >= super::segments::FEWEST_ROWS);
        if cut.pieces.is_empty() {
            let far_m = Some(r * settings.reference_radii);
            return Err(no_flight(&name, &flights[0], &phases[0], far_m));
        }
    }
    if cut.pieces.is_empty() {
        return Err(no_flight(&name, &flights[0], &phases[0], None));
    }
    let slowest = slowest_throttle_s(flights);
    let fast_enough = slowest * settings.least_rate_hz <= 1.0;
    let climb = cut.pieces.iter().all(|p| !p.climb_mps.is_empty());
    let mut refused = Vec::new();
    let drift_of_time = cut.drifts_with_time(flights);
    let terms = ModelTerms::plain(Curve::Free, climb, fast_enough);
    let mut choice = ModelSelection::start(&cut.pieces, terms, settings.reference_radii);
    choice.offer_motors(drift_of_time);
    if fast_enough {
        choice.colour();
    }
    let with_lag = choice.best.value("elasticity");
    lag(
        &mut choice,
        fast_enough.then_some(basis == Basis::Poses),
        slowest,
        settings,
        &mut refused,
    );
    let (fit, tried) = (choice.best, choice.tried);
    let spread = Resampling::of(&fit, &cut.pieces, settings.resamples, settings.seed);
    follows(
        &name,
        cut.hover_throttle,
        &fit,
        &cut.pieces,
        &spread,
        with_lag,
    )?;
    let heights = cut
        .pieces
        .iter()
        .flat_map(|p| p.rows.iter().filter_map(|&i| p.height.get(i)));
    let unit_m = settings.rotor_radius_m.unwrap_or(1.0);
    let heights_m = crate::fitted::range(heights.map(|z| z * unit_m));
    let found = GroundEffect {
        basis,
        drift_of_time,
        rotor_radius_m: settings.rotor_radius_m.unwrap_or(f64::NAN),
        lag: None,
        noise: None,
        range_latency_s: None,
        phases,
        hover_throttle: cut.hover_throttle,
        throttle_period_s: slowest,
        left_out: cut.left_out,
        pieces: cut.pieces,
        fit,
        spread,
        tried,
        refused,
        heights_m: heights_m.unwrap_or([f64::NAN; 2]),
        hovers: Vec::new(),
    };
    Ok(found.without_zero_lag())
}

/// Keeps the motors' lag only where it is resolved; `poses` is absent where the throttle is too slow for any.
fn lag(
    choice: &mut ModelSelection<'_>,
    poses: Option<bool>,
    slowest: f64,
    settings: &FlightSettings,
    refused: &mut Vec<Refusal>,
) {
    let least_rate_hz = settings.least_rate_hz;
    match poses {
        None => {
            return refused.push(Refusal::MotorLagSlowThrottle {
                period_s: slowest,
                least_rate_hz,
            });
        }
        // It stays in the model: the smoothing takes a part in it, so that it is no lag of the motors alone.
        Some(true) => return refused.push(Refusal::MotorLagFromPoses { least_rate_hz }),
        Some(false) => {
            let Some(t) = choice.estimate("T_m", settings) else {
                return;
            };
            let parameters = choice.best.shape.parameters();
            let bound_s = parameters.iter().find(|p| p.name == "T_m");
            let bound_s = bound_s.map_or(1.0, |p| p.max);
            let within = t.value < 0.98 * bound_s;
            if t.ci95[0] > 0.0 && t.std_error < RESOLVED * t.value && within {
                return;
            }
            refused.push(if within {
                Refusal::MotorLagUnresolved(t)
            } else {
                Refusal::MotorLagAtBound { bound_s }
            });
        }
    }
    let before = choice.best.clone();
    let shape = ModelTerms {
        motor_lag: false,
        drag: false,
        ..before.shape
    };
    choice.replace("without the motors' lag", shape, &before);
}

/// Thrust that does not follow the throttle is none; `with_lag` is the elasticity of the model before its lag was judged.
pub(super) fn follows(
    name: &str,
    hover_throttle: f64,
    fit: &Fit,
    pieces: &[Segment],
    spread: &Resampling,
    with_lag: Option<f64>,
) -> Result<()> {
    let fault = |found: String| {
        Err(Error::data(
            name,
            "specific force that follows the throttle (a multirotor in flight: climbs, descents, throttle pulses)",
            found,
        ))
    };
    if !fit.converged || fit.theta.iter().any(|v| !v.is_finite()) {
        return fault(format!("no convergence after {} steps", fit.steps));
    }
    let (mut left, mut all) = (0.0, 0.0);
    for (piece, residual) in pieces.iter().zip(fit.residuals(pieces)) {
        let n = residual.len() as f64;
        let mean = piece.rows.iter().map(|&i| piece.force[i]).sum::<f64>() / n;
        all += piece
            .rows
            .iter()
            .map(|&i| (piece.force[i] - mean).powi(2))
            .sum::<f64>();
        left += residual.iter().map(|r| r * r).sum::<f64>();
    }
    let explained = 1.0 - left / all;
    let elasticity = spread.number(fit, "elasticity");
    let of_rotors = |e: f64| (ROTORS[0]..=ROTORS[1]).contains(&e);
    let at_edge = fit.value("elasticity").is_some_and(|e| !of_rotors(e));
    if at_edge || elasticity.is_none_or(|e| !(e.ci95[0] > 0.0)) || !(explained > LEAST_EXPLAINED) {
        let text = elasticity.map_or_else(String::new, |e| {
            format!(
                "; dlnT/dlns {:.2}, 95 % interval {:.2} to {:.2}",
                e.value, e.ci95[0], e.ci95[1]
            )
        });
        // A lag that disturbances hide took the elasticity with it: without an interval, both are reported alone.
        let advice = with_lag
            .filter(|e| fit.index("T_m").is_none() && of_rotors(*e))
            .map_or_else(String::new, |e| {
                format!(
                    "quick changes of the throttle too weak against the disturbances to resolve the motors' lag (record pulses of the \
                     throttle, a second up and a second down; or try the form `lagged_motors` (setting `thrust.form`), which takes \
                     disturbances for noise: with a lag dlnT/dlns would be {e:.2}); without one, "
                )
            });
        return fault(format!(
            "{advice}throttle explains {:.1} % of the variance of the specific force{text} (rotors have 1 to 2): a throttle that hardly moves, vibration, quick flight or not a \
             multirotor; the throttle of hover is {hover_throttle:.3}",
            100.0 * explained.max(0.0)
        ));
    }
    Ok(())
}

/// Nothing is left: what the log has instead.
fn no_flight(name: &str, flight: &Flight, phases: &Phases, above_m: Option<f64>) -> Error {
    let far = above_m.map_or_else(String::new, |m| {
        format!(" above {m:.3} m (out of ground effect, by `rotor_radius_m`)")
    });
    let share = |phase| 100.0 * phases.count(phase) as f64 / phases.rows.len().max(1) as f64;
    let blind = flight.height_m.iter().filter(|z| !z.is_finite()).count();
    let mut found = format!(
        "none: motors off {:.0} % of the time, on the ground or spinning up {:.0} %, tilted or in impact {:.0} %, in flight {:.0} %",
        share(Phase::Off),
        share(Phase::Contact),
        share(Phase::Tilted) + share(Phase::Impact),
        share(Phase::Airborne),
    );
    if let Some([lo, hi]) = crate::fitted::range(flight.height_m.iter().copied()) {
        found += &format!("; heights {lo:.2} to {hi:.2} m");
    }
    if blind > 0 {
        let of = 100.0 * blind as f64 / flight.height_m.len() as f64;
        found +=
            &format!(", not known for {of:.0} % of the time (a range finder out of its range?)");
    }
    Error::data(name, format!("flight{far} with a specific force"), found)
}
