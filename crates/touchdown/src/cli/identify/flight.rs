//! `touchdown identify ground-effect` from flights: logs with specific force in place of thrust.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use touchdown::identify::flight::hover::Law;
use touchdown::identify::flight::result::FlightResult;
use touchdown::identify::flight::{Basis, Flight, ground_effect_with, thrust_alone, with_thrust};
use touchdown::identify::settings::GroundEffectForm;
use touchdown::identify::{IdentificationSettings, Made, Origin};
use touchdown::pages;
use touchdown::progress::Progress as _;
use touchdown::{Error, Result};
use touchdown_log::Map;
use touchdown_model::card::Input;
use touchdown_trial::Trial;

use super::load::{self, Log, word};
use super::show::{Fitted, Outcome, Summary};
use super::{Command, Target, done, ground, origin, write_tables};
use crate::cli::Done;
use crate::cli::args::IdentifyCommon;
use crate::cli::context::Context;

/// Whether a log is one of a flight: nothing measured its thrust.
pub(super) fn is_flight(log: &Log) -> bool {
    log.trial.channel("thrust_n").is_none()
}

/// The log of a flight with thrust from mass and specific force; another log as it is.
pub(super) fn thrust_of_flight(
    mut log: Log,
    settings: &IdentificationSettings,
    map: Option<&Map>,
) -> Result<Log> {
    if is_flight(&log) {
        log.trial = with_thrust(&log.trial, &settings.flight, map.and_then(Map::mass_kg))?;
        if let Some(note) = log.trial.provenance().notes.last() {
            log.findings.warnings.push(note.clone());
        }
    }
    Ok(log)
}

/// The thrust card of flights that have thrust by [`thrust_of_flight`].
pub(super) fn thrust(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<Made> {
    let flights: Vec<Flight> = trials
        .iter()
        .map(|trial| Flight::of(trial, &settings.flight))
        .collect::<Result<_>>()?;
    let found = thrust_alone(&flights, &settings.flight)?;
    let mut made = found.thrust_of(settings, origin).ok_or_else(|| {
        Error::Arguments("thrust from flight needs the mass and the specific force".to_string())
    })?;
    made.warnings.extend(found.refused.iter().map(|r| {
        format!(
            "{} not identified: {}; record {}",
            r.what, r.found, r.record
        )
    }));
    made.warnings
        .extend(flights.iter().flat_map(|f| f.notes.iter().cloned()));
    made.card.warnings.clone_from(&made.warnings);
    Ok(made)
}

/// The object that is printed, with what flights say.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    fitted: &'a Outcome,
    flight: &'a FlightResult,
}

/// Hovers that are printed at most.
const SHOWN: usize = 12;

/// The numbers of the model, a line each.
fn numbers(result: &FlightResult) -> String {
    let mut out = format!(
        "from {}: {} curve, intervals from {} {}\n",
        result.basis.name(),
        result.curve,
        result.blocks,
        result.intervals_from.name()
    );
    for n in &result.numbers {
        let [low, high] = n.sure.ci95;
        let _ = writeln!(
            out,
            "  {:<14} {:>9.4} {:<4} 95 % interval {low:.4} to {high:.4}",
            n.name.replace('_', " "),
            n.sure.value,
            n.unit
        );
    }
    for h in result.hovers.iter().take(SHOWN) {
        let _ = writeln!(
            out,
            "  hover at {:.3} m: {:.4} of the thrust out of ground effect ({}, {:.1} to {:.1} s)",
            h.height_m, h.ratio, h.log, h.from_s, h.to_s
        );
    }
    if result.hovers.len() > SHOWN {
        let more = result.hovers.len() - SHOWN;
        let _ = writeln!(out, "  and {more} hovers more, in the report and in --json");
    }
    for r in &result.refused {
        let _ = writeln!(
            out,
            "  not identified: {}: {}; record {}",
            r.what, r.found, r.record
        );
    }
    out
}

pub(super) fn run(
    context: &Context,
    common: &IdentifyCommon,
    thrust: Option<&Path>,
    forms: &[GroundEffectForm],
    settings: &IdentificationSettings,
    map: Option<&Map>,
    logs: &[Log],
) -> Result<Done> {
    if let Some(form) = forms.first() {
        return Err(Error::Arguments(format!(
            "--form {}: the form follows from the data where logs are of flights (no channel `thrust_n`)",
            form.name()
        )));
    }
    let target = Target::of(common.out.as_deref())?;
    let mut settings = settings.clone();
    settings.flight.mass_kg = settings.flight.mass_kg.or(map.and_then(Map::mass_kg));
    context.stage("fitting", 1);
    let flights: Vec<Flight> = logs
        .iter()
        .map(|log| Flight::of(&log.trial, &settings.flight))
        .collect::<Result<_>>()?;
    let card = thrust.map(ground::thrust_card).transpose()?;
    let found = ground_effect_with(&flights, &settings.flight, card.as_ref())?;
    let recorded: Vec<Trial> = logs.iter().map(|l| l.trial.clone()).collect();
    let mut origin = origin(&recorded, map, common, &settings)?;
    let command = Command {
        what: "ground-effect",
        common,
        more: thrust.map_or_else(Vec::new, |card| {
            vec!["--thrust".into(), word(&card.display().to_string())]
        }),
    };
    let out = common
        .out
        .as_ref()
        .map_or_else(|| "CARD.toml".to_string(), |o| o.display().to_string());
    origin.provenance.command = Some(command.text(&common.logs, &out));
    if let Some(path) = thrust {
        let bytes = std::fs::read(path).map_err(|e| Error::file(path, e))?;
        origin.provenance.inputs.push(Input {
            name: load::file_name(path),
            sha256: touchdown::identify::sha256(&bytes),
        });
    }
    let made = found.card(&settings, &origin);
    let of_thrust = found.thrust_card(&settings, &origin);
    let result = found.result(&flights);
    context.step();

    let path = match &target {
        Target::None => None,
        Target::File(card) => Some(card.clone()),
        Target::Folder(folder) => Some(folder.join("ground-effect.toml")),
    };
    let label = match logs {
        [one] => one.path.display().to_string(),
        many => format!("{} logs together", many.len()),
    };
    let dropped = logs.iter().map(|l| l.findings.rows_dropped()).sum();
    let mut fitted = Fitted::of(label, &made, path.as_deref(), dropped);
    if card.is_some() && !matches!(found.basis, Basis::Hovers { law: Law::Card, .. }) {
        let why = "the card of --thrust was not used: the logs have the specific force, or one from poses";
        fitted.warnings.push(why.into());
    }
    for (log, flight) in logs.iter().zip(&flights) {
        let name = log.path.display();
        fitted
            .warnings
            .extend(flight.notes.iter().map(|w| format!("{name}: {w}")));
        fitted
            .warnings
            .extend(log.warnings().iter().map(|w| format!("{name}: {w}")));
    }
    if of_thrust.is_none() {
        fitted.warnings.push(
            "no thrust card: it needs the mass ([flight] mass_kg), the accelerometer and the motors' lag (throttle logged fast \
             enough)"
                .into(),
        );
    }
    for warning in &fitted.warnings {
        context.warn(warning);
    }
    let outcome = Outcome::Fitted(fitted);
    let summary = Summary::of(std::slice::from_ref(&outcome));
    let printed = Printed {
        fitted: &outcome,
        flight: &result,
    };
    match &target {
        Target::None => {}
        Target::File(card) => made.card.write(card)?,
        Target::Folder(folder) => {
            context.stage("drawing", 1);
            let overview = pages::identify::Overview {
                title: "Ground effect from flights",
                command: &command.text(&common.logs, &folder.display().to_string()),
                header: summary.header(),
                rows: summary.rows(),
            };
            let cards: Vec<&Made> = std::iter::once(&made).chain(&of_thrust).collect();
            let figures = pages::identify::flight_figures(&flights, &found, &result);
            let report = pages::identify::flight_report(&overview, &result, &cards, &figures)?;
            for (name, made) in [
                ("ground-effect.toml", Some(&made)),
                ("thrust.toml", of_thrust.as_ref()),
            ] {
                if let Some(made) = made {
                    made.card.write(&folder.join(name))?;
                }
            }
            pages::identify::write(folder, &figures, &report)?;
            write_tables(folder, &printed, &summary, &settings)?;
        }
    }
    context.finish();
    context.object(&printed)?;
    context.say(&format!("{}{}", summary.text(), numbers(&result)));
    Ok(done(logs.iter().any(|l| l.findings.is_lossy())))
}
