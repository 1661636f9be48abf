//! Cards on trials, in free run.

use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;
use touchdown_identify::flights::FlightSettings;
use touchdown_identify::flights::judge::{FlightCards, Held, IntervalFactors};
use touchdown_identify::scores::Errors;
use touchdown_identify::validation::{FreeRun, judge_flight, judge_ground, judge_thrust};
use touchdown_identify::{Result, rig};
use touchdown_model::Kind;
use touchdown_trial::{Source, Trial as Recorded};

use super::card::Card;
use super::of_identify;
use super::trial::Trial;
use crate::error::{self, fault};
use crate::run;

/// The figures of one card on one trial.
#[derive(Serialize)]
struct Figures<'a> {
    /// Whether the card was fitted to this very file; null where the card or the trial does not say.
    seen: Option<bool>,
    measured: Errors,
    truth: Option<Errors>,
    noise_floor: Option<Errors>,
    warnings: &'a [String],
    armed_intervals: &'a [IntervalFactors],
}

/// Figures in JSON, stamps, measured and predicted force.
type Judged<'py> = (
    String,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

fn seen(card: &touchdown_model::Card, trial: &Recorded) -> Option<bool> {
    let Source::File { sha256, .. } = &trial.provenance().source else {
        return None;
    };
    let inputs = &card.provenance.inputs;
    (!inputs.is_empty()).then(|| inputs.iter().any(|input| input.sha256 == *sha256))
}

/// Judges as `touchdown validate` does.
fn judge(
    card: &touchdown_model::Card,
    free_air: Option<&touchdown_model::Card>,
    trial: &Recorded,
    vehicle: touchdown_log::Vehicle,
    held: Held,
) -> Result<FreeRun> {
    let ground = free_air.filter(|_| card.kind == Kind::GroundEffect);
    if trial.channel("thrust_n").is_none() {
        let settings = FlightSettings {
            mass_kg: vehicle.mass_kg,
            rotor_radius_m: vehicle.rotor_radius_m,
            ..FlightSettings::default()
        };
        let cards = FlightCards {
            thrust: ground.unwrap_or(card),
            ground_effect: ground.map(|_| card),
            rotors: vehicle.rotors,
        };
        return judge_flight(&cards, trial, &settings, held);
    }
    let Some(free_air) = ground else {
        return judge_thrust(card, trial);
    };
    let (whole, gaps) = rig::without_gaps(trial)?;
    let mut judged = judge_ground(card, &rig::prepare(&whole, free_air)?, trial)?;
    if gaps > 0 {
        judged.warnings.push(format!(
            "{gaps} of {} rows have a gap in a necessary channel and are not used",
            trial.len()
        ));
    }
    Ok(judged)
}

/// One card on one trial. A ground-effect card needs the card of the free-air thrust.
#[pyfunction]
#[pyo3(signature = (card, trial, thrust_card=None, scale=None, height_offset_m=None))]
pub(crate) fn validate<'py>(
    py: Python<'py>,
    card: &Card,
    trial: &Trial,
    thrust_card: Option<&Card>,
    scale: Option<f64>,
    height_offset_m: Option<f64>,
) -> PyResult<Judged<'py>> {
    let free_air = thrust_card.map(|c| c.card.clone());
    if card.card.kind == Kind::GroundEffect && free_air.is_none() {
        let expected = "the card of the free-air thrust";
        let message = format!("thrust: a ground-effect card needs {expected}");
        return Err(fault(message, "thrust", expected, "none"));
    }
    let seen = seen(&card.card, &trial.trial);
    let (card, trial, vehicle) = (card.card.clone(), trial.trial.clone(), trial.of.vehicle);
    let held = Held {
        scale,
        height_offset_m,
    };
    let judged = run::owned(py, None, move |_| {
        Ok(judge(&card, free_air.as_ref(), &trial, vehicle, held))
    })?;
    let judged = judged.map_err(|e| of_identify(&e))?;
    let figures = Figures {
        seen,
        measured: judged.measured,
        truth: judged.truth,
        noise_floor: judged.noise_floor,
        warnings: &judged.warnings,
        armed_intervals: &judged.intervals,
    };
    let json = serde_json::to_string(&figures).map_err(|e| error::settings("figures", &e))?;
    Ok((
        json,
        PyArray1::from_vec(py, judged.time_s),
        PyArray1::from_vec(py, judged.measured_n),
        PyArray1::from_vec(py, judged.predicted_n),
    ))
}
