//! Identification of thrust and ground effect.

use std::path::PathBuf;

use pyo3::prelude::*;
use serde::Serialize;
use touchdown_campaign::progress::Silent;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{
    Routed, ground_effect_by_routes, thrust_of_flights, with_thrust,
};
use touchdown_identify::forms::FormScore;
use touchdown_identify::rig::GroundTrial;
use touchdown_identify::rig::forms;
use touchdown_identify::rig::identifiability::examine_trials;
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, thrust};
use touchdown_model::card::Vehicle;
use touchdown_model::{Card as Model, Form};
use touchdown_pages::Error;
use touchdown_pages::identify::summary::{Fitted, Outcome};
use touchdown_pages::identify::{
    About, FlightFit, RigFit, Shown, ThrustFit, ThrustFits, flight_warnings,
};
use touchdown_pages::logs::{label, once};
use touchdown_trial::Trial as Recorded;

use super::card::Card;
use super::trial::Trial;
use super::{of_identify, of_page};
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
    let mut settings: IdentificationSettings = error::read("settings", settings_json)?;
    for trial in trials {
        let of_map = trial.of.vehicle;
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
            .map(|t| &t.of.description)
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

/// What was fitted: the card, what is to be known of the logs beside the card's warnings, and the report, if it is wanted.
struct Fit {
    made: FittedCard,
    of_logs: Vec<String>,
    shown: Option<Shown>,
}

/// Fits without the interpreter's lock, and writes the report.
fn answer(
    py: Python<'_>,
    report: Option<PathBuf>,
    fit: impl FnOnce() -> Result<Fit, Error> + Send + 'static,
) -> PyResult<(Card, String)> {
    let done = run::owned(py, None, move |_| {
        Ok((|| {
            let fit = fit()?;
            if let (Some(path), Some(shown)) = (report, &fit.shown) {
                shown.report.write(path).map_err(Error::from)?;
            }
            Ok::<_, Error>(fit)
        })())
    })?;
    let Fit { made, of_logs, .. } = done.map_err(|e| of_page(&e))?;
    let said = Said {
        rmse: made.rmse,
        rmse_unit: made.rmse_unit,
        rows_used: made.rows_used,
        lag_s: made.lag_s,
        forms: made.forms,
        warnings: [of_logs, made.card.warnings.clone()].concat(),
    };
    let said = serde_json::to_string(&said).map_err(|e| error::settings("fit", &e))?;
    Ok((Card { card: made.card }, said))
}

/// A fit as a report has it, and the call that makes it again.
fn outcome(
    what: &str,
    trials: &[Recorded],
    made: &FittedCard,
    flight: Option<&FlightResult>,
    warnings: &[String],
) -> (Outcome, String) {
    let names: Vec<PathBuf> = trials.iter().map(|t| t.name().into()).collect();
    let mut fitted = Fitted::of(label(&names), made, None, 0);
    fitted.flight = flight.cloned().map(Box::new);
    fitted.warnings.extend_from_slice(warnings);
    let listed: Vec<&str> = trials.iter().map(Recorded::name).collect();
    let call = format!(
        "touchdown.identify.{what}(...)  # trials: {}",
        listed.join(", ")
    );
    (Outcome::Fitted(fitted), call)
}

/// One thrust card from all trials: of stands where thrust was measured, else of flights.
#[pyfunction]
#[pyo3(signature = (trials, settings_json, report=None))]
pub(crate) fn identify_thrust(
    py: Python<'_>,
    trials: Vec<PyRef<'_, Trial>>,
    settings_json: &str,
    report: Option<PathBuf>,
) -> PyResult<(Card, String)> {
    let (mut trials, settings, origin) = task(&trials, settings_json)?;
    let wanted = report.is_some();
    answer(py, report, move || {
        let flights = are_flights(&trials);
        let mut of_logs = Vec::new();
        if flights {
            let mass_kg = settings.vehicle.mass_kg;
            for trial in &mut trials {
                *trial = with_thrust(trial, &settings.flight, mass_kg)?;
                // How thrust came from the log.
                let note = trial.provenance().notes.last();
                of_logs.extend(note.map(|note| format!("{}: {note}", trial.name())));
            }
        }
        let (made, flight) = if flights && settings.thrust.form.is_none() {
            let (made, flight) = thrust_of_flights(&trials, &settings, &origin)?;
            (made, Some(flight))
        } else {
            (thrust::fit(&trials, &settings, &origin)?, None)
        };
        let shown = wanted.then(|| {
            let (outcome, call) = outcome("thrust", &trials, &made, flight.as_ref(), &of_logs);
            let about = About {
                outcomes: &[outcome],
                command: &call,
                settings: &settings,
            };
            let fit = ThrustFit {
                name: &made.card.name,
                trials: &trials,
                made: &made,
                flight: flight.as_ref(),
            };
            ThrustFits(&[fit]).shown(&about, &Silent)
        });
        Ok(Fit {
            shown: shown.transpose()?,
            made,
            of_logs,
        })
    })
}

/// One ground-effect card from all trials: of force rigs with the card of the free-air thrust and a form, else of flights.
#[pyfunction]
#[pyo3(signature = (trials, thrust_card, form, settings_json, report=None))]
pub(crate) fn identify_ground_effect(
    py: Python<'_>,
    trials: Vec<PyRef<'_, Trial>>,
    thrust_card: Option<&Card>,
    form: &str,
    settings_json: &str,
    report: Option<PathBuf>,
) -> PyResult<(Card, String)> {
    let (trials, mut settings, mut origin) = task(&trials, settings_json)?;
    let free_air = thrust_card.map(|c| c.card.clone());
    let wanted = report.is_some();
    if are_flights(&trials) {
        return answer(py, report, move || {
            of_flights(&trials, free_air.as_ref(), &settings, &origin, wanted)
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
    let free_air = free_air.ok_or_else(|| {
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
    answer(py, report, move || {
        of_rig(&trials, &free_air, form, &settings, &origin, wanted)
    })
}

fn of_flights(
    trials: &[Recorded],
    free_air: Option<&Model>,
    settings: &IdentificationSettings,
    origin: &Origin,
    wanted: bool,
) -> Result<Fit, Error> {
    let seen: Vec<&Recorded> = trials.iter().collect();
    let Routed {
        flights,
        found,
        routes,
        warnings,
    } = ground_effect_by_routes(&seen, &settings.flight, free_air)?;
    let made = found.card(settings, origin).with_warnings(warnings);
    let shown = wanted.then(|| {
        let of_thrust = found.thrust_card(settings, origin);
        let mut result = found.result(&flights, &settings.flight);
        result.routes = routes;
        let notes = flights.iter().flat_map(|flight| {
            let notes = flight.notes.iter();
            notes.map(|note| (PathBuf::from(&flight.name), note.to_string()))
        });
        let all = flight_warnings(&result, free_air.is_some(), once(notes), of_thrust.as_ref());
        let (outcome, call) = outcome("ground_effect", trials, &made, Some(&result), &all);
        let about = About {
            outcomes: &[outcome],
            command: &call,
            settings,
        };
        let cards: Vec<&FittedCard> = std::iter::once(&made).chain(&of_thrust).collect();
        let fit = FlightFit {
            flights: &flights,
            found: &found,
            result: &result,
            cards: &cards,
        };
        fit.shown(&about)
    });
    Ok(Fit {
        shown: shown.transpose()?,
        made,
        of_logs: Vec::new(),
    })
}

fn of_rig(
    trials: &[Recorded],
    free_air: &Model,
    form: Form,
    settings: &IdentificationSettings,
    origin: &Origin,
    wanted: bool,
) -> Result<Fit, Error> {
    forms::check_thrust_card(free_air, settings.vehicle.rotors)?;
    let prepared = forms::prepare_all(&trials.iter().collect::<Vec<_>>(), free_air)?;
    let (prepared, gaps): (Vec<GroundTrial>, Vec<Option<String>>) = prepared.into_iter().unzip();
    let each = trials.iter().zip(gaps);
    let of_logs: Vec<String> = each
        .filter_map(|(trial, gaps)| Some(format!("{}: {}", trial.name(), gaps?)))
        .collect();
    let made = forms::fit_one(form, &prepared, settings, origin)?;
    let shown = wanted.then(|| {
        let before = examine_trials(&prepared, settings)?;
        let (outcome, call) = outcome("ground_effect", trials, &made, None, &of_logs);
        let about = About {
            outcomes: &[outcome],
            command: &call,
            settings,
        };
        let fit = RigFit {
            trials: &prepared,
            before: &before,
            cards: std::slice::from_ref(&made),
            levels: &[],
        };
        fit.shown(&about)
    });
    Ok(Fit {
        shown: shown.transpose()?,
        made,
        of_logs,
    })
}
