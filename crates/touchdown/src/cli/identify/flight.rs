//! `touchdown identify ground-effect` from flights: logs with specific force in place of thrust.

use std::fmt::Write as _;
use std::path::Path;

use touchdown::pages;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::flights::armed_intervals::ArmedIntervalResult;
use touchdown_identify::flights::hover::ThrustLaw;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{Basis, Flight, ground_effect_with, thrust_alone, with_thrust};
use touchdown_identify::warning::{Warning, sentences};
use touchdown_identify::{FittedCard, IdentificationSettings, Origin};
use touchdown_log::Map;
use touchdown_trial::Trial;

use super::load::{self, Log, word};
use super::show::{Fitted, Outcome, Summary};
use super::{Command, Target, done, ground, origin, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use touchdown_terminal::Done;

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

/// The thrust card of flights that have thrust by [`thrust_of_flight`], and what they say beside it.
pub(super) fn thrust(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<(FittedCard, FlightResult)> {
    let flights: Vec<Flight> = trials
        .iter()
        .map(|trial| Ok(Flight::of(trial, &settings.flight)?))
        .collect::<Result<_>>()?;
    let found = thrust_alone(&flights, &settings.flight)?;
    let mut made = found.thrust_of(settings, origin).ok_or_else(|| {
        Error::Arguments("thrust from flight needs the mass and the specific force".to_string())
    })?;
    let refused = found.refused.iter().map(ToString::to_string);
    made.warnings.extend(refused.map(Warning::NotIdentified));
    let notes = flights.iter().flat_map(|f| f.notes.iter().cloned());
    made.warnings.extend(notes.map(Warning::Log));
    made.card.warnings = sentences(&made.warnings);
    Ok((made, found.result(&flights, &settings.flight)))
}

/// Hovers and runs that are printed at most.
const SHOWN: usize = 12;

/// What flights say: the numbers of the model, its runs and hovers, a line each.
pub(super) fn told(result: &FlightResult) -> String {
    let mut out = format!(
        "from {}: {} curve, intervals from {} {}\n",
        result.basis.name(),
        result.curve,
        result.blocks,
        result.intervals_from.name()
    );
    for n in &result.numbers {
        let [low, high] = n.estimate.ci95;
        let _ = writeln!(
            out,
            "  {:<14} {:>9.4} {:<4} 95 % interval {low:.4} to {high:.4}",
            n.words(),
            n.estimate.value,
            n.unit
        );
    }
    if let Some(lift) = &result.extra_lift {
        let _ = writeln!(out, "  {lift}");
    }
    out += &runs(&result.runs);
    let lines = result.hovers.iter().map(|h| {
        format!(
            "hover at {:.3} m: {:.4} of the thrust out of ground effect ({}, {:.1} to {:.1} s)",
            h.height_m, h.ratio, h.log, h.from_s, h.to_s
        )
    });
    listed(&mut out, lines, "hovers");
    let refused: Vec<&str> = result.refused.iter().map(|r| r.what.as_str()).collect();
    if !refused.is_empty() {
        let _ = writeln!(out, "  not identified: {}", refused.join("; "));
    }
    out
}

/// Every run of the motors, a line each.
pub(super) fn runs(runs: &[ArmedIntervalResult]) -> String {
    let mut out = String::new();
    listed(&mut out, runs.iter().map(ToString::to_string), "runs");
    out
}

/// The first lines, and how many more there are.
fn listed(out: &mut String, lines: impl ExactSizeIterator<Item = String>, what: &str) {
    let more = lines.len().saturating_sub(SHOWN);
    for line in lines.take(SHOWN) {
        let _ = writeln!(out, "  {line}");
    }
    if more > 0 {
        let _ = writeln!(out, "  and {more} {what} more, in the report and in --json");
    }
}

pub(super) fn run(
    context: &Context,
    common: &IdentifyCommon,
    thrust: Option<&Path>,
    settings: &IdentificationSettings,
    map: Option<&Map>,
    logs: &[Log],
    target: &Target,
) -> Result<Done> {
    let mut settings = settings.clone();
    settings.flight.mass_kg = settings.flight.mass_kg.or(map.and_then(Map::mass_kg));
    context.stage("fitting", 1);
    let flights: Vec<Flight> = logs
        .iter()
        .map(|log| Ok(Flight::of(&log.trial, &settings.flight)?))
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
        origin.provenance.inputs.push(load::input(path)?);
    }
    let made = found.card(&settings, &origin);
    let of_thrust = found.thrust_card(&settings, &origin);
    let result = found.result(&flights, &settings.flight);
    context.step();

    let path = match target {
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
    if card.is_some()
        && !matches!(
            found.basis,
            Basis::Hovers {
                law: ThrustLaw::Card,
                ..
            }
        )
    {
        let why = "the card of --thrust was not used: the logs have the specific force, or one from poses";
        fitted.warnings.push(why.into());
    }
    let said = logs.iter().zip(&flights).flat_map(|(log, flight)| {
        let notes = flight.notes.iter().map(|n| (log.path.clone(), n.clone()));
        notes.chain(log.said()).collect::<Vec<_>>()
    });
    fitted.warnings.extend(load::once(said));
    match &of_thrust {
        Some(made) => fitted
            .warnings
            .extend(made.warnings.iter().map(|w| format!("thrust card: {w}"))),
        None => fitted.warnings.push(
            "no thrust card: it needs the mass ([flight] mass_kg), the accelerometer and the motors' lag (throttle logged \
             fast enough)"
                .into(),
        ),
    }
    for warning in &fitted.warnings {
        context.warn(warning);
    }
    fitted.flight = Some(Box::new(result.clone()));
    let outcome = Outcome::Fitted(fitted);
    let summary = Summary::of(std::slice::from_ref(&outcome));
    match target {
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
            let cards: Vec<&FittedCard> = std::iter::once(&made).chain(&of_thrust).collect();
            let figures = pages::identify::flight_figures(&flights, &found, &result);
            let report = pages::identify::flight_report(&overview, &result, &cards, &figures)?;
            for (name, made) in [
                ("ground-effect.toml", Some(&made)),
                ("thrust.toml", of_thrust.as_ref()),
            ] {
                let path = folder.join(name);
                match made {
                    Some(made) => made.card.write(&path)?,
                    // A card of other flights beside this one would fly with it.
                    None if path.exists() => {
                        std::fs::remove_file(&path).map_err(|e| Error::file(&path, e))?;
                        context.warn(&format!(
                            "{} is gone: it was of an earlier run",
                            path.display()
                        ));
                    }
                    None => {}
                }
            }
            pages::identify::write(folder, &figures, &report)?;
            write_tables(folder, &outcome, &summary, &settings)?;
        }
    }
    context.finish();
    context.object(&outcome);
    context.say(&format!("{}\n{}", summary.text(), told(&result).trim_end()));
    Ok(done(logs.iter().any(|l| l.findings.is_lossy())))
}
