//! `touchdown identify ground-effect`.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use touchdown::pages;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::rig::identifiability::{Identifiability, examine_trials};
use touchdown_identify::rig::levels::{self, Level};
use touchdown_identify::rig::{self as ground_effect, GroundTrial};
use touchdown_identify::settings::GroundEffectForm;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin};
use touchdown_model::{Card, Kind};
use touchdown_trial::Trial;

use super::load::{self, Log, word};
use super::show::{Failed, Fitted, Outcome, Summary};
use super::{Command, Target, done, flight, origin, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use touchdown_terminal::Done;

/// The channels in which a gap costs the row.
pub(crate) const CHANNELS: [&str; 5] = [
    "throttle",
    "thrust_n",
    "height_m",
    "deck_velocity_mps",
    "vehicle_velocity_mps",
];

/// Of so many logs one is held out when levels are compared, and fewer are not split.
const HELD_OUT_EVERY: usize = 5;
const FEWEST_LOGS: usize = 5;

/// Results with what the data can carry.
#[derive(Serialize)]
struct Results<'a> {
    before: &'a Identifiability,
    /// The levels of identification, on logs held out; empty where there are too few logs.
    levels: &'a [Level],
    models: &'a [Outcome],
}

pub(super) fn run(
    context: &Context,
    common: &IdentifyCommon,
    thrust: Option<&Path>,
    forms: &[GroundEffectForm],
    settings: &IdentificationSettings,
) -> Result<Done> {
    let target = Target::of(common.out.as_deref())?;
    let asked = !forms.is_empty();
    let map = load::map(common.map.as_deref())?;
    let logs = load::all_logs(context, &common.logs, map.as_ref())?;
    if logs.iter().all(flight::is_flight) {
        if let Some(form) = forms.first() {
            return Err(Error::Arguments(format!(
                "--form {}: the form follows from the data where logs are of flights (no channel `thrust_n`)",
                form.name()
            )));
        }
        return flight::run(
            context,
            common,
            thrust,
            settings,
            map.as_ref(),
            &logs,
            &target,
        );
    }
    let Some(thrust) = thrust else {
        return Err(Error::Arguments(
            "expected --thrust CARD, for there are logs with the channel `thrust_n`: the thrust out of ground effect is taken \
             off; found none (logs of flights have no such channel, and need no card)"
                .to_string(),
        ));
    };
    let forms = chosen(forms, &target)?;
    let thrust_card = thrust_card(thrust)?;
    let (trials, gaps) = prepare(&logs, &thrust_card)?;
    let before = examine_trials(&trials, settings)?;

    let recorded: Vec<Trial> = logs.iter().map(|l| l.trial.clone()).collect();
    let mut origin = origin(&recorded, map.as_ref(), common, settings)?;
    origin.vehicle.rotor_radius_m = Some(settings.ground_effect.rotor_radius_m);
    origin.provenance.inputs.push(load::input(thrust)?);
    let card_path = |form: GroundEffectForm| -> Option<PathBuf> {
        match &target {
            Target::None => None,
            Target::File(card) => Some(card.clone()),
            Target::Folder(folder) => Some(folder.join(format!("{}.toml", form.name()))),
        }
    };
    context.stage("fitting", forms.len() as u64);
    let fits: Vec<Result<FittedCard>> = forms
        .par_iter()
        .map(|&form| {
            let mut origin = origin.clone();
            let command = Command {
                what: "ground-effect",
                common,
                more: vec![
                    "--thrust".into(),
                    word(&thrust.display().to_string()),
                    "--form".into(),
                    form.name().into(),
                ],
            };
            let card = format!("{}.toml", form.name());
            origin.provenance.command = Some(command.text(&common.logs, &card));
            let made = ground_effect::fit(form, &trials, settings, &origin)
                .map_err(Error::from)
                .and_then(finite);
            context.step();
            made
        })
        .collect();
    let (forms, fits, failed) = sort_out(&forms, fits, asked)?;

    let mut of_logs = gaps;
    of_logs.extend(load::once(logs.iter().flat_map(Log::said)));
    of_logs.extend(before.advice.iter().cloned());
    for warning in &of_logs {
        context.warn(warning);
    }
    let dropped = logs.iter().map(|l| l.findings.rows_dropped()).sum();
    let label = match &common.logs[..] {
        [one] => one.display().to_string(),
        many => format!("{} logs together", many.len()),
    };
    let mut outcomes: Vec<Outcome> = forms
        .iter()
        .zip(&fits)
        .map(|(&form, made)| {
            let mut fitted = Fitted::of(label.clone(), made, card_path(form).as_deref(), dropped);
            for warning in &fitted.warnings {
                context.warn(&format!("{}: {warning}", form.name()));
            }
            fitted.warnings.extend(of_logs.iter().cloned());
            Outcome::Fitted(fitted)
        })
        .collect();
    for (form, error) in &failed {
        context.warn(&format!("{}: not fitted: {error}", form.name()));
        let failed = Failed::of(label.clone(), Some(form.name()), error);
        outcomes.push(Outcome::Failed(failed));
    }
    let summary = Summary::of(&outcomes);
    match &target {
        Target::None => {}
        Target::File(path) => fits[0].card.write(path)?,
        Target::Folder(folder) => {
            let command = Command {
                what: "ground-effect",
                common,
                more: vec!["--thrust".into(), word(&thrust.display().to_string())],
            };
            let overview = pages::identify::Overview {
                title: "Ground effect",
                command: &command.text(&common.logs, &folder.display().to_string()),
                header: summary.header(),
                rows: summary.rows(),
            };
            // Forms that were asked for by name are all that is wanted.
            let levels = if asked {
                Vec::new()
            } else {
                levels(context, &trials, settings, &origin)?
            };
            let figures = pages::identify::ground_figures(&trials, &fits)?;
            let report =
                pages::identify::ground_report(&overview, &before, &fits, &levels, &figures)?;
            let fronts: Vec<_> = fits
                .iter()
                .filter_map(pages::identify::front_figure)
                .collect();
            let results = Results {
                before: &before,
                levels: &levels,
                models: &outcomes,
            };
            for (form, made) in forms.iter().zip(&fits) {
                made.card
                    .write(&folder.join(format!("{}.toml", form.name())))?;
            }
            pages::identify::write(folder, figures.iter().chain(&fronts), &report)?;
            write_tables(folder, &results, &summary, settings)?;
        }
    }
    context.finish();
    match &outcomes[..] {
        [one] => context.object(one),
        all => context.object(&all),
    }
    context.say(&summary.text());
    Ok(done(logs.iter().any(|l| l.findings.is_lossy())))
}

/// The levels of identification, fitted to four fifths of the logs and judged on the rest. Where the smaller part cannot
/// be fitted there are none, and a warning says why.
fn levels(
    context: &Context,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<Vec<Level>> {
    if trials.len() < FEWEST_LOGS {
        return Ok(Vec::new());
    }
    let held_out = |i: usize| i % HELD_OUT_EVERY == HELD_OUT_EVERY - 1;
    let part = |unseen: bool| -> Vec<GroundTrial> {
        let of_part = (0..trials.len()).filter(|&i| held_out(i) == unseen);
        of_part.map(|i| trials[i].clone()).collect()
    };
    let (training, unseen) = (part(false), part(true));
    let forms = [
        GroundEffectForm::Static,
        GroundEffectForm::Derivative,
        GroundEffectForm::Ratio,
        GroundEffectForm::Lag,
    ];
    context.stage("levels", forms.len() as u64);
    let found = forms
        .into_par_iter()
        .map(|form| {
            let made = ground_effect::fit(form, &training, settings, origin)?;
            context.step();
            Ok((form, made))
        })
        .collect::<Result<Vec<_>>>()
        .and_then(|fits| {
            let fits: Vec<levels::Fitted<'_>> = fits
                .iter()
                .map(|(form, made)| levels::Fitted {
                    form: *form,
                    made,
                    free_run_rmse_n: None,
                })
                .collect();
            Ok(levels::compare(&training, &unseen, &fits, settings)?)
        });
    found.or_else(|e| {
        context.warn(&format!("the levels were not compared: {e}"));
        Ok(Vec::new())
    })
}

/// The forms to fit: those asked for; else all of them, or the lag form where there is one file to write.
fn chosen(forms: &[GroundEffectForm], target: &Target) -> Result<Vec<GroundEffectForm>> {
    let mut unique: Vec<GroundEffectForm> = Vec::new();
    for form in forms {
        if !unique.contains(form) {
            unique.push(*form);
        }
    }
    match (target, unique.len()) {
        (Target::File(_), 0) => Ok(vec![GroundEffectForm::Lag]),
        (Target::File(card), 2..) => Err(Error::Arguments(format!(
            "--out {}: expected a folder for the cards of {} forms, found a file",
            card.display(),
            unique.len()
        ))),
        (_, 0) => Ok(GroundEffectForm::ALL.to_vec()),
        _ => Ok(unique),
    }
}

/// Forms with their fits, and those that failed with why.
type Sorted = (
    Vec<GroundEffectForm>,
    Vec<FittedCard>,
    Vec<(GroundEffectForm, Error)>,
);

/// Of forms that were asked for by name, one that fails is an error. Of the default ones, the others are enough.
fn sort_out(
    forms: &[GroundEffectForm],
    fits: Vec<Result<FittedCard>>,
    asked: bool,
) -> Result<Sorted> {
    let (mut good, mut made, mut failed) = (Vec::new(), Vec::new(), Vec::new());
    for (form, fit) in forms.iter().zip(fits) {
        match fit {
            Ok(fit) => {
                good.push(*form);
                made.push(fit);
            }
            Err(e) => failed.push((*form, e)),
        }
    }
    if (asked || made.is_empty()) && !failed.is_empty() {
        return Err(failed.swap_remove(0).1);
    }
    Ok((good, made, failed))
}

/// A fit whose coefficients are all finite.
fn finite(made: FittedCard) -> Result<FittedCard> {
    match made.card.terms.iter().find(|t| !t.value.is_finite()) {
        None => Ok(made),
        Some(term) => Err(Error::data(
            &made.card.name,
            "data that a finite fit follows from",
            format!(
                "a coefficient `{}:{}` of {}",
                term.of, term.expression, term.value
            ),
        )),
    }
}

/// Reads the card that gives the free-air thrust.
pub(crate) fn thrust_card(path: &Path) -> Result<Card> {
    let card = Card::read(path)?;
    if card.kind != Kind::Thrust {
        return Err(Error::Arguments(format!(
            "{}: key `kind`: expected `thrust` (the card of --thrust gives the free-air thrust), found `ground_effect`",
            path.display()
        )));
    }
    Ok(card)
}

/// Extracts the force from every log. Rows with a gap in a needed channel are left out, and told of.
pub(crate) fn prepare(logs: &[Log], thrust: &Card) -> Result<(Vec<GroundTrial>, Vec<String>)> {
    let prepared: Vec<(GroundTrial, Option<String>)> = logs
        .par_iter()
        .map(|log| {
            let (whole, gaps) = load::without_gaps(&log.trial, &CHANNELS)?;
            let warning = (gaps > 0).then(|| {
                format!(
                    "{}: {gaps} of {} rows have a gap in a channel that is needed and are left out",
                    log.path.display(),
                    log.trial.len()
                )
            });
            Ok((ground_effect::prepare(&whole, thrust)?, warning))
        })
        .collect::<Result<_>>()?;
    let (trials, warnings): (Vec<_>, Vec<_>) = prepared.into_iter().unzip();
    Ok((trials, warnings.into_iter().flatten().collect()))
}
