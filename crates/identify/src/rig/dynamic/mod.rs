//! Multiple shooting of forms with memory, and of the terms of eq. (9).

mod forms;

use std::borrow::Cow;
use std::collections::BTreeMap;

use sindy::SavitzkyGolay;
use sindy::statistics::regression::Clusters;
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Refined, Shooting};
use touchdown_model::flight::psi_definitions;
use touchdown_model::{Form, Kind};

use super::GroundTrial;
use super::between::FineTrial;
use super::trial::{clusters, greatest_n, records, rows};
use crate::error::Result;
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, outcome};
use crate::settings::IdentificationSettings;
use crate::warning::Warning;

/// Standard deviation of the prior on a window's start, in units of f/T.
/// A half of the effect at one radius: the start of a window is nearly free.
const START_SD: f64 = 0.05;
/// Standard deviation of the prior on a window's start in newtons: that of f/T at the weight of a small vehicle.
/// As above. A window of fifty lags hardly depends on it.
const START_SD_N: f64 = 0.5;
/// Correlation of two estimates from which they count as confounded.
/// Variance inflation of ten, the limit that is used for the data as well.
const CONFOUNDED: f64 = 0.95;
/// Share of a bound by which a lag may miss it and still count as at the bound.
/// The steps of the search end far closer; ten times as much would warn of lags that the data identify.
const AT_BOUND: f64 = 1e-3;

/// One parameter: its name in the equations, its place in the card, and where the search starts.
struct Place {
    name: &'static str,
    of: &'static str,
    expression: &'static str,
    unit: String,
    start: Parameter,
}

/// A form with memory in the ratio f/T: its card's head, its equations, and its parameters, memory first.
struct DynamicForm {
    name: &'static str,
    form: Form,
    equation: &'static str,
    state: &'static str,
    rhs: String,
    output: String,
    places: Vec<Place>,
    lag_s: fn(&[f64]) -> f64,
}

impl DynamicForm {
    /// Fits the form by multiple shooting.
    fn fit(self, trials: &[GroundTrial], settings: &IdentificationSettings) -> Result<DynamicFit> {
        let names: Vec<&str> = self.places.iter().map(|p| p.name).collect();
        let parameters: Vec<Parameter> = self.places.iter().map(|p| p.start).collect();
        let model = OdeModel::new(
            &[self.state],
            &["T", "z", "v_p"],
            &names,
            &[&self.rhs],
            &self.output,
        )?;
        let guesses: Vec<Vec<f64>> = trials
            .iter()
            .zip(&smooth_forces(trials, settings)?)
            .map(|(t, smooth)| {
                let thrust = t.free_air_thrust_n.iter();
                smooth.iter().zip(thrust).map(|(f, t)| f / t).collect()
            })
            .collect();
        let fine = FineLogs::of(trials, guesses);
        let records = records(&fine.trials, Some(&fine.guesses), |t| {
            [&t.free_air_thrust_n, &t.height_m, &t.deck_velocity_mps].map(Vec::as_slice)
        });
        let shooting = fine.shooting(settings, START_SD);
        let refined = refine(&model, &records, settings, shooting, &parameters)?;
        Ok(DynamicFit {
            // A coefficient at its bound, or of a channel that is zero, is not estimated.
            clusters: clusters(
                trials,
                refined.std_errors.iter().filter(|e| e.is_finite()).count(),
            ),
            rows: rows(trials),
            form: self,
            refined,
        })
    }
}

/// Fits a form with memory.
///
/// # Errors
/// A form that [`DynamicForm::of`] lacks, or data that the form cannot be fitted to.
pub(super) fn fit(
    form: Form,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let form = DynamicForm::of(form, trials, settings)?;
    Ok(form.fit(trials, settings)?.card(settings, origin))
}

/// A form with memory, fitted.
struct DynamicFit {
    form: DynamicForm,
    refined: Refined,
    clusters: Clusters,
    rows: usize,
}

impl DynamicFit {
    fn lag_s(&self) -> f64 {
        (self.form.lag_s)(&self.refined.parameters)
    }

    fn card(&self, settings: &IdentificationSettings, origin: &Origin) -> FittedCard {
        let (form, refined) = (&self.form, &self.refined);
        let mut card = origin.card(form.name, Kind::GroundEffect, form.form, form.equation);
        (card.constants, card.definitions) = psi_definitions(settings.ground_effect.lengths_m());
        let estimates = Estimate::refined(refined, self.clusters);
        for (place, estimate) in form.places.iter().zip(estimates) {
            card.terms
                .push(term(place.of, place.expression, estimate, &place.unit));
        }
        card.provenance.method = self.method(settings);
        FittedCard {
            lag_s: Some(self.lag_s()),
            warnings: self.warnings(settings.ground_effect.lag_bounds_s),
            ..FittedCard::new(card, (refined.rmse, "N"), self.rows)
        }
    }

    /// How it was fitted, by key.
    fn method(&self, settings: &IdentificationSettings) -> BTreeMap<String, String> {
        let shooting = &settings.shooting;
        method(&[
            (
                "fit",
                format!(
                    "multiple shooting, windows of {} s every {} s, every {} samples, start of each window free",
                    shooting.window_s, shooting.stride_s, shooting.every
                ),
            ),
            ("start", "static map by least squares".into()),
            ("outcome", outcome(&self.refined)),
        ])
    }

    /// A lag that is confounded with an effect of velocity, or at a bound of its search.
    fn warnings(&self, [lo, hi]: [f64; 2]) -> Vec<Warning> {
        let names: Vec<&str> = self.form.places.iter().map(|p| p.name).collect();
        let velocity = |name: &str| name.contains('v') || name.starts_with('k');
        let memory = |name: &str| name == "tau" || name == "ay";
        let mut warnings = Vec::new();
        for b in 0..names.len() {
            for a in 0..b {
                let correlation = self.refined.correlation[(a, b)];
                let pair = memory(names[a]) && velocity(names[b]);
                if pair && correlation.abs() > CONFOUNDED {
                    warnings.push(Warning::LagConfounded {
                        pair: [a, b].map(|k| names[k].to_string()),
                        correlation,
                    });
                }
            }
        }
        let lag_s = self.lag_s();
        if lag_s <= lo * (1.0 + AT_BOUND) || lag_s >= hi * (1.0 - AT_BOUND) {
            warnings.push(Warning::LagAtBound { lag_s });
        }
        warnings
    }
}

/// The terms of eq. (9), refined in free run from the coefficients of a regression.
pub(super) fn polynomial(
    trials: &[GroundTrial],
    terms: &[(&str, f64)],
    settings: &IdentificationSettings,
) -> Result<Refined> {
    let names: Vec<String> = (0..terms.len()).map(|k| format!("c{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let rhs: Vec<String> = terms
        .iter()
        .zip(&names)
        .map(|((term, _), name)| format!("{name}*({term})"))
        .collect();
    let model = OdeModel::new(
        &["f"],
        &["s", "z", "v_p", "v_q"],
        &names,
        &[&rhs.join(" + ")],
        "f",
    )?;
    // As in eq. (8): a prior of the coefficients' own size keeps the search from wandering along directions that
    // the data do not identify.
    let parameters: Vec<Parameter> = terms
        .iter()
        .map(|(_, v)| Parameter::free(*v).prior(v.abs().max(1.0)))
        .collect();
    let fine = FineLogs::of(trials, smooth_forces(trials, settings)?);
    let records = records(&fine.trials, Some(&fine.guesses), |t| {
        [
            &t.throttle,
            &t.height_m,
            &t.deck_velocity_mps,
            &t.vehicle_velocity_mps,
        ]
        .map(Vec::as_slice)
    });
    let shooting = fine.shooting(settings, START_SD_N);
    refine(&model, &records, settings, shooting, &parameters)
}

/// Logs with rows between theirs where they are slow, and the states to start from in all rows.
struct FineLogs<'a> {
    trials: Cow<'a, [GroundTrial]>,
    guesses: Vec<Vec<f64>>,
}

impl<'a> FineLogs<'a> {
    fn of(trials: &'a [GroundTrial], guesses: Vec<Vec<f64>>) -> Self {
        let fine: Vec<Option<FineTrial>> = trials.iter().map(FineTrial::of).collect();
        if fine.iter().all(Option::is_none) {
            return Self {
                trials: Cow::Borrowed(trials),
                guesses,
            };
        }
        let pairs = fine.into_iter().zip(trials).zip(guesses);
        let (trials, guesses): (Vec<_>, _) = pairs
            .map(|((fine, trial), guess)| match fine {
                Some(fine) => {
                    let guess = fine.joined(trial, &guess);
                    (fine.trial, guess)
                }
                None => (trial.clone(), guess),
            })
            .unzip();
        Self {
            trials: Cow::Owned(trials),
            guesses,
        }
    }

    /// Residuals in every row where a log is slow: the rows between have none, and each of its own counts.
    fn shooting(&self, settings: &IdentificationSettings, start_sd: f64) -> Shooting {
        let shooting = settings.shooting.build(start_sd, greatest_n(&self.trials));
        let every = match self.trials {
            Cow::Borrowed(_) => shooting.every,
            Cow::Owned(_) => 1,
        };
        Shooting { every, ..shooting }
    }
}

fn smooth_forces(
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
) -> Result<Vec<Vec<f64>>> {
    let filter = SavitzkyGolay::new(settings.smoothing.window, settings.smoothing.degree)?;
    trials
        .iter()
        .map(|t| Ok(t.smooth_force(&filter)?.value))
        .collect()
}

fn refine(
    model: &OdeModel,
    records: &[Record<'_>],
    settings: &IdentificationSettings,
    shooting: Shooting,
    parameters: &[Parameter],
) -> Result<Refined> {
    // Over holes the model is integrated in steps that the shortest lag of the search allows.
    let step_s = 0.6 * settings.ground_effect.lag_bounds_s[0];
    let model = model.clone().with_max_step(step_s)?;
    Ok(shooting.refine(&model, records, parameters)?)
}
