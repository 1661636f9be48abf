//! `touchdown land --space`: a campaign that is small enough to be flown at one go.

use std::path::Path;

use rayon::prelude::*;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::csv::line;
use touchdown_campaign::sweep::{self, LandingRow, SWEEP, Sweep, SweepSettings, summarise};
use touchdown_campaign::vertical::vehicle::mismatches;
use touchdown_model::Card;
use touchdown_sim::landing::space::Case;

use crate::cli::args::land::LandArgs;
use crate::cli::campaign::{Recording, print_report, record, state, write_report};
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_campaign::progress::Progress as _;
use touchdown_terminal::Done;

pub(super) fn run(context: &Context, args: &LandArgs) -> Result<Done> {
    let sweep = load(args)?;
    for path in [&args.thrust, &args.empirical, &args.dynamic] {
        let card = path.as_deref().map(Card::read).transpose()?;
        for mismatch in mismatches(&[card.as_ref()], &sweep.settings().scenario.plant) {
            context.warn(&mismatch);
        }
    }
    state(context, &sweep)?;
    if let Some(scenario) = &args.scenario {
        output::replaces_not(&args.out.join(SWEEP), "scenario", scenario)?;
    }
    output::results_folder(context, &args.out)?;
    let folders: Vec<_> = [(&args.mcap, Recording::Mcap), (&args.ulog, Recording::Ulog)]
        .into_iter()
        .filter_map(|(folder, kind)| Some((folder.as_deref()?, kind)))
        .collect();
    // Before the landings are flown that they are for.
    folders
        .iter()
        .try_for_each(|(folder, _)| output::folder(folder))?;
    context.stage("landings", sweep.landings());
    let rows = sweep::rows(&sweep, 0..sweep.landings(), context)?;
    let results = summarise(&sweep, &rows)?;
    output::write(
        &args.out.join(SWEEP),
        settings::to_toml(sweep.settings())?.as_bytes(),
    )?;
    for (name, bytes) in sweep.files() {
        output::write(&args.out.join(name), bytes)?;
    }
    output::write(
        &args.out.join("landings.csv"),
        landings(&sweep, &rows).as_bytes(),
    )?;
    if !folders.is_empty() {
        context.stage("records", sweep.landings());
        (0..sweep.landings())
            .into_par_iter()
            .try_for_each(|landing| -> Result<()> {
                for trace in sweep::replay(&sweep, &[landing])? {
                    for (folder, kind) in &folders {
                        record(landing, &trace, folder, *kind)?;
                    }
                }
                context.step();
                Ok(())
            })?;
    }
    let worst: Vec<u64> = results.worst.iter().map(|worst| worst.landing).collect();
    let worst = sweep::replay(&sweep, &worst)?;
    write_report(&sweep, &rows, &results, &worst, &args.out)?;
    Ok(print_report(context, &sweep, &rows, &results, &args.out))
}

fn load(args: &LandArgs) -> Result<Sweep> {
    let (mut settings, folder, file) = match &args.scenario {
        Some(path) => (
            SweepSettings::read(path)?,
            path.parent().unwrap_or(Path::new(".")),
            path.display().to_string(),
        ),
        None => {
            let settings = SweepSettings {
                trials: 40,
                scenario: Case::Paper.scenario(),
                ..SweepSettings::default()
            };
            (settings, Path::new("."), "arguments".to_string())
        }
    };
    if settings.autopilot.is_some() {
        return Err(Error::Settings {
            file,
            message: "`autopilot`: expected none, found some; `touchdown campaign` flies it"
                .to_string(),
        });
    }
    settings.seed = args.seed.unwrap_or(settings.seed);
    if let Some(trials) = args.trials {
        settings.trials = trials as u64;
    }
    let cards = &mut settings.cards;
    for (path, given) in [
        (&mut cards.thrust, &args.thrust),
        (&mut cards.empirical, &args.empirical),
        (&mut cards.dynamic, &args.dynamic),
    ] {
        if let Some(given) = given {
            // Paths of a scenario are relative to it, those of arguments are not.
            let absolute = std::path::absolute(given).map_err(|e| Error::file(given, e))?;
            *path = Some(absolute);
        }
    }
    if args.no_acceleration {
        settings.scenario.control.deck_acceleration = false;
    }
    let policy = args.policy.as_deref();
    let policy = policy.map(|path| std::path::absolute(path).map_err(|e| Error::file(path, e)));
    settings.set_controllers(args.controllers.clone(), policy.transpose()?);
    Ok(Sweep::new(settings, folder, file)?)
}

/// Every landing in a row, after the swept settings and before the drawn ones.
fn landings(sweep: &Sweep, rows: &[LandingRow]) -> String {
    let keys = sweep.grid().iter().map(|(key, _)| key.as_str());
    let mut out = String::new();
    let header = keys.chain(["trial"]).chain(LandingRow::header());
    line(&mut out, header.chain(sweep.drawn()));
    for row in rows {
        let values = sweep.values(row.landing / sweep.trials());
        let mut cells: Vec<String> = values.iter().map(|(_, value)| sweep::text(value)).collect();
        let trial = row.landing % sweep.trials();
        cells.push(trial.to_string());
        cells.extend(row.cells());
        cells.extend(sweep.draws(trial).iter().map(sweep::text));
        line(&mut out, cells);
    }
    out
}
