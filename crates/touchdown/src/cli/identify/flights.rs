//! `touchdown identify ground-effect` from flights: logs without measured thrust.

use std::fmt::Write as _;
use std::path::Path;

use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::flights::Route;
use touchdown_identify::flights::armed_interval_result::ArmedIntervalResult;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{Flight, Refusal, Routed, ground_effect_by_routes, with_thrust};
use touchdown_identify::{FittedCard, IdentificationSettings};
use touchdown_log::Map;
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::load::{self, Log, word};
use super::show;
use super::{Command, Target, origin, write_card, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_pages::identify::summary::{Fitted, Outcome, Summary};
use touchdown_pages::identify::{About, FlightFit, Shown, flight_warnings};
use touchdown_terminal::Done;

/// Whether a log is one of a flight: nothing measured its thrust.
pub(crate) fn is_flight(log: &Log) -> bool {
    log.trial.channel("thrust_n").is_none()
}

/// The log of a flight with thrust from mass and specific force; another log as it is.
pub(super) fn thrust_of_flight(
    mut log: Log,
    settings: &IdentificationSettings,
    map: Option<&Map>,
) -> Result<Log> {
    if is_flight(&log) {
        let mass_kg = map.and_then(Map::mass_kg);
        log.trial = match with_thrust(&log.trial, &settings.flight, mass_kg) {
            Ok(trial) => trial,
            Err(error) => return Err(other_name(&log, map).unwrap_or(error.into())),
        };
        if let Some(note) = log.trial.provenance().notes.last() {
            log.findings.warnings.push(note.clone());
        }
    }
    Ok(log)
}

/// The refusal of a stand's table whose thrust has a name that is not ours: it is no flight, and needs a map.
fn other_name(log: &Log, map: Option<&Map>) -> Option<Error> {
    let (seen, _) = match map {
        None => touchdown_log::inspect_file(&log.path).ok()?,
        Some(_) => return None,
    };
    let path = log.path.display();
    let suggested = seen.suggested_map?;
    let find = |start: &str| suggested.lines().find(|line| line.starts_with(start));
    let Some(line) = find("thrust_n = ") else {
        find("# thrust_n = ")?;
        return Some(Error::Arguments(format!(
            "{path}: no column is `thrust_n`, but several look like it. `touchdown inspect {path}` prints a map with a line for each \
             choice: save it, remove the # of one line, and pass it with --map"
        )));
    };
    let line = line.split("  #").next()?;
    Some(Error::Arguments(format!(
        "{path}: no column is `thrust_n`, but one looks like it. `touchdown inspect {path}` prints a map with {line}: save it, and \
         pass it with --map"
    )))
}

/// Hovers and armed intervals that are printed at most.
const SHOWN: usize = 12;

/// The result for people: the numbers of the model, armed intervals and hovers, a line each.
pub(super) fn text(result: &FlightResult) -> String {
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
    if result.routes.len() > 1 {
        out += &routes(&result.routes);
    }
    out += &armed_intervals(&result.runs);
    let lines = result.hovers.iter().map(|h| {
        format!(
            "hover at {:.3} m: {:.4} of the thrust out of ground effect ({}, {:.1} to {:.1} s)",
            h.height_m, h.ratio, h.log, h.from_s, h.to_s
        )
    });
    listed(&mut out, lines, "hovers");
    let refused: Vec<&str> = result.refused.iter().map(Refusal::what).collect();
    if !refused.is_empty() {
        let _ = writeln!(out, "  not identified: {}", refused.join("; "));
    }
    out
}

/// The routes, a line each.
fn routes(routes: &[Route]) -> String {
    let mut out = String::new();
    for route in routes {
        let taken = if route.taken { " (taken)" } else { "" };
        let found = match &route.refused {
            Some(why) => format!("none: {why}"),
            None => route.numbers().join("; "),
        };
        let _ = writeln!(out, "  route by {}{taken}: {found}", route.basis.name());
    }
    out
}

/// The armed intervals, a line each.
pub(super) fn armed_intervals(runs: &[ArmedIntervalResult]) -> String {
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
    thrust: Option<(&Path, &Card)>,
    settings: &IdentificationSettings,
    map: Option<&Map>,
    logs: &[Log],
    target: &Target,
) -> Result<Done> {
    let mut settings = settings.clone();
    settings.flight.mass_kg = settings.flight.mass_kg.or(map.and_then(Map::mass_kg));
    context.stage("fitting", 1);
    let (thrust, thrust_card) = thrust.unzip();
    let trials: Vec<&Trial> = logs.iter().map(|log| &log.trial).collect();
    let Routed {
        flights,
        found: model,
        routes,
        warnings: differences,
    } = ground_effect_by_routes(&trials, &settings.flight, thrust_card)?;
    let mut origin = origin(&load::trials(logs), map, common, &settings)?;
    let out = common.out.as_deref().unwrap_or(Path::new("CARD.toml"));
    origin.provenance.command = Some(command(common, thrust, out));
    if let Some(path) = thrust {
        origin.provenance.inputs.push(load::input(path)?);
    }
    let cards = Cards {
        ground_effect: model.card(&settings, &origin).with_warnings(differences),
        thrust: model.thrust_card(&settings, &origin),
    };
    let mut result = model.result(&flights, &settings.flight);
    result.routes = routes;
    let result = result;
    context.step();

    let path = target.card(GROUND_EFFECT);
    let (label, dropped) = (load::label(&common.logs), load::rows_dropped(logs));
    let mut fitted = Fitted::of(label, &cards.ground_effect, path.as_deref(), dropped);
    let of_logs = warnings_of_logs(logs, &flights);
    let all = flight_warnings(&result, thrust.is_some(), of_logs, cards.thrust.as_ref());
    fitted.warnings.extend(all);
    for warning in &fitted.warnings {
        context.warn(warning);
    }
    fitted.flight = Some(Box::new(result.clone()));
    let outcome = Outcome::Fitted(fitted);
    let summary = Summary::of(std::slice::from_ref(&outcome));
    match target {
        Target::None => {}
        Target::File(path) => write_card(context, path, &cards.ground_effect.card)?,
        Target::Folder(folder) => {
            context.stage("drawing", 1);
            let command = command(common, thrust, folder);
            let about = About {
                outcomes: std::slice::from_ref(&outcome),
                command: &command,
                settings: &settings,
            };
            let fit = FlightFit {
                flights: &flights,
                found: &model,
                result: &result,
                cards: &cards.all(),
            };
            let Shown { figures, report } = fit.shown(&about)?;
            output::results_folder(context, folder)?;
            cards.write(context, folder)?;
            touchdown_pages::page::write(folder, &figures, &report)?;
            write_tables(folder, &outcome, &summary, &settings)?;
        }
    }
    context.finish();
    context.object(&outcome);
    context.say(&format!(
        "{}\n{}",
        show::summary(&summary),
        text(&result).trim_end()
    ));
    Ok(Done::with_loss(load::lossy(logs)))
}

/// The command that makes the cards again.
fn command(common: &IdentifyCommon, thrust: Option<&Path>, out: &Path) -> String {
    let command = Command {
        what: "ground-effect",
        common,
        more: thrust.map_or_else(Vec::new, |card| {
            vec!["--thrust".into(), word(&card.display().to_string())]
        }),
    };
    command.text(&common.logs, &out.display().to_string())
}

/// Files of the cards in a folder.
const GROUND_EFFECT: &str = "ground-effect.toml";
const THRUST: &str = "thrust.toml";

/// The cards of one vehicle.
struct Cards {
    ground_effect: FittedCard,
    thrust: Option<FittedCard>,
}

impl Cards {
    fn all(&self) -> Vec<&FittedCard> {
        std::iter::once(&self.ground_effect)
            .chain(&self.thrust)
            .collect()
    }

    fn write(&self, context: &Context, folder: &Path) -> Result<()> {
        self.ground_effect.card.write(&folder.join(GROUND_EFFECT))?;
        let path = folder.join(THRUST);
        match &self.thrust {
            Some(thrust) => thrust.card.write(&path)?,
            // A card of other flights beside this one would fly with it.
            None if path.exists() => {
                std::fs::remove_file(&path).map_err(|e| Error::file(&path, e))?;
                let path = path.display();
                context.warn(&format!(
                    "{path} was removed: it was the card of an earlier run"
                ));
            }
            None => {}
        }
        Ok(())
    }
}

/// Warnings of the logs and of the flights in them, each once.
fn warnings_of_logs(logs: &[Log], flights: &[Flight]) -> Vec<String> {
    load::once(logs.iter().zip(flights).flat_map(|(log, flight)| {
        let notes = flight
            .notes
            .iter()
            .map(|n| (log.path.clone(), n.to_string()));
        notes.chain(log.warnings_by_log()).collect::<Vec<_>>()
    }))
}
