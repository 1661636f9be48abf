//! `touchdown identify ground-effect`.

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;
use touchdown::pages;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::rig::identifiability::{Identifiability, examine_trials};
use touchdown_identify::rig::levels::{self, Level};
use touchdown_identify::rig::{self as ground_effect, GroundTrial};
use touchdown_identify::{FittedCard, IdentificationSettings, Origin};
use touchdown_model::{Card, Form, Kind};

use super::load::{self, Log, word};
use super::show::{Failed, Fitted, Outcome, Summary};
use super::{Command, Target, flights, origin, with_vehicle, write_card, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_terminal::Done;

/// One of this number of logs is held out when levels are compared. Fewer logs are not split.
const HELD_OUT_EVERY: usize = 5;
const FEWEST_LOGS: usize = 5;

/// The models, what the data identify, and the levels of identification.
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
    forms: &[Form],
    settings: &IdentificationSettings,
) -> Result<Done> {
    let target = Target::of(common.out.as_deref())?;
    let asked = chosen(forms, &target)?;
    let map = load::map(common.map.as_deref())?;
    let mut settings = with_vehicle(settings, map.as_ref());
    let radius_m = &mut settings.ground_effect.rotor_radius_m;
    *radius_m = settings.vehicle.rotor_radius_m.unwrap_or(*radius_m);
    let settings = &settings;
    // What the user configures is checked before the logs are read, which takes longer.
    let card = thrust.map(thrust_card).transpose()?;
    let logs = load::all_logs(context, &common.logs, map.as_ref())?;
    if logs.iter().all(flights::is_flight) {
        if let Some(form) = forms.first() {
            return Err(Error::Arguments(format!(
                "--form {}: found logs of flights (no channel `thrust_n`), whose data decide the form; remove --form",
                form.name()
            )));
        }
        let map = map.as_ref();
        let thrust = thrust.zip(card.as_ref());
        return flights::run(context, common, thrust, settings, map, &logs, &target);
    }
    let Some((thrust, card)) = thrust.zip(card) else {
        return Err(Error::Arguments(
            "expected --thrust CARD, found none: the logs have the channel `thrust_n`, and the card gives the thrust out of \
             ground effect that is subtracted (logs of flights have no `thrust_n` and need no card)"
                .to_string(),
        ));
    };
    let (trials, gaps) = prepare(&logs, &card)?;
    check_rotors(&card, settings.vehicle.rotors)?;
    let identifiability = examine_trials(&trials, settings)?;
    let mut origin = origin(&load::trials(&logs), map.as_ref(), common, settings)?;
    origin.vehicle.rotor_radius_m = Some(settings.ground_effect.rotor_radius_m);
    origin.provenance.inputs.push(load::input(thrust)?);
    let job = Job {
        context,
        common,
        thrust,
        settings,
        target: &target,
        trials: &trials,
        identifiability: &identifiability,
        origin,
    };
    let fits = sort_out(&asked, job.fit(&asked), !forms.is_empty())?;
    let mut of_logs = gaps;
    of_logs.extend(load::once(logs.iter().flat_map(Log::warnings_by_log)));
    of_logs.extend(identifiability.advice.iter().map(ToString::to_string));
    let outcomes = job.outcomes(&fits, &of_logs, load::rows_dropped(&logs));
    match &target {
        Target::None => {}
        Target::File(path) => write_card(context, path, &fits.cards[0].card)?,
        // Forms that were asked for by name are all that is wanted.
        Target::Folder(folder) => job.write(folder, &fits, &outcomes, forms.is_empty())?,
    }
    context.finish();
    match &outcomes[..] {
        [one] => context.object(one),
        all => context.object(&all),
    }
    context.say(&Summary::of(&outcomes).text());
    Ok(Done::with_loss(load::lossy(&logs)))
}

/// A force rig holds a whole vehicle, so a thrust that is subtracted is that of all its rotors.
fn check_rotors(card: &Card, rotors: Option<u32>) -> Result<()> {
    match (card.measured_rotors, rotors.or(card.vehicle.rotors)) {
        (Some(measured), Some(all)) if measured != all => Err(Error::Arguments(format!(
            "--thrust: card `{}` has the thrust of {measured} of {all} rotors, and the force rig measures the force on all of \
             them; identify the thrust of the whole vehicle on the rig",
            card.name
        ))),
        (Some(1), None) => Err(Error::Arguments(format!(
            "--thrust: card `{}` has the thrust of one rotor, and the force rig measures the force on a whole vehicle; identify \
             the thrust on the rig, or set rotors in [vehicle]",
            card.name
        ))),
        _ => Ok(()),
    }
}

/// The identification of all forms from the logs of a force rig.
struct Job<'a> {
    context: &'a Context,
    common: &'a IdentifyCommon,
    /// Path of the card of the thrust out of ground effect.
    thrust: &'a Path,
    settings: &'a IdentificationSettings,
    target: &'a Target,
    trials: &'a [GroundTrial],
    identifiability: &'a Identifiability,
    origin: Origin,
}

impl Job<'_> {
    /// The command that makes all cards again, or the card of one form.
    fn command(&self, form: Option<Form>, out: &str) -> String {
        let mut more = vec!["--thrust".into(), word(&self.thrust.display().to_string())];
        if let Some(form) = form {
            more.extend(["--form".into(), form.name().into()]);
        }
        let command = Command {
            what: "ground-effect",
            common: self.common,
            more,
        };
        command.text(&self.common.logs, out)
    }

    fn fit(&self, forms: &[Form]) -> Vec<Result<FittedCard>> {
        self.context.stage("fitting", forms.len() as u64);
        let fit = |&form: &Form| {
            let mut origin = self.origin.clone();
            origin.provenance.command = Some(self.command(Some(form), &card_file(form)));
            let fitted = ground_effect::fit(form, self.trials, self.settings, &origin);
            self.context.step();
            with_terms(fitted?)
        };
        forms.par_iter().map(fit).collect()
    }

    /// What is printed of every form, with the warnings; `of_logs` are those that all forms share.
    fn outcomes(&self, fits: &FormFits, of_logs: &[String], dropped: usize) -> Vec<Outcome> {
        for warning in of_logs {
            self.context.warn(warning);
        }
        let label = load::label(&self.common.logs);
        let mut outcomes = Vec::new();
        for (&form, card) in fits.forms.iter().zip(&fits.cards) {
            let path = self.target.card(&card_file(form));
            let mut fitted = Fitted::of(label.clone(), card, path.as_deref(), dropped);
            for warning in &fitted.warnings {
                self.context.warn(&format!("{}: {warning}", form.name()));
            }
            fitted.warnings.extend(of_logs.iter().cloned());
            outcomes.push(Outcome::Fitted(fitted));
        }
        for (form, error) in &fits.failed {
            let name = form.name();
            self.context
                .warn(&format!("{name}: the fit failed: {error}"));
            let failed = Failed::of(label.clone(), Some(name), error);
            outcomes.push(Outcome::Failed(failed));
        }
        outcomes
    }

    /// Writes cards, tables, figures and the report.
    fn write(
        &self,
        folder: &Path,
        fits: &FormFits,
        outcomes: &[Outcome],
        compare_levels: bool,
    ) -> Result<()> {
        let summary = Summary::of(outcomes);
        let command = self.command(None, &folder.display().to_string());
        let overview = summary.overview("Ground effect", &command);
        let levels = if compare_levels {
            levels(self.context, self.trials, self.settings, &self.origin)?
        } else {
            Vec::new()
        };
        let (before, cards) = (self.identifiability, &fits.cards);
        let figures = pages::identify::ground_figures(self.trials, cards)?;
        let report = pages::identify::ground_report(&overview, before, cards, &levels, &figures)?;
        let fronts: Vec<_> = cards
            .iter()
            .filter_map(pages::identify::front_figure)
            .collect();
        output::results_folder(self.context, folder)?;
        for (&form, fitted) in fits.forms.iter().zip(cards) {
            fitted.card.write(&folder.join(card_file(form)))?;
        }
        pages::identify::write(folder, figures.iter().chain(&fronts), &report)?;
        let results = Results {
            before,
            levels: &levels,
            models: outcomes,
        };
        write_tables(folder, &results, &summary, self.settings)
    }
}

/// File of the card of a form, in a folder of cards.
fn card_file(form: Form) -> String {
    format!("{}.toml", form.name())
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
    let forms = [Form::Static, Form::Derivative, Form::Ratio, Form::Lag];
    context.stage("levels", forms.len() as u64);
    let found = forms
        .into_par_iter()
        .map(|form| {
            let made = with_terms(ground_effect::fit(form, &training, settings, origin)?)?;
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
        context.warn(&format!("the comparison of the levels failed: {e}"));
        Ok(Vec::new())
    })
}

/// The forms to fit: those asked for; else all of them, or the lag form where there is one file to write.
fn chosen(forms: &[Form], target: &Target) -> Result<Vec<Form>> {
    let mut unique: Vec<Form> = Vec::new();
    for form in forms {
        if !unique.contains(form) {
            unique.push(*form);
        }
    }
    match (target, unique.len()) {
        (Target::File(_), 0) => Ok(vec![Form::Lag]),
        (Target::File(card), 2..) => Err(Error::Arguments(format!(
            "--out {}: expected a folder for the cards of {} forms, found a file",
            card.display(),
            unique.len()
        ))),
        (_, 0) => Ok(Form::GROUND_EFFECT.to_vec()),
        _ => Ok(unique),
    }
}

/// Forms with their cards side by side, and forms that could not be fitted, with the reason.
#[derive(Default)]
struct FormFits {
    forms: Vec<Form>,
    cards: Vec<FittedCard>,
    failed: Vec<(Form, Error)>,
}

/// Of forms that were asked for by name, one that fails is an error. Of the default ones, the others are enough.
fn sort_out(forms: &[Form], fits: Vec<Result<FittedCard>>, by_name: bool) -> Result<FormFits> {
    let mut sorted = FormFits::default();
    for (&form, fit) in forms.iter().zip(fits) {
        match fit {
            Ok(fit) => {
                sorted.forms.push(form);
                sorted.cards.push(fit);
            }
            Err(e) => sorted.failed.push((form, e)),
        }
    }
    if (by_name || sorted.cards.is_empty()) && !sorted.failed.is_empty() {
        return Err(sorted.failed.swap_remove(0).1);
    }
    Ok(sorted)
}

/// Refuses a fit that kept no term: its card predicts nothing.
fn with_terms(fitted: FittedCard) -> Result<FittedCard> {
    if fitted.card.terms.is_empty() {
        let name = &fitted.card.name;
        return Err(Error::data(name, "data that support a term", "none"));
    }
    Ok(fitted)
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

/// Extracts the force from every log. Rows with a gap in a needed channel are left out, with a warning.
pub(crate) fn prepare(logs: &[Log], thrust: &Card) -> Result<(Vec<GroundTrial>, Vec<String>)> {
    let prepared: Vec<(GroundTrial, Option<String>)> = logs
        .par_iter()
        .map(|log| {
            let (whole, gaps) = ground_effect::without_gaps(&log.trial)?;
            let warning = (gaps > 0).then(|| {
                format!(
                    "{}: {gaps} of {} rows have a gap in a necessary channel and are not used",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_card_without_terms_is_refused() {
        let fitted = FittedCard {
            card: Origin::default().card("none", Kind::GroundEffect, Form::Derivative, ""),
            rmse: 0.0,
            rmse_unit: "N/s",
            rows_used: 0,
            lag_s: None,
            forms: Vec::new(),
            front: None,
            warnings: Vec::new(),
        };
        let error = with_terms(fitted).unwrap_err().to_string();
        assert_eq!(error, "none: expected data that support a term, found none");
    }
}
