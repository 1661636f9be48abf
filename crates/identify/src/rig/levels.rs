//! The three levels of identification side by side, on unseen trials.
//!
//! 1. As published: eq. (9) by SR3 to the letter, unscaled, the sparse vector taken as it is.
//! 2. SR3 done right: scaled columns, λ and ν chosen on held-out trials, refit; the best subset by exact search; the
//!    weak form, which needs no derivative.
//! 3. Judged by free run: the terms of level 2 refined by multiple shooting, the ratio form, the lag form.
//!
//! The static map, which has no dynamics at all, stands before them.

use rayon::prelude::*;
use serde::Serialize;
use sindy::solve::sr3::Scaling;
use sindy::{Gram, Library, Sr3};
use touchdown_model::Form;

use super::GroundTrial;
use super::derivative::{live_library, samples};
use super::dynamic::polynomial;
use super::trial::predict_by;
use crate::error::Result;
use crate::fitted::FittedCard;
use crate::front::with_terms;
use crate::prediction::Predictor;
use crate::scores::Errors;
use crate::settings::IdentificationSettings;
use crate::sparse_fit::sparse_fit;

/// One way of identification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Level {
    /// 1, 2, 3; 0 for the static map.
    pub level: u8,
    /// Its name in results.
    pub model: &'static str,
    /// Coefficients that it fits (without those that are zero).
    pub terms: usize,
    /// Root mean square error of f' (N/s) on unseen trials, against their own smoothed derivative; absent for models
    /// that have no equation for f'.
    pub held_out_rmse_n_per_s: Option<f64>,
    /// Root mean square error of f in free run (N) on unseen trials; absent where a run has no end.
    pub free_run_rmse_n: Option<f64>,
}

/// A form that is fitted already, with its error in free run on the unseen trials, where that is known too.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// The form.
    pub form: Form,
    /// Its fit to the training trials.
    pub made: &'a FittedCard,
    /// Root mean square error in free run on the unseen trials (N).
    pub free_run_rmse_n: Option<f64>,
}

/// Fits what is missing to `training` and judges everything on `unseen`. Forms that `fitted` lacks are left out, as
/// are eq. (9)'s rows where the data do not identify it.
///
/// # Errors
/// A card that does not run on the unseen trials, or unseen trials that cannot be differentiated.
pub fn compare(
    training: &[GroundTrial],
    unseen: &[GroundTrial],
    fitted: &[Fitted<'_>],
    settings: &IdentificationSettings,
) -> Result<Vec<Level>> {
    let of = |form| fitted.iter().find(|f| f.form == form);
    let mut out = Vec::new();
    let simple = |level, form: Form| -> Result<Option<Level>> {
        let Some(f) = of(form) else { return Ok(None) };
        Ok(Some(Level {
            level,
            model: form.name(),
            terms: f.made.card.terms.len(),
            held_out_rmse_n_per_s: None,
            free_run_rmse_n: match f.free_run_rmse_n {
                Some(rmse) => Some(rmse),
                None => free_run(&f.made.card, unseen)?,
            },
        }))
    };
    out.extend(simple(0, Form::Static)?);
    if let Some(f) = of(Form::Derivative) {
        out.extend(of_derivative(training, unseen, f, settings)?);
    }
    out.extend(simple(3, Form::Ratio)?);
    out.extend(simple(3, Form::Lag)?);
    Ok(out)
}

/// The models that have an equation for f'.
fn of_derivative(
    training: &[GroundTrial],
    unseen: &[GroundTrial],
    fitted: &Fitted<'_>,
    settings: &IdentificationSettings,
) -> Result<Vec<Level>> {
    let columns = samples(training, settings)?;
    let (library, grams) = live_library(&columns, settings)?;
    let total = Gram::total(&grams);
    let held_out = Gram::total(&Gram::accumulate(
        &library,
        "f_dot",
        &samples(unseen, settings)?,
    )?);
    let card = &fitted.made.card;
    let level = |level: u8, model: &'static str, xi: &[f64], known: Option<f64>| -> Result<Level> {
        let kept = || (0..library.len()).filter(|&j| xi[j] != 0.0);
        let names = library.names();
        let free_run_rmse_n = match known {
            Some(rmse) => Some(rmse),
            None => {
                let terms = kept().map(|j| (names[j].as_str(), xi[j]));
                free_run(&with_terms(card, "f'", terms), unseen)?
            }
        };
        let xi = nalgebra::DVector::from_column_slice(xi);
        Ok(Level {
            level,
            model,
            terms: xi.iter().filter(|v| **v != 0.0).count(),
            held_out_rmse_n_per_s: Some(
                (held_out.residual_sum(&xi) / held_out.rows.max(1) as f64).sqrt(),
            ),
            free_run_rmse_n,
        })
    };
    let p = settings.published;
    let lambda = p.threshold * p.threshold / (2.0 * p.nu);
    let published = Sr3::new(lambda, p.nu)?.scaling(Scaling::None).solve(&total);
    let of_card: Vec<f64> = library
        .names()
        .iter()
        .map(|n| card.coefficient("f'", n))
        .collect();
    let mut out = vec![
        level(1, "sr3_to_the_letter", published.sparse.as_slice(), None)?,
        level(2, "derivative", &of_card, fitted.free_run_rmse_n)?,
    ];
    if let Some(front) = &fitted.made.front {
        let size = &front.sizes[front.chosen_terms];
        let xi = on_library(&library, &size.terms, &size.coefficients);
        out.push(level(2, "best_subset", &xi, None)?);
    }
    if let Some(xi) = weak(training, &library, settings)? {
        out.push(level(2, "weak_form", &xi, None)?);
    }
    let start: Vec<(&str, f64)> = library
        .names()
        .iter()
        .map(String::as_str)
        .zip(of_card)
        .filter(|(_, v)| *v != 0.0)
        .collect();
    let refined = polynomial(training, &start, settings)?;
    let names: Vec<String> = start.iter().map(|(n, _)| (*n).to_string()).collect();
    let xi = on_library(&library, &names, &refined.parameters);
    out.push(level(3, "refined", &xi, None)?);
    Ok(out)
}

/// Coefficients of some terms over the whole library.
fn on_library(library: &Library, terms: &[String], values: &[f64]) -> Vec<f64> {
    let of = |name: &String| {
        let at = terms.iter().position(|t| t == name);
        at.map_or(0.0, |k| values[k])
    };
    library.names().iter().map(of).collect()
}

/// Eq. (9) in the weak form, chosen as the settings say. `None` where no window fits into the data.
fn weak(
    training: &[GroundTrial],
    library: &Library,
    settings: &IdentificationSettings,
) -> Result<Option<Vec<f64>>> {
    let mut samples = sindy::Samples::new(&["t", "f", "s", "z", "v_p", "v_q"]);
    for t in training {
        samples.push_group(vec![
            t.time_s.clone(),
            t.force_n.clone(),
            t.throttle.clone(),
            t.height_m.clone(),
            t.deck_velocity_mps.clone(),
            t.vehicle_velocity_mps.clone(),
        ])?;
    }
    let system = match settings
        .weak
        .build()?
        .system(library, "t", &["f"], &samples)
    {
        Ok(system) => system,
        Err(sindy::SindyError::TooShort { .. }) => return Ok(None),
        Err(e) => return Err(e.into()),
    };
    let chosen = sparse_fit(&system.grams[0], settings)?;
    Ok(Some(chosen.fit.coefficients.as_slice().to_vec()))
}

/// Root mean square error in free run over `trials` (N); `None` where a run blows up.
pub fn free_run(card: &touchdown_model::Card, trials: &[GroundTrial]) -> Result<Option<f64>> {
    let predictor = Predictor::new(card)?;
    let errors: Vec<Errors> = trials
        .par_iter()
        .filter_map(|trial| match predict_by(&predictor, trial) {
            Ok(predicted) => Errors::of(&predicted, trial.reference_n()).map(Ok),
            Err(e) => Some(Err(e)),
        })
        .collect::<Result<_>>()?;
    Ok(Errors::pool(&errors)
        .map(|e| e.rmse)
        .filter(|rmse| rmse.is_finite()))
}
