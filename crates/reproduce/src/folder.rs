//! The folder of a run: trials, cards, tables, figures, report and results.

use std::path::Path;

use rayon::prelude::*;
use touchdown_campaign::files;
use touchdown_campaign::progress::Progress;
use touchdown_campaign::sweep::{LandingRow, SERIES};
use touchdown_model::{Card, published};
use touchdown_trial::Trial;

use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::results::Results;
use crate::{pages, settings};

/// Writes all files; `results.json` comes last, so its presence means that all files are complete.
///
/// # Errors
/// Files that cannot be written, or figures that cannot be drawn.
pub fn write(run: &Run, results: &Results, out: &Path, progress: &dyn Progress) -> Result<()> {
    files::begin_results(out)?;
    let cards = cards(run);
    let sets = trial_sets(run);
    let trials: Vec<(&str, &Trial)> = sets
        .iter()
        .flat_map(|(folder, trials)| trials.iter().map(move |t| (*folder, t)))
        .collect();
    progress.stage("writing", (trials.len() + cards.len() + 2) as u64);
    for (folder, _) in &sets {
        files::folder(&out.join("trials").join(folder))?;
    }
    trials
        .par_iter()
        .try_for_each(|(folder, trial)| -> Result<()> {
            let path = out
                .join("trials")
                .join(folder)
                .join(format!("{}.csv", trial.name()));
            touchdown_log::write_csv(trial, &path)?;
            progress.step();
            Ok(())
        })?;
    for card in cards {
        card.write(&out.join("cards").join(format!("{}.toml", card.name)))?;
        progress.step();
    }
    for (name, text) in [
        ("paper-eq11", published::EQ_11),
        ("paper-eq12", published::EQ_12),
    ] {
        files::write(
            &out.join("cards").join(format!("{name}.toml")),
            text.as_bytes(),
        )?;
    }
    files::write(
        &out.join("settings.toml"),
        settings::to_toml(&run.settings.with_files_here())?.as_bytes(),
    )?;
    if let Some(series) = &run.sea.series {
        files::write(&out.join(SERIES), series)?;
    }
    files::write(&out.join("sea.csv"), at_sea(run).as_bytes())?;
    files::write(&out.join("landings.csv"), landings(run).as_bytes())?;
    progress.step();
    pages::reproduce(run, results, out)?;
    progress.step();
    Ok(files::results(out, results)?)
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
                let outcome = l.outcome.name();
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
