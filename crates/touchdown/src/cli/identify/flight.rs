//! `touchdown identify ground-effect` from flights: logs with specific force in place of thrust.

use std::fmt::Write as _;

use serde::Serialize;
use touchdown::identify::flight::result::FlightResult;
use touchdown::identify::flight::{Flight, ground_effect, with_thrust};
use touchdown::identify::settings::GroundEffectForm;
use touchdown::identify::{IdentificationSettings, Made};
use touchdown::pages;
use touchdown::progress::Progress as _;
use touchdown::{Error, Result};
use touchdown_log::Map;
use touchdown_trial::Trial;

use super::load::Log;
use super::show::{Fitted, Outcome, Summary};
use super::{Command, Target, done, origin, write_tables};
use crate::cli::Done;
use crate::cli::args::IdentifyCommon;
use crate::cli::context::Context;

/// Whether a log is one of a flight: it has specific force, and no thrust.
pub(super) fn is_flight(log: &Log) -> bool {
    log.trial.channel("thrust_n").is_none() && log.trial.channel("specific_force_mps2").is_some()
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

/// The object that is printed, with what flights say.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    fitted: &'a Outcome,
    flight: &'a FlightResult,
}

/// The numbers of the model, a line each.
fn numbers(result: &FlightResult) -> String {
    let mut out = format!(
        "{} curve, intervals from {} {}\n",
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
    out
}

pub(super) fn run(
    context: &Context,
    common: &IdentifyCommon,
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
    let found = ground_effect(&flights, &settings.flight)?;
    let recorded: Vec<Trial> = logs.iter().map(|l| l.trial.clone()).collect();
    let mut origin = origin(&recorded, map, common, &settings)?;
    let command = Command {
        what: "ground-effect",
        common,
        more: Vec::new(),
    };
    let out = common
        .out
        .as_ref()
        .map_or_else(|| "CARD.toml".to_string(), |o| o.display().to_string());
    origin.provenance.command = Some(command.text(&common.logs, &out));
    let made = found.card(&settings, &origin);
    let thrust = found.thrust_card(&settings, &origin);
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
    for log in logs {
        let name = log.path.display();
        fitted
            .warnings
            .extend(log.warnings().iter().map(|w| format!("{name}: {w}")));
    }
    if thrust.is_none() {
        fitted.warnings.push(
            "no thrust card: it needs the mass ([flight] mass_kg) and the motors' lag (throttle logged fast enough)".into(),
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
            let cards: Vec<&Made> = std::iter::once(&made).chain(&thrust).collect();
            let figures = pages::identify::flight_figures(&flights, &found, &result);
            let report = pages::identify::flight_report(&overview, &result, &cards, &figures)?;
            for (name, made) in [
                ("ground-effect.toml", Some(&made)),
                ("thrust.toml", thrust.as_ref()),
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
