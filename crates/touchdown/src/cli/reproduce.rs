//! `touchdown reproduce`.

use std::path::Path;

use rayon::prelude::*;
use touchdown::experiments::results::Results;
use touchdown::experiments::{self, Run};
use touchdown::settings::{self, ReproduceSettings};
use touchdown::{Result, pages};
use touchdown_campaign::progress::Progress as _;
use touchdown_campaign::sweep::{LandingRow, SERIES};
use touchdown_model::{Card, published};
use touchdown_sim::landing::space::Case;
use touchdown_trial::Trial;

use super::args::ReproduceArgs;
use super::context::Context;
use super::output;
use touchdown_terminal::Done;

pub(crate) fn run(context: &Context, args: &ReproduceArgs) -> Result<Done> {
    let settings = load(args)?;
    // A folder that cannot be written to is better known before the work than after it.
    output::folder(&args.out)?;
    let run = experiments::run(&settings, context)?;
    let results = Results::of(&run)?;
    write(context, &run, &results, &args.out)?;
    context.reported(&summary(&results), &args.out, &results);
    Ok(Done::Whole)
}

fn load(args: &ReproduceArgs) -> Result<ReproduceSettings> {
    let (mut settings, file) = match &args.settings {
        Some(path) => {
            let mut settings = settings::read::<ReproduceSettings>(path)?;
            settings.sea = settings.sea.from(path.parent().unwrap_or(Path::new(".")));
            (settings, path.display().to_string())
        }
        None => (ReproduceSettings::default(), "arguments".to_string()),
    };
    if args.quick {
        settings.quick = true;
        if args.settings.is_none() {
            settings.trials = ReproduceSettings::quick().trials;
        }
    }
    if let Some(seed) = args.seed {
        settings.seed = seed;
    }
    if let Some(trials) = args.trials {
        settings.trials = trials;
    }
    experiments::check(&settings, &file)?;
    Ok(settings)
}

/// Writes all files; `results.json` comes last, so its presence means that all files are complete.
fn write(context: &Context, run: &Run, results: &Results, out: &Path) -> Result<()> {
    output::results_folder(context, out)?;
    let cards = cards(run);
    let sets = trial_sets(run);
    let trials: Vec<(&str, &Trial)> = sets
        .iter()
        .flat_map(|(folder, trials)| trials.iter().map(move |t| (*folder, t)))
        .collect();
    context.stage("writing", (trials.len() + cards.len() + 2) as u64);
    for (folder, _) in &sets {
        output::folder(&out.join("trials").join(folder))?;
    }
    trials
        .par_iter()
        .try_for_each(|(folder, trial)| -> Result<()> {
            let path = out
                .join("trials")
                .join(folder)
                .join(format!("{}.csv", trial.name()));
            touchdown_log::write_csv(trial, &path)?;
            context.step();
            Ok(())
        })?;
    for card in cards {
        card.write(&out.join("cards").join(format!("{}.toml", card.name)))?;
        context.step();
    }
    for (name, text) in [
        ("paper-eq11", published::EQ_11),
        ("paper-eq12", published::EQ_12),
    ] {
        output::write(
            &out.join("cards").join(format!("{name}.toml")),
            text.as_bytes(),
        )?;
    }
    output::write(
        &out.join("settings.toml"),
        settings::to_toml(&run.settings.with_files_here())?.as_bytes(),
    )?;
    if let Some(series) = &run.sea.series {
        output::write(&out.join(SERIES), series)?;
    }
    output::write(&out.join("sea.csv"), at_sea(run).as_bytes())?;
    output::write(&out.join("landings.csv"), landings(run).as_bytes())?;
    context.step();
    pages::reproduce(run, results, out)?;
    context.step();
    output::results(out, results)
}

fn cards(run: &Run) -> Vec<&Card> {
    let thrust = run.thrust.iter().flat_map(|state| &state.models);
    let ground = run.ground_effect.sets.iter().flat_map(|set| &set.models);
    let moving = [&run.ground_effect.moving.made];
    let all = thrust.chain(ground).chain(moving);
    all.map(|made| &made.card).collect()
}

/// The rich data hold the paper's trials as well.
fn trial_sets(run: &Run) -> Vec<(&'static str, &[Trial])> {
    let [present, removed] = &run.thrust;
    let ge = &run.ground_effect;
    vec![
        ("thrust_training", &removed.training),
        ("thrust_validation", &removed.validation),
        ("thrust_training_with_plate", &present.training),
        ("thrust_validation_with_plate", &present.validation),
        ("ground_effect_rich", &ge.sets[1].recorded),
        ("ground_effect_moving", &ge.moving.recorded),
        ("ground_effect_moving_validation", &ge.moving.unseen),
        ("ground_effect_validation", &ge.recorded),
    ]
}

/// Every landing in a row.
fn landings(run: &Run) -> String {
    let mut out =
        String::from("experiment,method,trial,outcome,t_l_s,v_l_mps,s_l_m,final_height_m\n");
    let experiments = [
        ("ground_landing", &run.landing.ground),
        (
            "deck_landing_with_acceleration",
            &run.landing.with_acceleration,
        ),
        (
            "deck_landing_without_acceleration",
            &run.landing.without_acceleration,
        ),
    ];
    let cell = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    for (experiment, methods) in experiments {
        for m in methods {
            for l in &m.landings {
                let outcome = format!("{:?}", l.outcome);
                out.push_str(&format!(
                    "{experiment},{},{},{outcome},{},{},{},{}\n",
                    m.method.name(),
                    l.trial_index,
                    cell(l.t_l_s),
                    cell(l.v_l_mps),
                    cell(l.t_l_s.is_some().then_some(l.s_l_m)),
                    l.final_height_m
                ));
            }
        }
    }
    out
}

/// Every landing at sea in a row.
fn at_sea(run: &Run) -> String {
    let mut out = format!("case,how,trial,{}\n", LandingRow::header().join(","));
    for l in &run.sea.landings {
        for row in &l.rows {
            let (case, how) = (l.case.name(), l.how.name());
            let cells = row.cells().join(",");
            out.push_str(&format!("{case},{how},{},{cells}\n", row.landing));
        }
    }
    out
}

/// The main figures in a few lines.
fn summary(results: &Results) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_string(), |v| format!("{v:.3}"));
    line("throttle to thrust, plate removed, mean absolute error in free run [N]".into());
    for (model, kinds) in &results.thrust.plate_removed {
        let figures: Vec<String> = kinds
            .iter()
            .map(|(kind, e)| format!("{kind} {}", number(e.mae_n)))
            .collect();
        line(format!("  {model:<18} {}", figures.join("   ")));
    }
    line("ground effect, rich data, mean absolute error in free run [N]".into());
    for (form, kinds) in &results.ground_effect.rich_data {
        let figures: Vec<String> = kinds
            .iter()
            .map(|(kind, e)| format!("{kind} {}", number(e.mae_n)))
            .collect();
        line(format!("  {form:<18} {}", figures.join("   ")));
    }
    for (title, methods) in [
        ("landing on the ground", &results.ground_landing),
        (
            "landing on the deck, its acceleration fed forward",
            &results.deck_landing.with_acceleration,
        ),
        (
            "landing on the deck, its acceleration not fed forward",
            &results.deck_landing.without_acceleration,
        ),
    ] {
        line(title.into());
        for (method, f) in methods {
            let mean =
                |s: Option<touchdown_campaign::statistics::Summary>| number(s.map(|s| s.mean));
            line(format!(
                "  {method:<10} landed {:>3} of {:<3} (hard {}, crashed {})  T_L {} s   V_L {} m/s   S_L {} m",
                f.landed,
                f.trials,
                f.hard,
                f.crashed,
                mean(f.t_l_s),
                mean(f.v_l_mps),
                mean(f.s_l_m)
            ));
        }
    }
    line("  imbc takes no deck acceleration: both blocks show the same landings of it".into());
    let mut cases = Vec::new();
    line("at sea, in six degrees of freedom, as planned".into());
    let decks = results.sea.decks.iter();
    let planned = decks.filter_map(|(deck, ways)| Some((deck, ways.get("planned")?)));
    for (case, f) in planned.chain(&results.sea.faults) {
        let count = |of: Option<touchdown_campaign::statistics::Share>| of.map_or(0, |s| s.count);
        line(format!(
            "  {case:<13} landed {:>3} of {:<3}  hard {:<3} crashed {:<3} T_L {} s   V_L {} m/s   lateral {} m",
            count(f.landed),
            f.trials,
            count(f.hard),
            count(f.crashed),
            number(f.t_l_s.mean),
            number(f.v_l_mps.mean),
            number(f.lateral_m.mean)
        ));
        cases.extend(Case::named(case));
    }
    line("  where".into());
    for case in cases {
        line(format!("    {:<13} {}", case.name(), case.description()));
    }
    out.pop();
    out
}
