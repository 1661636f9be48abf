//! Identification of thrust and ground effect.

use pyo3::prelude::*;
use serde::Serialize;
use touchdown_identify::flights::{ground_effect_by_routes, thrust_of_flights, with_thrust};
use touchdown_identify::forms::FormScore;
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, Result, rig, thrust};
use touchdown_model::card::Vehicle;
use touchdown_model::{Form, Kind};
use touchdown_trial::Trial as Recorded;

use super::card::Card;
use super::of_identify;
use super::trial::Trial;
use crate::error::{self, fault};
use crate::run;

/// What a fit says beside its card.
#[derive(Serialize)]
struct Said {
    rmse: f64,
    rmse_unit: &'static str,
    rows_used: usize,
    lag_s: Option<f64>,
    forms: Vec<FormScore>,
    warnings: Vec<String>,
}

/// The logs with settings that know what the maps say of the vehicle.
fn task(
    trials: &[PyRef<'_, Trial>],
    settings_json: &str,
) -> PyResult<(Vec<Recorded>, IdentificationSettings, Origin)> {
    if trials.is_empty() {
        let expected = "at least one trial";
        return Err(fault(
            format!("trials: expected {expected}, found none"),
            "trials",
            expected,
            "none",
        ));
    }
    let mut settings: IdentificationSettings =
        serde_json::from_str(settings_json).map_err(|e| error::settings("settings", &e))?;
    for trial in trials {
        let of_map = trial.vehicle;
        settings = settings.of_vehicle(VehicleSettings {
            mass_kg: of_map.mass_kg,
            rotor_radius_m: of_map.rotor_radius_m,
            arm_m: of_map.arm_m,
            rotors: of_map.rotors,
            measured_rotors: of_map.measured_rotors,
        });
    }
    settings.check("settings").map_err(|e| of_identify(&e))?;
    let known = &settings.vehicle;
    let vehicle = Vehicle {
        name: trials
            .iter()
            .map(|t| &t.description)
            .find(|text| !text.is_empty())
            .cloned()
            .unwrap_or_default(),
        mass_kg: known.mass_kg,
        rotor_radius_m: known.rotor_radius_m,
        rotors: known.rotors,
        arm_m: known.arm_m,
    };
    let recorded: Vec<Recorded> = trials.iter().map(|t| t.trial.clone()).collect();
    let origin = Origin::of(&recorded, vehicle);
    Ok((recorded, settings, origin))
}

/// Whether nothing measured the thrust of these logs.
fn are_flights(trials: &[Recorded]) -> bool {
    trials.iter().all(|t| t.channel("thrust_n").is_none())
}

/// Fits without the interpreter's lock; the fit gives its card, and what is to be known of the logs beside the card's warnings.
fn answer(
    py: Python<'_>,
    fit: impl FnOnce() -> Result<(FittedCard, Vec<String>)> + Send + 'static,
) -> PyResult<(Card, String)> {
    let (fitted, of_logs) =
        run::owned(py, None, move |_| Ok(fit()))?.map_err(|e| of_identify(&e))?;
    let said = Said {
        rmse: fitted.rmse,
        rmse_unit: fitted.rmse_unit,
        rows_used: fitted.rows_used,
        lag_s: fitted.lag_s,
        forms: fitted.forms,
        warnings: [of_logs, fitted.card.warnings.clone()].concat(),
    };
    let said = serde_json::to_string(&said).map_err(|e| error::settings("fit", &e))?;
    Ok((Card { card: fitted.card }, said))
}

/// One thrust card from all trials: of stands where thrust was measured, else of flights.
#[pyfunction]
pub(crate) fn identify_thrust(
    py: Python<'_>,
    trials: Vec<PyRef<'_, Trial>>,
    settings_json: &str,
) -> PyResult<(Card, String)> {
    let (trials, settings, origin) = task(&trials, settings_json)?;
    answer(py, move || {
        if !are_flights(&trials) {
            return Ok((thrust::fit(&trials, &settings, &origin)?, Vec::new()));
        }
        let mass_kg = settings.vehicle.mass_kg;
        let flights = trials
            .iter()
            .map(|trial| with_thrust(trial, &settings.flight, mass_kg))
            .collect::<Result<Vec<_>>>()?;
        let made = match settings.thrust.form {
            Some(_) => thrust::fit(&flights, &settings, &origin)?,
            None => thrust_of_flights(&flights, &settings, &origin)?.0,
        };
        // How thrust came from each log.
        let said = flights.iter().filter_map(|trial| {
            let note = trial.provenance().notes.last()?;
            Some(format!("{}: {note}", trial.name()))
        });
        Ok((made, said.collect()))
    })
}

/// One ground-effect card from all trials: of force rigs with the card of the free-air thrust and a form, else of flights.
#[pyfunction]
#[pyo3(signature = (trials, thrust_card, form, settings_json))]
pub(crate) fn identify_ground_effect(
    py: Python<'_>,
    trials: Vec<PyRef<'_, Trial>>,
    thrust_card: Option<&Card>,
    form: &str,
    settings_json: &str,
) -> PyResult<(Card, String)> {
    let (trials, mut settings, mut origin) = task(&trials, settings_json)?;
    let free_air = thrust_card.map(|c| c.card.clone());
    if are_flights(&trials) {
        return answer(py, move || {
            let seen: Vec<&Recorded> = trials.iter().collect();
            let routed = ground_effect_by_routes(&seen, &settings.flight, free_air.as_ref())?;
            let made = routed.found.card(&settings, &origin);
            Ok((made.with_warnings(routed.warnings), Vec::new()))
        });
    }
    let names = Form::GROUND_EFFECT.map(Form::name).join(", ");
    let form = Form::ground_effect_named(form).ok_or_else(|| {
        fault(
            format!("form: expected one of {names}, found {form}"),
            "form",
            &names,
            form,
        )
    })?;
    let free_air = free_air
        .filter(|card| card.kind == Kind::Thrust)
        .ok_or_else(|| {
            let expected = "the card of the free-air thrust, which is subtracted";
            fault(
                format!("thrust: expected {expected}"),
                "thrust",
                expected,
                "none",
            )
        })?;
    let radius_m = &mut settings.ground_effect.rotor_radius_m;
    *radius_m = settings.vehicle.rotor_radius_m.unwrap_or(*radius_m);
    origin.vehicle.rotor_radius_m = Some(*radius_m);
    answer(py, move || {
        let prepared = trials
            .iter()
            .map(|trial| rig::prepare(&rig::without_gaps(trial)?.0, &free_air))
            .collect::<Result<Vec<_>>>()?;
        Ok((rig::fit(form, &prepared, &settings, &origin)?, Vec::new()))
    })
}
