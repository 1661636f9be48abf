//! Ground effect from flights: what the logs identify, with intervals; what they do not identify is refused.

use serde::Serialize;
use touchdown_model::Card;

use super::coverage::check_heights;
use super::fit::Fit;
use super::height_noise::noise_of_heights;
use super::hover::{self, Hover, ThrustLaw};
use super::model::{Curve, ModelTerms, Segment};
use super::phases::Phases;
use super::record::forces_from;
use super::resampling::Resampling;
use super::resolve::{Resolved, climb_near_ground, final_model, resolve_lag, wants_lag};
use super::segments::{Excluded, cut};
use super::selection::{Candidate, ModelSelection};
use super::thrust::follows;
use super::trajectory::{self, Noise};
use super::{Flight, FlightSettings, ForceFrom};
use crate::error::{Error, Result, VehicleNumber};
use crate::estimate::Estimate;
use crate::refusal::{NoForce, Refusal};
use crate::thrust::plateau::median;

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
    /// Time between two values of the throttle, of the log where it is longest (s).
    pub(super) throttle_period_s: f64,
    /// The model.
    pub fit: Fit,
    /// Its uncertainty.
    pub spread: Resampling,
    /// The wake's lag (s), where it was resolved.
    pub(super) lag: Option<Estimate>,
    /// Noise of sensors and air, where the flights were fitted along their trajectories.
    pub noise: Option<Noise>,
    /// Latency of the range against accelerometer and throttle (s), where the ground moves.
    pub(super) range_latency_s: Option<f64>,
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
    let rotor_radius_m = radius_of_flights_with_height(flights, settings)?;
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

/// The rotor radius (m), once every flight has heights: what every route needs.
///
/// # Errors
/// No rotor radius, or a flight without heights.
pub(super) fn radius_of_flights_with_height(
    flights: &[Flight],
    settings: &FlightSettings,
) -> Result<f64> {
    let Some(rotor_radius_m) = settings.rotor_radius_m else {
        return Err(Error::Unstated(VehicleNumber::RotorRadius));
    };
    if let Some(flight) = flights.iter().find(|f| f.height_m.is_empty()) {
        return Err(Error::data(
            &flight.name,
            "values of `height_m`: record a range finder, motion capture or another height above the ground",
            "no height",
        ));
    }
    Ok(rotor_radius_m)
}

/// From specific force.
pub(super) fn from_force(
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
    let runs = phases.iter().flat_map(|p| &p.runs);
    let stood_m = median(runs.filter_map(|run| run.stood_m));
    let heights_m = check_heights(
        &name,
        flights,
        &cut.pieces,
        rotor_radius_m,
        stood_m,
        settings,
    )?;
    let mut refused = Vec::new();
    let drift_of_time = cut.drifts_with_time(flights);
    let mut choice = select(&cut.pieces, basis, drift_of_time, settings, &mut refused);
    let units = trajectory::Settings {
        radius_m: rotor_radius_m,
        gravity_mps2: settings.gravity_mps2,
    };
    let found = final_model(&mut choice, basis, units, settings, &mut refused).ok_or_else(
        || match basis {
            Basis::Poses => filtered_heights(&name, &cut.pieces),
            _ => noisy_heights(&name, &cut.pieces, rotor_radius_m),
        },
    )?;
    let Resolved {
        fit,
        spread,
        lag,
        noise,
        range_latency_s,
    } = found;
    let tried = choice.tried;
    if !fit.converged || fit.theta.iter().any(|v| !v.is_finite()) {
        return Err(Error::data(
            name,
            "data that identify a model",
            format!("no convergence after {} steps", fit.steps),
        ));
    }
    follows(&name, cut.hover_throttle, &fit, &cut.pieces, &spread, None)?;
    let found = GroundEffect {
        basis,
        drift_of_time,
        hovers: Vec::new(),
        rotor_radius_m,
        lag,
        noise,
        range_latency_s,
        phases,
        hover_throttle: cut.hover_throttle,
        throttle_period_s: slowest_throttle_s(flights),
        left_out: cut.left_out,
        pieces: cut.pieces,
        fit,
        spread,
        tried,
        refused,
        heights_m,
    };
    found.check_significant(&name, settings)?;
    Ok(found.without_zero_lag())
}

/// Heights whose noise biases a fit along them, where no model of noise explains the motion.
fn noisy_heights(name: &str, pieces: &[Segment], rotor_radius_m: f64) -> Error {
    Error::data(
        name,
        format!(
            "heights with noise below {:.1} mm (5 % of the rotor radius), or a motion that sensors with white noise explain: \
             record a quieter range finder or motion capture, and range and accelerometer as the sensors give them, not as a \
             filter does",
            50.0 * rotor_radius_m
        ),
        format!(
            "noise of {:.1} mm, and disturbances of another kind",
            1e3 * noise_of_heights(pieces)
        ),
    )
}

/// Heights without an accelerometer whose errors no sensor's noise explains.
fn filtered_heights(name: &str, pieces: &[Segment]) -> Error {
    Error::data(
        name,
        "heights as the sensor gives them, each in the row of its own stamp: record a range finder or motion capture before any \
         filter, or the accelerometer as well (`specific_force_mps2`)",
        format!(
            "heights whose errors are correlated from one to the next, as a filter leaves them (noise of {:.1} mm)",
            1e3 * noise_of_heights(pieces)
        ),
    )
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
    /// Refuses a lag of the motors whose final interval contains zero, though the regression before it resolved the lag.
    pub(super) fn without_zero_lag(mut self) -> Self {
        if self.motor_lag_s().is_none() {
            let lag = self.motor_lag_estimate_s();
            self.refused.extend(lag.map(Refusal::MotorLagUnresolved));
        }
        self
    }

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
