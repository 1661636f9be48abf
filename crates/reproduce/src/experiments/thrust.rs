//! IV-B.1: throttle to thrust, eq. (7) and eq. (8), with the plate at 0.75 m and without it.

use touchdown_model::Card;
use touchdown_sim::rig::sets;
use touchdown_trial::Trial;

use crate::error::{Error, Result};
use crate::settings::ReproduceSettings;
use touchdown_campaign::progress::Progress;
use touchdown_identify::fitted::score;
use touchdown_identify::scores::Errors;
use touchdown_identify::settings::DeadTime;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, thrust};

/// The models that are compared, by their names in results.
pub const MODELS: [&str; 3] = ["eq8", "eq7", "eq8_as_published"];
/// The validation trials.
pub const KINDS: [&str; 2] = ["ramp", "sine"];

/// The experiment with one state of the plate.
#[derive(Clone, Debug)]
pub struct PlateState {
    /// Whether the plate was at 0.75 m (else removed).
    pub plate_present: bool,
    /// The training trials.
    pub training: Vec<Trial>,
    /// The validation trials.
    pub validation: Vec<Trial>,
    /// The models, in the order of [`MODELS`].
    pub models: Vec<FittedCard>,
    /// Free runs on the validation trials: `[model][trial]`.
    pub runs: Vec<Vec<FreeRun>>,
}

/// A free run on a validation trial.
#[derive(Clone, Debug)]
pub struct FreeRun {
    /// Kind of the trial.
    pub kind: &'static str,
    /// Prediction (N).
    pub predicted_n: Vec<f64>,
    /// Errors against the plant's own thrust without ground effect, shifted by the rig's nominal latency.
    pub errors: Errors,
    /// Errors against the raw measurement.
    pub raw: Errors,
    /// The measurement's own noise: raw against the plant's own force.
    pub floor: Errors,
}

/// Runs the experiment.
///
/// # Errors
/// Settings that make no sense.
pub fn run(
    settings: &ReproduceSettings,
    origin: &Origin,
    progress: &dyn Progress,
) -> Result<[PlateState; 2]> {
    let sets = [true, false].map(|plate_present| {
        (
            plate_present,
            sets::thrust_training(plate_present, super::extent(settings)),
            sets::thrust_validation(plate_present),
        )
    });
    let steps = sets
        .iter()
        .map(|(_, t, v)| t.len() + v.len() + MODELS.len())
        .sum::<usize>();
    progress.stage("throttle to thrust", steps as u64);
    let [present, removed] = sets.map(
        |(plate_present, training, validation)| -> Result<PlateState> {
            let training = super::record(&training, settings, progress)?;
            let validation = super::record(&validation, settings, progress)?;
            let origin = &origin.with_inputs(&training);
            let mut models = Vec::new();
            for model in MODELS {
                models.push(fit(
                    model,
                    &training,
                    &settings.identification,
                    origin,
                    plate_present,
                )?);
                progress.step();
            }
            let mut runs = Vec::new();
            for made in &mut models {
                let of_model: Vec<FreeRun> = KINDS
                    .into_iter()
                    .map(|kind| free_run(&made.card, kind, named(&validation, kind)?))
                    .collect::<Result<_>>()?;
                for run in &of_model {
                    made.card
                        .scores
                        .push(score(run.kind, false, "free_run", run.errors, "N"));
                }
                runs.push(of_model);
            }
            Ok(PlateState {
                plate_present,
                training,
                validation,
                models,
                runs,
            })
        },
    );
    Ok([present?, removed?])
}

fn fit(
    model: &str,
    training: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
    plate_present: bool,
) -> Result<FittedCard> {
    let mut settings = settings.clone();
    let mut made = match model {
        "eq7" => {
            // Eq. (7) of the paper has no dead time: its lag takes it in.
            settings.thrust.dead_time = DeadTime::None;
            thrust::first_order(training, &settings, origin)?
        }
        "eq8" => thrust::library(training, &of_the_rig(&settings), origin)?,
        _ => {
            // To the letter: the measured signals as they are stamped, regression on derivatives alone.
            settings.thrust.dead_time = DeadTime::None;
            settings.thrust.refine = false;
            settings.smoothing.thrust_window = settings.smoothing.window;
            thrust::library(training, &settings, origin)?
        }
    };
    let plate = if plate_present {
        "plate-present"
    } else {
        "plate-removed"
    };
    made.card.name = format!("thrust-{}-{plate}", model.replace('_', "-"));
    Ok(made)
}

/// The settings of eq. (8) on the virtual rig, whose throttle is smooth and sampled fast: there the dead time by regression
/// is as good as that in free run, and far quicker.
pub(super) fn of_the_rig(settings: &IdentificationSettings) -> IdentificationSettings {
    let mut settings = settings.clone();
    if settings.thrust.dead_time == DeadTime::Auto {
        settings.thrust.dead_time = DeadTime::Regression;
    }
    settings
}

fn named<'a>(trials: &'a [Trial], kind: &str) -> Result<&'a Trial> {
    trials
        .iter()
        .find(|t| t.name().contains(kind))
        .ok_or_else(|| Error::data("validation", format!("a trial `{kind}`"), "none"))
}

fn free_run(card: &Card, kind: &'static str, trial: &Trial) -> Result<FreeRun> {
    let predicted_n = thrust::predict(card, trial)?;
    let measured = trial.require("thrust_n")?;
    let errors = |a: &[f64], b: &[f64]| {
        Errors::of(a, b).ok_or_else(|| Error::data(trial.name(), "samples to compare", "none"))
    };
    Ok(FreeRun {
        kind,
        errors: errors(&predicted_n, trial.require("truth_free_air_n")?)?,
        raw: errors(&predicted_n, measured)?,
        floor: errors(measured, trial.require("truth_thrust_n")?)?,
        predicted_n,
    })
}
