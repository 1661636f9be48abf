//! `touchdown identify thrust`.

use std::path::{Path, PathBuf};
use std::slice::from_ref;

use rayon::prelude::*;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::thrust_of_flights;
use touchdown_identify::{FittedCard, IdentificationSettings, thrust};
use touchdown_log::Map;
use touchdown_pages::identify::{About, Shown, ThrustFit, ThrustFits};
use touchdown_trial::Trial;

use super::load::{self, Log};
use super::show;
use super::{Command, Target, flights, origin, with_vehicle, write_card, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_pages::identify::summary::{Failed, Fitted, Outcome, Summary};
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
        settings: &with_vehicle(settings, map.as_ref()),
        map: map.as_ref(),
    };
    match target {
        Target::File(card) => job.together(&card),
        Target::Folder(folder) => job.apart(Some(&folder)),
        Target::None => job.apart(None),
    }
}

/// A card, and the result of the identification where the log is of a flight.
type Fit = (FittedCard, Option<Box<FlightResult>>);

struct Job<'a> {
    context: &'a Context,
    common: &'a IdentifyCommon,
    settings: &'a IdentificationSettings,
    map: Option<&'a Map>,
}

impl Job<'_> {
    /// One card; `flights` if no thrust was measured.
    fn fit(&self, trials: &[Trial], logs: &[PathBuf], card: &str, flights: bool) -> Result<Fit> {
        let mut origin = origin(trials, self.map, self.common, self.settings)?;
        origin.provenance.command = Some(self.command().text(logs, card));
        if flights && self.settings.thrust.form.is_none() {
            let (made, flight) = thrust_of_flights(trials, self.settings, &origin)?;
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
        if let Some(rotors) = self.settings.vehicle.measured_rotors {
            more.extend(["--rotors".to_string(), rotors.to_string()]);
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
        let flights = logs.iter().all(flights::is_flight);
        let as_read = load::once(logs.iter().flat_map(Log::warnings_by_log));
        let logs = logs
            .into_iter()
            .map(|log| flights::thrust_of_flight(log, self.settings, self.map))
            .collect::<Result<Vec<Log>>>()
            .inspect_err(|_| self.warn(&as_read))?;
        self.context.stage("fitting", 1);
        let paths = &self.common.logs;
        let command_out = card.display().to_string();
        let fitted = self.fit(&load::trials(&logs), paths, &command_out, flights);
        let (fit, result) = fitted.inspect_err(|_| {
            let of_logs = logs.iter().flat_map(Log::warnings_by_log);
            self.warn(&load::once(of_logs));
        })?;
        write_card(self.context, card, &fit.card)?;
        let dropped = load::rows_dropped(&logs);
        let mut fitted = Fitted::of(load::label(paths), &fit, Some(card), dropped);
        fitted.flight = result;
        let of_logs = logs.iter().flat_map(Log::warnings_by_log);
        fitted.warnings.extend(load::once(of_logs));
        self.warn(&fitted.warnings);
        self.context.finish();
        self.context.object(&fitted);
        self.say(&[Outcome::Fitted(fitted)]);
        Ok(Done::with_loss(load::lossy(&logs)))
    }

    /// Prints the summary, with the results of flights: all of them for one log, the armed intervals for several.
    fn say(&self, outcomes: &[Outcome]) {
        let mut text = show::summary(&Summary::of(outcomes));
        if let [Outcome::Fitted(one)] = outcomes
            && !one.forms.is_empty()
        {
            text.push_str("\n\nForms, by the error of their free run on parts held out:\n");
            text += &show::forms(&one.forms);
        }
        for outcome in outcomes {
            if let Outcome::Fitted(Fitted {
                flight: Some(result),
                ..
            }) = outcome
            {
                text.push('\n');
                text += match outcomes {
                    [_] => flights::text(result),
                    _ => flights::armed_intervals(&result.runs),
                }
                .trim_end();
            }
        }
        self.context.say(&text);
    }

    /// A card for each log.
    fn apart(&self, folder: Option<&Path>) -> Result<Done> {
        let names = load::names(&self.common.logs);
        let fits = self.fit_each(&names)?;
        if fits.iter().all(Result::is_err) {
            return Err(first_error(fits));
        }
        let mut outcomes = Vec::new();
        let mut pages_of = Vec::new();
        let mut warnings = Vec::new();
        for ((fit, name), path) in fits.iter().zip(&names).zip(&self.common.logs) {
            let label = path.display().to_string();
            match fit {
                Ok((log, (made, flight))) => {
                    let card = folder.map(|folder| folder.join(card_file(name)));
                    let dropped = log.findings.rows_dropped();
                    let mut fitted = Fitted::of(label, made, card.as_deref(), dropped);
                    fitted.flight.clone_from(flight);
                    fitted.warnings.extend(log.warnings());
                    let of_log = fitted.warnings.iter().cloned();
                    warnings.extend(of_log.map(|warning| (path.clone(), warning)));
                    outcomes.push(Outcome::Fitted(fitted));
                    pages_of.push(ThrustFit {
                        name,
                        trials: from_ref(&log.trial),
                        made,
                        flight: flight.as_deref(),
                    });
                }
                Err(error) => {
                    self.context
                        .warn(&format!("{label}: the fit failed: {error}"));
                    outcomes.push(Outcome::Failed(Failed::of(label, None, error)));
                }
            }
        }
        let warnings = match fits.len() {
            1 => warnings.into_iter().map(|(_, warning)| warning).collect(),
            _ => load::once(warnings),
        };
        self.warn(&warnings);
        if let Some(folder) = folder {
            self.write(folder, &pages_of, &outcomes)?;
        }
        self.context.finish();
        match &outcomes[..] {
            [one] => self.context.object(one),
            all => self.context.object(&all),
        }
        self.say(&outcomes);
        let lossy = |(log, _): &(Log, Fit)| log.findings.is_lossy();
        let loss = fits.iter().any(|fit| fit.as_ref().map_or(true, lossy));
        Ok(Done::with_loss(loss))
    }

    /// Reads and fits every log; an error in place of a log that cannot be read or fitted.
    fn fit_each(&self, names: &[String]) -> Result<Vec<Result<(Log, Fit)>>> {
        let logs = load::logs(self.context, &self.common.logs, self.map)?;
        self.context.stage("fitting", logs.len() as u64);
        let fit = |(log, name): (Result<Log>, &String)| {
            let of_flight = log.as_ref().is_ok_and(flights::is_flight);
            let as_read = log.as_ref().map_or(Vec::new(), Log::warnings_by_log);
            let log = log.and_then(|log| flights::thrust_of_flight(log, self.settings, self.map));
            let log = match log {
                Ok(log) => log,
                Err(error) => return (as_read, Err(error)),
            };
            let (trials, paths) = (from_ref(&log.trial), from_ref(&log.path));
            let fit = self.fit(trials, paths, &card_file(name), of_flight);
            self.context.step();
            match fit {
                Ok((mut made, flight)) => {
                    made.card.name.clone_from(name);
                    (Vec::new(), Ok((log, (made, flight))))
                }
                Err(error) => (log.warnings_by_log(), Err(error)),
            }
        };
        let fits = logs.into_par_iter().zip(names).map(fit);
        let (of_failed, fits): (Vec<_>, Vec<_>) = fits.unzip();
        // What was dropped from a log often explains why nothing can be fitted.
        self.warn(&load::once(of_failed.into_iter().flatten()));
        Ok(fits)
    }

    fn warn(&self, warnings: &[String]) {
        for warning in warnings {
            self.context.warn(warning);
        }
    }

    /// Writes cards, tables, figures and the report.
    fn write(&self, folder: &Path, fits: &[ThrustFit<'_>], outcomes: &[Outcome]) -> Result<()> {
        self.context.stage("drawing", fits.len() as u64);
        let command = self.command();
        let command = command.text(&self.common.logs, &folder.display().to_string());
        let summary = Summary::of(outcomes);
        let about = About {
            outcomes,
            command: &command,
            settings: self.settings,
        };
        let Shown { figures, report } = ThrustFits(fits).shown(&about, self.context)?;
        output::results_folder(self.context, folder)?;
        for fit in fits {
            fit.made.card.write(&folder.join(card_file(fit.name)))?;
        }
        touchdown_pages::page::write(folder, &figures, &report)?;
        write_tables(folder, &outcomes, &summary, self.settings)
    }
}

/// File of the card of a log, in a folder of cards.
fn card_file(name: &str) -> String {
    format!("{name}.toml")
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
