//! IV-B.2: the ground-effect models on the paper's data and on richer data, judged in free run.

use rayon::prelude::*;
use touchdown_campaign::progress::Progress;
use touchdown_identify::fitted::score;
use touchdown_identify::rig::levels::{self, Fitted, Level};
use touchdown_identify::rig::relative::{self, RelativeVelocity};
use touchdown_identify::rig::{self, GroundTrial, identifiability};
use touchdown_identify::scores::Errors;
use touchdown_identify::{FittedCard, Origin};
use touchdown_model::{Card, Form};
use touchdown_sim::body::plant::Plant;
use touchdown_sim::rig::RigTrial;
use touchdown_sim::rig::sets::{self, VALIDATION_KINDS};
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::settings::ReproduceSettings;

/// One data set with the models fitted to it.
#[derive(Clone, Debug)]
pub struct DataSet {
    /// Name in results: `paper_data` or `rich_data`.
    pub name: &'static str,
    /// The recorded trials.
    pub recorded: Vec<Trial>,
    /// What the data can carry, found before the fit.
    pub before: identifiability::Identifiability,
    /// The models, in the order of [`Form::GROUND_EFFECT`].
    pub models: Vec<FittedCard>,
    /// Errors `[model][validation trial]`.
    pub errors: Vec<Vec<ValidationErrors>>,
    /// The levels of identification side by side.
    pub levels: Vec<Level>,
}

/// Eq. (9) on trials in which vehicle and plate both move.
#[derive(Clone, Debug)]
pub struct MovingTrials {
    /// The recorded trials.
    pub recorded: Vec<Trial>,
    /// Trials at other throttles, never trained on.
    pub unseen: Vec<Trial>,
    /// The fit, with its front.
    pub made: FittedCard,
    /// Velocities apart against the relative velocity alone, on these trials.
    pub relative: RelativeVelocity,
    /// The same on trajectories of the printed eq. (12) itself.
    pub printed: RelativeVelocity,
}

/// Errors of one model on one validation trial.
#[derive(Clone, Copy, Debug)]
pub struct ValidationErrors {
    /// Against the plant's own force with turbulence and sensor noise off.
    pub truth: Errors,
    /// Against the raw measurement.
    pub raw: Errors,
}

/// The experiment.
#[derive(Clone, Debug)]
pub struct GroundEffectExperiment {
    /// The paper's data, then the rich data.
    pub sets: [DataSet; 2],
    /// Vehicle and plate both in motion.
    pub moving: MovingTrials,
    /// The recorded validation trials.
    pub recorded: Vec<Trial>,
    /// The same, prepared.
    pub validation: Vec<GroundTrial>,
    /// The measurement's own noise on every validation trial.
    pub floor: Vec<Errors>,
}

/// The kind of a validation trial, by its name.
#[must_use]
pub fn kind_of(name: &str) -> &'static str {
    VALIDATION_KINDS
        .into_iter()
        .find(|kind| {
            name.strip_prefix(kind)
                .is_some_and(|rest| rest.starts_with('-'))
        })
        .unwrap_or("other")
}

/// Runs the experiment; the force is extracted with `thrust_card`.
///
/// # Errors
/// Settings that make no sense.
pub fn run(
    settings: &ReproduceSettings,
    thrust_card: &Card,
    origin: &Origin,
    progress: &dyn Progress,
) -> Result<GroundEffectExperiment> {
    let extent = super::extent(settings);
    let motor = *Plant::new(&settings.rig.plant)?.motor();
    let training = [
        ("paper_data", sets::ground_effect_paper(extent)),
        ("rich_data", sets::ground_effect_rich(extent)),
    ];
    let validation = sets::ground_effect_validation(&motor, extent);
    let moving = sets::ground_effect_moving(extent);
    let moving_unseen = sets::ground_effect_moving_validation(extent);
    // What the data carry, every form, and the levels.
    let models = Form::GROUND_EFFECT.len() + 2;
    let steps = training
        .iter()
        .map(|(_, t)| t.len() + models)
        .sum::<usize>()
        + validation.len()
        + moving.len()
        + moving_unseen.len()
        + 1;
    progress.stage("ground effect", steps as u64);
    let recorded = super::record(&validation, settings, progress)?;
    let validation = prepare(&recorded, thrust_card)?;
    let floor = recorded
        .iter()
        .map(|t| {
            compare(
                t.name(),
                t.require("thrust_n")?,
                t.require("truth_thrust_n")?,
            )
        })
        .collect::<Result<_>>()?;
    let job = Inputs {
        settings,
        thrust_card,
        origin,
        progress,
    };
    let [paper, rich] = training.map(|(name, trials)| job.data_set(name, &trials, &validation));
    Ok(GroundEffectExperiment {
        sets: [paper?, rich?],
        moving: job.moving(&moving, &moving_unseen)?,
        recorded,
        validation,
        floor,
    })
}

/// What every part of the experiment needs.
struct Inputs<'a> {
    settings: &'a ReproduceSettings,
    thrust_card: &'a Card,
    origin: &'a Origin,
    progress: &'a dyn Progress,
}

impl Inputs<'_> {
    /// Records trials, fits every form to them and judges each by the validation trials.
    fn data_set(
        &self,
        name: &'static str,
        trials: &[RigTrial],
        validation: &[GroundTrial],
    ) -> Result<DataSet> {
        let identification = &self.settings.identification;
        let recorded = super::record(trials, self.settings, self.progress)?;
        let prepared = prepare(&recorded, self.thrust_card)?;
        let origin = &self.origin.with_inputs(&recorded);
        let before = identifiability::examine_trials(&prepared, identification)?;
        self.progress.step();
        let fitted: Vec<(FittedCard, Vec<ValidationErrors>)> = Form::GROUND_EFFECT
            .into_par_iter()
            .map(|form| {
                let mut made = rig::fit(form, &prepared, identification, origin)?;
                made.card.name =
                    format!("ground-effect-{}-{}", form.name(), name.replace('_', "-"));
                let judged = judge_all(&mut made.card, validation)?;
                self.progress.step();
                Ok((made, judged))
            })
            .collect::<Result<_>>()?;
        let (mut models, errors): (Vec<FittedCard>, Vec<Vec<ValidationErrors>>) =
            fitted.into_iter().unzip();
        for made in &mut models {
            run_freely(made, &spread(validation))?;
        }
        let fits: Vec<Fitted<'_>> = Form::GROUND_EFFECT
            .into_iter()
            .zip(models.iter().zip(&errors))
            .map(|(form, (made, judged))| Fitted {
                form,
                made,
                free_run_rmse_n: pooled_rmse_n(judged),
            })
            .collect();
        let levels = levels::compare(&prepared, validation, &fits, identification)?;
        self.progress.step();
        Ok(DataSet {
            name,
            recorded,
            before,
            models,
            errors,
            levels,
        })
    }

    /// Fits eq. (9) to trials in which vehicle and plate both move.
    fn moving(&self, trials: &[RigTrial], unseen: &[RigTrial]) -> Result<MovingTrials> {
        let identification = &self.settings.identification;
        let recorded = super::record(trials, self.settings, self.progress)?;
        let unseen = super::record(unseen, self.settings, self.progress)?;
        let prepared = prepare(&recorded, self.thrust_card)?;
        let origin = &self.origin.with_inputs(&recorded);
        let form = Form::Derivative;
        let mut made = rig::fit(form, &prepared, identification, origin)?;
        made.card.name = "ground-effect-derivative-moving-data".to_string();
        run_freely(&mut made, &prepare(&unseen, self.thrust_card)?)?;
        self.progress.step();
        Ok(MovingTrials {
            relative: relative::of_trials(&prepared, identification)?,
            printed: relative::of_printed()?,
            recorded,
            unseen,
            made,
        })
    }
}

fn prepare(trials: &[Trial], thrust_card: &Card) -> Result<Vec<GroundTrial>> {
    trials
        .par_iter()
        .map(|t| Ok(rig::prepare(t, thrust_card)?))
        .collect()
}

/// Of each kind of validation trial those at the least, the middle and the largest thrust: enough to compare the sizes of
/// a front.
fn spread(validation: &[GroundTrial]) -> Vec<GroundTrial> {
    let mut out = Vec::new();
    for kind in VALIDATION_KINDS {
        let of_kind: Vec<&GroundTrial> = validation
            .iter()
            .filter(|t| kind_of(&t.name) == kind)
            .collect();
        let step = (of_kind.len().saturating_sub(1) / 2).max(1);
        out.extend(of_kind.into_iter().step_by(step).cloned());
    }
    out
}

/// Free run of the best subset of every size over unseen trials.
fn run_freely(made: &mut FittedCard, unseen: &[GroundTrial]) -> Result<()> {
    if let Some(front) = &mut made.front {
        for terms in 0..front.sizes.len() {
            let card = front.card(&made.card, terms);
            front.sizes[terms].free_run_rmse_n = levels::free_run(&card, unseen)?;
        }
    }
    Ok(())
}

/// Errors of a card on every validation trial; those against the truth become scores of the card.
fn judge_all(card: &mut Card, validation: &[GroundTrial]) -> Result<Vec<ValidationErrors>> {
    let judged: Vec<ValidationErrors> = validation
        .iter()
        .map(|t| judge(card, t))
        .collect::<Result<_>>()?;
    for (trial, judged) in validation.iter().zip(&judged) {
        card.scores
            .push(score(&trial.name, false, "free_run", judged.truth, "N"));
    }
    Ok(judged)
}

/// Root mean square error against the truth over all trials.
fn pooled_rmse_n(judged: &[ValidationErrors]) -> Option<f64> {
    let truth: Vec<Errors> = judged.iter().map(|j| j.truth).collect();
    let rmse = Errors::pool(&truth)?.rmse;
    rmse.is_finite().then_some(rmse)
}

fn judge(card: &Card, trial: &GroundTrial) -> Result<ValidationErrors> {
    let predicted = rig::predict(card, trial)?;
    Ok(ValidationErrors {
        truth: compare(&trial.name, &predicted, trial.reference_n())?,
        raw: compare(&trial.name, &predicted, &trial.force_n)?,
    })
}

fn compare(name: &str, a: &[f64], b: &[f64]) -> Result<Errors> {
    Errors::of(a, b).ok_or_else(|| Error::data(name, "samples to compare", "none"))
}

impl GroundEffectExperiment {
    /// Errors of a model against the truth, over the validation trials of one kind.
    #[must_use]
    pub fn pooled(&self, set: usize, model: usize, kind: &str) -> Option<Errors> {
        self.pool(set, model, kind, |judged| judged.truth)
    }

    /// Errors of a model against the raw measurement, over the validation trials of one kind.
    #[must_use]
    pub fn pooled_raw(&self, set: usize, model: usize, kind: &str) -> Option<Errors> {
        self.pool(set, model, kind, |judged| judged.raw)
    }

    fn pool(
        &self,
        set: usize,
        model: usize,
        kind: &str,
        pick: fn(&ValidationErrors) -> Errors,
    ) -> Option<Errors> {
        let of_kind: Vec<Errors> = self
            .validation
            .iter()
            .zip(&self.sets[set].errors[model])
            .filter(|(t, _)| kind_of(&t.name) == kind)
            .map(|(_, judged)| pick(judged))
            .collect();
        Errors::pool(&of_kind)
    }

    /// The measurement's own noise, over the validation trials of one kind.
    #[must_use]
    pub fn pooled_floor(&self, kind: &str) -> Option<Errors> {
        let of_kind: Vec<Errors> = self
            .validation
            .iter()
            .zip(&self.floor)
            .filter(|(t, _)| kind_of(&t.name) == kind)
            .map(|(_, floor)| *floor)
            .collect();
        Errors::pool(&of_kind)
    }

    /// The card of a form, fitted on a data set.
    #[must_use]
    pub fn card(&self, set: usize, form: Form) -> Option<&Card> {
        let model = Form::GROUND_EFFECT.iter().position(|f| *f == form)?;
        self.sets[set].models.get(model).map(|m| &m.card)
    }
}
