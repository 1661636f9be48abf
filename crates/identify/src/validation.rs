//! One card on one trial, in free run: what `touchdown validate` and the Python package report.

use touchdown_model::Card;
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::flights::FlightSettings;
use crate::flights::judge::{FlightCards, Held, IntervalFactors, judge};
use crate::rig::{self as ground_effect, GroundTrial};
use crate::scores::Errors;
use crate::thrust;

/// A free run with its errors (N).
#[derive(Clone, Debug)]
pub struct FreeRun {
    /// Stamps (s).
    pub time_s: Vec<f64>,
    /// Measured force (N).
    pub measured_n: Vec<f64>,
    /// True force (N), where the log is of the virtual rig.
    pub truth_n: Option<Vec<f64>>,
    /// Predicted force (N).
    pub predicted_n: Vec<f64>,
    /// Against the measurement.
    pub measured: Errors,
    /// Against the truth.
    pub truth: Option<Errors>,
    /// The measurement against the truth.
    pub noise_floor: Option<Errors>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Scale and height offset of each armed interval, where the log is one of a flight.
    pub intervals: Vec<IntervalFactors>,
}

/// Share of a range by which an input may leave the card's validity box without a warning.
const SLACK: f64 = 0.01;

/// A thrust card on the trial of a stand.
///
/// # Errors
/// Channels that the card needs and the trial lacks, or no row with a measurement and a prediction.
pub fn judge_thrust(card: &Card, trial: &Trial) -> Result<FreeRun> {
    let predicted = thrust::predict(card, trial)?;
    let measured = trial.require("thrust_n")?;
    let noise_floor = trial
        .channel("truth_thrust_n")
        .and_then(|truth| Errors::of(measured, truth));
    let throttle = thrust::throttle(trial)?;
    let mut warnings = leaves_box(card, "s", "throttle", &throttle);
    let gaps = predicted.iter().filter(|p| p.is_nan()).count();
    if gaps > 0 {
        warnings.push(format!(
            "{gaps} of {} rows have a gap in an input; they do not enter the errors",
            trial.len()
        ));
    }
    finish(
        trial.name(),
        trial.time_s().to_vec(),
        measured.to_vec(),
        trial.channel("truth_free_air_n").map(<[f64]>::to_vec),
        predicted,
        noise_floor,
        warnings,
    )
}

/// A ground-effect card on a prepared trial of a force rig; `trial` is the whole one.
///
/// # Errors
/// As of [`judge_thrust`].
pub fn judge_ground(card: &Card, ground: &GroundTrial, trial: &Trial) -> Result<FreeRun> {
    let noise_floor = match (trial.channel("thrust_n"), trial.channel("truth_thrust_n")) {
        (Some(measured), Some(truth)) => Errors::of(measured, truth),
        _ => None,
    };
    let mut warnings = leaves_box(card, "z", "height", &ground.height_m);
    warnings.extend(leaves_box(card, "s", "throttle", &ground.throttle));
    // A prepared trial has no gaps: what is no number is a run that has left all bounds.
    let predicted = ground_effect::predict(card, ground)?.into_iter();
    let predicted = predicted.map(|f| if f.is_nan() { f64::INFINITY } else { f });
    finish(
        &ground.name,
        ground.time_s.clone(),
        ground.force_n.clone(),
        ground.truth_n.clone(),
        predicted.collect(),
        noise_floor,
        warnings,
    )
}

/// A card on the log of a flight: by the specific force, in each armed interval.
///
/// # Errors
/// Those of [`judge`].
pub fn judge_flight(
    cards: &FlightCards<'_>,
    trial: &Trial,
    settings: &FlightSettings,
    held: Held,
) -> Result<FreeRun> {
    let flight = judge(trial, cards, settings, held)?;
    let judged: Vec<f64> = flight
        .throttle
        .iter()
        .zip(&flight.measured_n)
        .map(|(s, f)| if f.is_finite() { *s } else { f64::NAN })
        .collect();
    let mut warnings = leaves_box(cards.thrust, "s", "throttle", &judged);
    if let Some(card) = cards.ground_effect {
        // Above the box the model fades; below it nothing was identified.
        warnings.extend(leaves_box_below(card, "z", "height", &flight.height_m));
    }
    for interval in flight
        .intervals
        .iter()
        .filter(|i| i.height_offset_is_at_bound)
    {
        warnings.push(format!(
            "the height offset of armed interval {} is at its bound of {:.3} m: the card does not predict it, or its heights have \
             another zero; state it by --height-offset",
            interval.number,
            interval.height_offset_m.unwrap_or(f64::NAN)
        ));
    }
    let mut out = finish(
        trial.name(),
        flight.time_s,
        flight.measured_n,
        None,
        flight.predicted_n,
        None,
        warnings,
    )?;
    out.intervals = flight.intervals;
    Ok(out)
}

fn finish(
    name: &str,
    time_s: Vec<f64>,
    measured_n: Vec<f64>,
    truth_n: Option<Vec<f64>>,
    predicted_n: Vec<f64>,
    noise_floor: Option<Errors>,
    mut warnings: Vec<String>,
) -> Result<FreeRun> {
    // A gap in the inputs is a gap in the prediction: there is nothing to compare.
    let against = |reference: &[f64]| {
        let known = predicted_n
            .iter()
            .zip(reference)
            .map(|(p, r)| if p.is_nan() { f64::NAN } else { *r });
        Errors::of(&predicted_n, &known.collect::<Vec<_>>())
    };
    let measured = against(&measured_n)
        .ok_or_else(|| Error::data(name, "rows with a measurement and a prediction", "none"))?;
    if !measured.worst.is_finite() {
        warnings.push("the free run diverges".to_string());
    }
    Ok(FreeRun {
        truth: truth_n.as_deref().and_then(against),
        measured,
        noise_floor,
        time_s,
        measured_n,
        truth_n,
        predicted_n,
        warnings,
        intervals: Vec::new(),
    })
}

/// Warns if an input leaves the card's validity box.
fn leaves_box(card: &Card, symbol: &str, name: &str, values: &[f64]) -> Vec<String> {
    let range = card.validity.inputs.get(symbol);
    range.map_or_else(Vec::new, |range| leaves(*range, name, values))
}

/// The same, below alone.
fn leaves_box_below(card: &Card, symbol: &str, name: &str, values: &[f64]) -> Vec<String> {
    let range = card.validity.inputs.get(symbol);
    let within = |[lo, hi]: [f64; 2]| {
        let below: Vec<f64> = values.iter().map(|v| v.min(hi)).collect();
        leaves([lo, hi], name, &below)
    };
    range.map_or_else(Vec::new, |range| within(*range))
}

fn leaves([lo, hi]: [f64; 2], name: &str, values: &[f64]) -> Vec<String> {
    let known = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    );
    let slack = SLACK * (hi - lo);
    if low >= lo - slack && high <= hi + slack {
        return Vec::new();
    }
    vec![format!(
        "{name} of {low:.3} to {high:.3} is outside the card's validity box of {lo:.3} to {hi:.3}"
    )]
}
