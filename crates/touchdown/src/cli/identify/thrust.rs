//! `touchdown identify thrust`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use touchdown::pages;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::{FittedCard, IdentificationSettings, thrust};
use touchdown_log::Map;
use touchdown_trial::Trial;

use super::load::{self, Log};
use super::show::{Failed, Fitted, Outcome, Summary};
use super::{Command, Target, done, flight, origin, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use touchdown_terminal::Done;

pub(super) fn run(
    context: &Context,
    common: &IdentifyCommon,
    settings: &IdentificationSettings,
) -> Result<Done> {
    let target = Target::of(common.out.as_deref())?;
    let map = load::map(common.map.as_deref())?;
    let job = Job {
        context,
        common,
        settings,
        map: map.as_ref(),
    };
    match target {
        Target::File(card) => job.together(&card),
        Target::Folder(folder) => job.apart(Some(&folder)),
        Target::None => job.apart(None),
    }
}

/// A card, and what flights say beside it.
type Fit = (FittedCard, Option<Box<FlightResult>>);

struct Job<'a> {
    context: &'a Context,
    common: &'a IdentifyCommon,
    settings: &'a IdentificationSettings,
    map: Option<&'a Map>,
}

impl Job<'_> {
    /// One card; `flights` says that no thrust was measured in them.
    fn fit(&self, trials: &[Trial], logs: &[PathBuf], card: &str, flights: bool) -> Result<Fit> {
        let mut origin = origin(trials, self.map, self.common, self.settings)?;
        origin.provenance.command = Some(self.command().text(logs, card));
        if flights && self.settings.thrust.form.is_none() {
            let (made, flight) = flight::thrust(trials, self.settings, &origin)?;
            return Ok((made, Some(Box::new(flight))));
        }
        Ok((thrust::fit(trials, self.settings, &origin)?, None))
    }

    fn command(&self) -> Command<'_> {
        let settings = &self.settings.thrust;
        let mut more = Vec::new();
        if let Some(form) = settings.form.and_then(|f| serde_json::to_value(f).ok()) {
            more.extend([
                "--form".to_string(),
                form.as_str().unwrap_or("").to_string(),
            ]);
        }
        more.extend(["--degree".to_string(), settings.degree.to_string()]);
        if settings.battery {
            more.push("--battery".to_string());
        }
        Command {
            what: "thrust",
            common: self.common,
            more,
        }
    }

    /// One card from all logs.
    fn together(&self, card: &Path) -> Result<Done> {
        let logs = load::all_logs(self.context, &self.common.logs, self.map)?;
        let flights = logs.iter().all(flight::is_flight);
        let logs = logs
            .into_iter()
            .map(|log| flight::thrust_of_flight(log, self.settings, self.map))
            .collect::<Result<Vec<Log>>>()?;
        self.context.stage("fitting", 1);
        let trials: Vec<Trial> = logs.iter().map(|l| l.trial.clone()).collect();
        let (made, flight) = self.fit(
            &trials,
            &self.common.logs,
            &card.display().to_string(),
            flights,
        )?;
        made.card.write(card)?;
        let label = match &logs[..] {
            [one] => one.path.display().to_string(),
            many => format!("{} logs together", many.len()),
        };
        let dropped = logs.iter().map(|l| l.findings.rows_dropped()).sum();
        let mut fitted = Fitted::of(label, &made, Some(card), dropped);
        fitted.flight = flight;
        let said = logs.iter().flat_map(Log::said);
        fitted.warnings.extend(load::once(said));
        for warning in &fitted.warnings {
            self.context.warn(warning);
        }
        self.context.finish();
        self.context.object(&fitted);
        let outcomes = [Outcome::Fitted(fitted)];
        self.say(&outcomes);
        Ok(done(logs.iter().any(|l| l.findings.is_lossy())))
    }

    /// The summary for people, with what flights say: all of it of one, the runs of the motors of several.
    fn say(&self, outcomes: &[Outcome]) {
        let mut text = Summary::of(outcomes).text();
        for outcome in outcomes {
            if let Outcome::Fitted(Fitted {
                flight: Some(result),
                ..
            }) = outcome
            {
                text.push('\n');
                text += match outcomes {
                    [_] => flight::told(result),
                    _ => flight::runs(&result.runs),
                }
                .trim_end();
            }
        }
        self.context.say(&text);
    }

    /// A card for each log.
    fn apart(&self, folder: Option<&Path>) -> Result<Done> {
        let logs = load::logs(self.context, &self.common.logs, self.map)?;
        let several = logs.len() > 1;
        let names = load::names(&self.common.logs);
        self.context.stage("fitting", logs.len() as u64);
        let fits: Vec<Result<(Log, Fit)>> = logs
            .into_par_iter()
            .zip(&names)
            .map(|(log, name)| {
                let log = log?;
                let of_flight = flight::is_flight(&log);
                let log = flight::thrust_of_flight(log, self.settings, self.map)?;
                let one = std::slice::from_ref(&log.trial);
                let made = self.fit(
                    one,
                    std::slice::from_ref(&log.path),
                    &format!("{name}.toml"),
                    of_flight,
                );
                self.context.step();
                let (mut made, flight) = made?;
                made.card.name.clone_from(name);
                Ok((log, (made, flight)))
            })
            .collect();
        if fits.iter().all(Result::is_err) {
            return Err(first_error(fits));
        }
        let card_of = |name: &str| folder.map(|f| f.join(format!("{name}.toml")));
        let mut loss = false;
        let mut outcomes = Vec::new();
        let mut pages_of = Vec::new();
        let mut said = Vec::new();
        for ((fit, name), path) in fits.iter().zip(&names).zip(&self.common.logs) {
            let label = path.display().to_string();
            match fit {
                Ok((log, (made, flight))) => {
                    loss |= log.findings.is_lossy();
                    let dropped = log.findings.rows_dropped();
                    let mut fitted = Fitted::of(label, made, card_of(name).as_deref(), dropped);
                    fitted.flight.clone_from(flight);
                    fitted.warnings.extend(log.warnings());
                    let warnings = fitted.warnings.iter().cloned();
                    said.extend(warnings.map(|w| (path.clone(), w)));
                    outcomes.push(Outcome::Fitted(fitted));
                    pages_of.push(pages::identify::ThrustFit {
                        name,
                        trial: &log.trial,
                        made,
                        flight: flight.as_deref(),
                    });
                }
                Err(error) => {
                    loss = true;
                    self.context.warn(&format!("{label}: not fitted: {error}"));
                    outcomes.push(Outcome::Failed(Failed::of(label, None, error)));
                }
            }
        }
        let said = if several {
            load::once(said)
        } else {
            said.into_iter().map(|(_, warning)| warning).collect()
        };
        for warning in &said {
            self.context.warn(warning);
        }
        let summary = Summary::of(&outcomes);
        if let Some(folder) = folder {
            self.context.stage("drawing", pages_of.len() as u64);
            let figures = pages::identify::thrust_figures(&pages_of, self.settings, self.context)?;
            let command = self.command();
            let overview = pages::identify::Overview {
                title: "Throttle to thrust",
                command: &command.text(&self.common.logs, &folder.display().to_string()),
                header: summary.header(),
                rows: summary.rows(),
            };
            let report = pages::identify::thrust_report(&overview, &pages_of, &figures)?;
            for page in &pages_of {
                page.made
                    .card
                    .write(&folder.join(format!("{}.toml", page.name)))?;
            }
            pages::identify::write(folder, figures.iter().flatten(), &report)?;
            write_tables(folder, &outcomes, &summary, self.settings)?;
        }
        self.context.finish();
        match &outcomes[..] {
            [one] => self.context.object(one),
            all => self.context.object(&all),
        }
        self.say(&outcomes);
        Ok(done(loss))
    }
}

/// Why nothing was fitted: the first log's error, and how many logs there are.
fn first_error(fits: Vec<Result<(Log, Fit)>>) -> Error {
    let count = fits.len();
    let first = fits.into_iter().find_map(Result::err);
    match first {
        Some(error) if count > 1 && error.exit_status() == 1 => Error::data(
            format!("none of {count} logs could be fitted"),
            "at least one that can",
            format!("in the first: {error}"),
        ),
        Some(error) => error,
        None => Error::Arguments("expected at least one log".to_string()),
    }
}
