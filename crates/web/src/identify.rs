//! Thrust and ground effect as model cards.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;
use touchdown_campaign::progress::Silent;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{
    Routed, ground_effect_by_routes, thrust_of_flights, with_thrust,
};
use touchdown_identify::forms::FormScore;
use touchdown_identify::rig::GroundTrial;
use touchdown_identify::rig::forms::{self, LEVEL_STEPS};
use touchdown_identify::rig::identifiability::examine_trials;
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{FittedCard, thrust};
use touchdown_model::{Card, Form};
use touchdown_pages::identify::summary::{Failed, Fitted, Outcome};
use touchdown_pages::identify::{
    About, FlightFit, RigFit, Shown, ThrustFit, ThrustFits, flight_warnings,
};
use touchdown_pages::logs::{label, once, word};
use touchdown_trial::Trial;

use crate::Stages;
use crate::logs::{Logs, file_name};
use crate::plot::Plot;
use crate::request::{Data, Error, Result};

/// The last stage.
const DRAWING: &str = "Drawing the report";

/// What an identification returns.
#[derive(Debug, Serialize)]
pub(crate) struct Identified {
    cards: Vec<Fit>,
    /// Forms that could not be fitted, with the reason.
    failed: Vec<[String; 2]>,
    /// What flights identify beside the cards: numbers, curve, routes, refusals.
    flight: Option<FlightResult>,
    /// The figures of the report, each with its panels.
    figures: Vec<Vec<Plot>>,
    /// The report of `touchdown identify`, an HTML page that needs nothing else.
    report: String,
    /// What a user should know of the logs.
    warnings: Vec<String>,
    rows_dropped: usize,
}

/// A card and how its fit went.
#[derive(Debug, Serialize)]
struct Fit {
    card: Card,
    /// The card as its file has it.
    toml: String,
    rmse: f64,
    rmse_unit: &'static str,
    rows_used: usize,
    lag_s: Option<f64>,
    forms: Vec<FormScore>,
}

impl Fit {
    fn of(made: FittedCard) -> Result<Self> {
        Ok(Self {
            toml: made.card.to_toml()?,
            rmse: made.rmse,
            rmse_unit: made.rmse_unit,
            rows_used: made.rows_used,
            lag_s: made.lag_s,
            forms: made.forms,
            card: made.card,
        })
    }
}

impl Logs {
    /// A fit as the report has it; `warnings` stand beside those of the fit.
    fn outcome(
        &self,
        made: &FittedCard,
        flight: Option<&FlightResult>,
        warnings: &[String],
    ) -> Outcome {
        let mut fitted = Fitted::of(label(&self.names), made, None, self.rows_dropped());
        fitted.flight = flight.cloned().map(Box::new);
        fitted.warnings.extend_from_slice(warnings);
        Outcome::Fitted(fitted)
    }

    fn identified(
        &self,
        cards: Vec<FittedCard>,
        flight: Option<FlightResult>,
        shown: &Shown,
        warnings: Vec<String>,
    ) -> Result<Identified> {
        Ok(Identified {
            cards: cards.into_iter().map(Fit::of).collect::<Result<_>>()?,
            failed: Vec::new(),
            flight,
            figures: shown.figures.iter().map(Plot::panels).collect(),
            report: shown.report.html(),
            warnings,
            rows_dropped: self.rows_dropped(),
        })
    }
}

/// The command that makes the same report. The lab's map and settings stand in files of these names.
fn command(what: &str, data: &Data, thrust: bool) -> String {
    let mut words = vec![format!("touchdown identify {what}")];
    words.extend(data.logs.iter().map(|path| word(&file_name(path))));
    words.extend(data.map.is_some().then(|| "--map map.toml".to_string()));
    if !data.settings.trim().is_empty() || data.vehicle != VehicleSettings::default() {
        words.push("--settings settings.toml".to_string());
    }
    words.extend(thrust.then(|| "--thrust thrust.toml".to_string()));
    words.push("--out results".to_string());
    words.join(" ")
}

/// Passes on how many of some steps are done.
fn counted<'a>(stages: Stages<'a>, what: &'a str, of: usize) -> impl Fn() + Sync + 'a {
    let done = AtomicUsize::new(0);
    let say = move |done: usize| stages(&format!("{what} ({done} of {of} done)"));
    say(0);
    move || say(done.fetch_add(1, Ordering::Relaxed) + 1)
}

/// The thrust card of logs of a stand, a rig or flights.
pub(crate) fn thrust(data: &Data, stages: Stages<'_>) -> Result<Identified> {
    let mut logs = Logs::read(data, stages)?;
    stages("Fitting the thrust");
    let flights = logs.are_flights();
    if flights {
        for trial in &mut logs.trials {
            *trial = with_thrust(trial, &logs.settings.flight, None)?;
        }
    }
    let origin = logs.origin(data)?;
    let (mut made, flight) = if flights && logs.settings.thrust.form.is_none() {
        let (made, flight) = thrust_of_flights(&logs.trials, &logs.settings, &origin)?;
        (made, Some(flight))
    } else {
        (thrust::fit(&logs.trials, &logs.settings, &origin)?, None)
    };
    if let [one] = &logs.trials[..] {
        made.card.name = one.name().to_string();
    }
    let of_logs = logs.warnings_by_log();
    let warnings = match logs.names.len() {
        1 => of_logs.into_iter().map(|(_, warning)| warning).collect(),
        _ => once(of_logs),
    };
    let outcomes = [logs.outcome(&made, flight.as_ref(), &warnings)];
    let about = About {
        outcomes: &outcomes,
        command: &command("thrust", data, false),
        settings: &logs.settings,
    };
    let fit = ThrustFit {
        name: &made.card.name,
        trials: &logs.trials,
        made: &made,
        flight: flight.as_ref(),
    };
    stages(DRAWING);
    let shown = ThrustFits(&[fit]).shown(&about, &Silent)?;
    logs.identified(vec![made], flight, &shown, warnings)
}

/// The ground effect of flights, or of a force rig with the thrust card of its vehicle.
pub(crate) fn ground_effect(
    data: &Data,
    thrust: Option<&str>,
    stages: Stages<'_>,
) -> Result<Identified> {
    let logs = Logs::read(data, stages)?;
    let card = thrust
        .map(|text| Card::parse(text, "the thrust card"))
        .transpose()?;
    if logs.are_flights() {
        of_flights(&logs, data, card.as_ref(), stages)
    } else {
        let card = card.ok_or_else(|| {
            Error::Data(
                "expected a thrust card, found none: the logs have the channel `thrust_n`, and the card gives the thrust out \
                 of ground effect that is subtracted. Identify the thrust first."
                    .to_string(),
            )
        })?;
        of_rig(&logs, data, &card, stages)
    }
}

fn of_flights(
    logs: &Logs,
    data: &Data,
    thrust: Option<&Card>,
    stages: Stages<'_>,
) -> Result<Identified> {
    let settings = &logs.settings;
    let trials: Vec<&Trial> = logs.trials.iter().collect();
    stages("Fitting the ground effect by each route");
    let Routed {
        flights,
        found,
        routes,
        warnings,
    } = ground_effect_by_routes(&trials, &settings.flight, thrust)?;
    let origin = logs.origin(data)?;
    let made = found.card(settings, &origin).with_warnings(warnings);
    let of_thrust = found.thrust_card(settings, &origin);
    let mut result = found.result(&flights, &settings.flight);
    result.routes = routes;
    let notes = logs.names.iter().zip(&flights).flat_map(|(name, flight)| {
        let notes = flight.notes.iter();
        notes.map(|note| (name.clone(), note.to_string()))
    });
    let of_logs = once(notes.chain(logs.warnings_by_log()));
    let warnings = flight_warnings(&result, thrust.is_some(), of_logs, of_thrust.as_ref());
    let outcomes = [logs.outcome(&made, Some(&result), &warnings)];
    let cards: Vec<FittedCard> = std::iter::once(made).chain(of_thrust).collect();
    let about = About {
        outcomes: &outcomes,
        command: &command("ground-effect", data, thrust.is_some()),
        settings,
    };
    let fit = FlightFit {
        flights: &flights,
        found: &found,
        result: &result,
        cards: &cards.iter().collect::<Vec<_>>(),
    };
    stages(DRAWING);
    let shown = fit.shown(&about)?;
    logs.identified(cards, Some(result), &shown, warnings)
}

fn of_rig(logs: &Logs, data: &Data, thrust: &Card, stages: Stages<'_>) -> Result<Identified> {
    let mut settings = logs.settings.clone();
    let radius_m = &mut settings.ground_effect.rotor_radius_m;
    *radius_m = settings.vehicle.rotor_radius_m.unwrap_or(*radius_m);
    forms::check_thrust_card(thrust, settings.vehicle.rotors)?;
    let prepared = forms::prepare_all(&logs.trials.iter().collect::<Vec<_>>(), thrust)?;
    let mut warnings = Vec::new();
    let mut trials: Vec<GroundTrial> = Vec::new();
    for (trial, gap) in prepared {
        warnings.extend(gap.map(|gap| format!("{}: {gap}", trial.name)));
        trials.push(trial);
    }
    warnings.extend(once(logs.warnings_by_log()));
    let before = examine_trials(&trials, &settings)?;
    warnings.extend(before.advice.iter().map(ToString::to_string));
    let mut origin = logs.origin(data)?;
    origin.vehicle.rotor_radius_m = Some(settings.ground_effect.rotor_radius_m);
    let each = counted(stages, "Fitting forms", Form::GROUND_EFFECT.len());
    let of_form = |_| origin.clone();
    let fits = forms::fit_forms(&Form::GROUND_EFFECT, &trials, &settings, of_form, each);
    let failed: Vec<[String; 2]> = fits
        .failed
        .iter()
        .map(|(form, why)| [form.name().to_string(), why.to_string()])
        .collect();
    if fits.cards.is_empty() {
        let reasons: Vec<String> = failed.iter().map(|why| why.join(": ")).collect();
        return Err(Error::Data(format!(
            "no form could be fitted: {}",
            reasons.join("; ")
        )));
    }
    let each = counted(
        stages,
        "Fitting without held-out logs",
        LEVEL_STEPS as usize,
    );
    let levels = forms::held_out_levels(&trials, &settings, &origin, each);
    let without = levels
        .as_ref()
        .err()
        .map(|e| format!("the comparison of the levels failed: {e}"));
    let fitted = fits
        .cards
        .iter()
        .map(|made| logs.outcome(made, None, &warnings));
    let failures = fits
        .failed
        .iter()
        .map(|(form, why)| Outcome::Failed(Failed::of(label(&logs.names), Some(form.name()), why)));
    let outcomes: Vec<Outcome> = fitted.chain(failures).collect();
    let about = About {
        outcomes: &outcomes,
        command: &command("ground-effect", data, true),
        settings: &settings,
    };
    let fit = RigFit {
        trials: &trials,
        before: &before,
        cards: &fits.cards,
        levels: levels.as_deref().unwrap_or_default(),
    };
    stages(DRAWING);
    let shown = fit.shown(&about)?;
    warnings.extend(without);
    let identified = logs.identified(fits.cards, None, &shown, warnings)?;
    Ok(Identified {
        failed,
        ..identified
    })
}
