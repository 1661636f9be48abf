//! `touchdown rig`.

use rayon::prelude::*;
use serde::Serialize;
use touchdown::settings;
use touchdown::settings::rig::RigScenario;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_sim::rig::{self, RigTrial};

use super::args::RigArgs;
use super::context::Context;
use super::output;
use touchdown_terminal::Done;

#[derive(Serialize)]
struct Recorded {
    file: String,
    set: String,
    trial: String,
    rows: usize,
    duration_s: f64,
}

#[derive(Serialize)]
struct RigResults {
    schema: u32,
    version: &'static str,
    seed: u64,
    trials: Vec<Recorded>,
}

pub(crate) fn run(context: &Context, args: &RigArgs) -> Result<Done> {
    let (mut scenario, file) = match &args.scenario {
        Some(path) => (
            settings::read::<RigScenario>(path)?,
            path.display().to_string(),
        ),
        None => (RigScenario::default(), "arguments".to_string()),
    };
    if let Some(seed) = args.seed {
        scenario.seed = seed;
    }
    scenario.check(&file)?;
    let mut planned: Vec<(&str, RigTrial)> = Vec::new();
    for set in &scenario.sets {
        planned.extend(
            set.trials(&scenario.rig)?
                .into_iter()
                .map(|t| (set.name(), t)),
        );
    }
    planned.extend(scenario.trials.iter().map(|t| ("trials", t.clone())));
    context.stage("rig", 2 * planned.len() as u64);
    let recorded: Vec<_> = planned
        .par_iter()
        .map(|(_, trial)| {
            let recorded =
                rig::run(&scenario.rig, trial, scenario.seed).map_err(|e| Error::Settings {
                    file: file.clone(),
                    message: e.to_string(),
                })?;
            context.step();
            Ok(recorded)
        })
        .collect::<Result<_>>()?;
    output::results_folder(context, &args.out)?;
    for (set, _) in &planned {
        output::folder(&args.out.join(set))?;
    }
    let trials = planned
        .par_iter()
        .zip(&recorded)
        .map(|((set, _), trial)| {
            let file = format!("{set}/{}.csv", trial.name());
            touchdown_log::write_csv(trial, args.out.join(&file))?;
            context.step();
            Ok(Recorded {
                file,
                set: (*set).to_string(),
                trial: trial.name().to_string(),
                rows: trial.len(),
                duration_s: trial.duration_s(),
            })
        })
        .collect::<Result<Vec<_>>>()?;
    output::write(
        &args.out.join("scenario.toml"),
        settings::to_toml(&scenario)?.as_bytes(),
    )?;
    let results = RigResults {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        seed: scenario.seed,
        trials,
    };
    output::results(&args.out, &results)?;
    context.finish();
    let seconds: f64 = results.trials.iter().map(|t| t.duration_s).sum();
    context.say(&format!(
        "{} trials, {seconds:.0} s of data, in {}",
        results.trials.len(),
        args.out.display()
    ));
    context.object(&results);
    Ok(Done::Whole)
}
