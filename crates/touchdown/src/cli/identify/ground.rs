//! `touchdown identify ground-effect`.

use std::path::Path;

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::rig::GroundTrial;
use touchdown_identify::rig::forms::{self, FormFits};
use touchdown_identify::rig::identifiability::{Identifiability, examine_trials};
use touchdown_identify::rig::levels::Level;
use touchdown_identify::{IdentificationSettings, Origin};
use touchdown_model::{Card, Form, Kind};

use super::load::{self, Log, word};
use super::show;
use super::{Command, Target, flights, origin, with_vehicle, write_card, write_tables};
use crate::cli::args::identify::IdentifyCommon;
use crate::cli::context::Context;
use crate::cli::output;
use touchdown_pages::identify::summary::{Failed, Fitted, Outcome, Summary};
use touchdown_pages::identify::{About, RigFit, Shown};
use touchdown_terminal::Done;

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
    by_name: &[Form],
    settings: &IdentificationSettings,
) -> Result<Done> {
    let target = Target::of(common.out.as_deref())?;
    let asked = chosen(by_name, &target)?;
    let map = load::map(common.map.as_deref())?;
    let mut settings = with_vehicle(settings, map.as_ref());
    let radius_m = &mut settings.ground_effect.rotor_radius_m;
    *radius_m = settings.vehicle.rotor_radius_m.unwrap_or(*radius_m);
    let settings = &settings;
    // What the user configures is checked before the logs are read, which takes longer.
    let card = thrust.map(thrust_card).transpose()?;
    let logs = load::all_logs(context, &common.logs, map.as_ref())?;
    if logs.iter().all(flights::is_flight) {
        if let Some(form) = by_name.first() {
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
    forms::check_thrust_card(&card, settings.vehicle.rotors)
        .map_err(|e| Error::Arguments(format!("--thrust: {e}")))?;
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
    let mut fits = sort_out(job.fit(&asked), !by_name.is_empty())?;
    let of_thrust = card.warnings.iter();
    let of_thrust: Vec<String> = of_thrust
        .map(|w| format!("thrust card `{}`: {w}", card.name))
        .collect();
    for fitted in &mut fits.cards {
        fitted.card.warnings.extend(of_thrust.iter().cloned());
    }
    let mut of_logs = gaps;
    of_logs.extend(of_thrust);
    of_logs.extend(load::once(logs.iter().flat_map(Log::warnings_by_log)));
    of_logs.extend(identifiability.advice_for(&asked).map(ToString::to_string));
    let outcomes = job.outcomes(&fits, &of_logs, load::rows_dropped(&logs));
    match &target {
        Target::None => {}
        Target::File(path) => write_card(context, path, &fits.cards[0].card)?,
        // Forms that were asked for by name are all that is wanted.
        Target::Folder(folder) => job.write(folder, &fits, &outcomes, by_name.is_empty())?,
    }
    context.finish();
    match &outcomes[..] {
        [one] => context.object(one),
        all => context.object(&all),
    }
    context.say(&show::summary(&Summary::of(&outcomes)));
    Ok(Done::with_loss(load::lossy(&logs)))
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

    fn fit(&self, asked: &[Form]) -> FormFits {
        self.context.stage("fitting", asked.len() as u64);
        let origin = |form: Form| {
            let mut origin = self.origin.clone();
            origin.provenance.command = Some(self.command(Some(form), &card_file(form)));
            origin
        };
        let done = || self.context.step();
        forms::fit_forms(asked, self.trials, self.settings, origin, done)
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
        let levels = if compare_levels {
            levels(self.context, self.trials, self.settings, &self.origin)
        } else {
            Vec::new()
        };
        let (before, cards) = (self.identifiability, &fits.cards);
        let about = About {
            outcomes,
            command: &command,
            settings: self.settings,
        };
        let fit = RigFit {
            trials: self.trials,
            before,
            cards,
            levels: &levels,
        };
        let Shown { figures, report } = fit.shown(&about)?;
        output::results_folder(self.context, folder)?;
        for (&form, fitted) in fits.forms.iter().zip(cards) {
            fitted.card.write(&folder.join(card_file(form)))?;
        }
        touchdown_pages::page::write(folder, &figures, &report)?;
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

/// The levels of identification, on held-out logs. Where the smaller part cannot be fitted there are none, and a warning
/// says why.
fn levels(
    context: &Context,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Vec<Level> {
    context.stage("levels", forms::LEVEL_STEPS);
    let found = forms::held_out_levels(trials, settings, origin, || context.step());
    found.unwrap_or_else(|e| {
        context.warn(&format!("the comparison of the levels failed: {e}"));
        Vec::new()
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

/// Of forms that were asked for by name, one that fails is an error. Of the default ones, the others are enough.
fn sort_out(mut fits: FormFits, by_name: bool) -> Result<FormFits> {
    if (by_name || fits.cards.is_empty()) && !fits.failed.is_empty() {
        return Err(fits.failed.swap_remove(0).1.into());
    }
    Ok(fits)
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
    let trials: Vec<_> = logs.iter().map(|log| &log.trial).collect();
    let prepared = forms::prepare_all(&trials, thrust)?;
    let mut trials = Vec::new();
    let mut warnings = Vec::new();
    for ((trial, gaps), log) in prepared.into_iter().zip(logs) {
        trials.push(trial);
        warnings.extend(gaps.map(|gaps| format!("{}: {gaps}", log.path.display())));
    }
    Ok((trials, warnings))
}
