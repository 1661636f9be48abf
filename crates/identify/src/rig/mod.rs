//! Ground-effect models from trials in which thrust and height were measured.
//!
//! The force is what the load cell measures beyond the free-air thrust, `f = F - T̂`, where `T̂` is the
//! free run of a thrust card on the trial's own throttle. [`GroundTrial`] holds it; `data_check` asks whether units, signs and
//! zeros of the channels can be right; [`fit`] makes a card
//! of any form from it, [`forms`] cards of all forms; [`identifiability`] says what the data identify, [`levels`] sets the levels of identification side by
//! side, [`relative`] asks whether eq. (9) needs both velocities.

mod between;
pub(crate) mod data_check;
mod derivative;
mod dynamic;
pub mod forms;
pub mod identifiability;
pub mod levels;
pub mod relative;
mod statics;
mod trial;

pub use data_check::DataWarning;
pub use trial::{GroundTrial, predict, prepare, without_gaps};

use derivative::Derivative;
use touchdown_model::Form;

use crate::error::Result;
use crate::fitted::{FittedCard, Origin};
use crate::settings::IdentificationSettings;
use crate::warning::{Warning, sentences};

/// Fits one form to `trials`.
///
/// # Errors
/// Too few trials, a form that is none of the ground effect, heights or thrusts that no force rig measures, or data that the
/// form cannot be fitted to.
pub fn fit(
    form: Form,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let doubts = data_check::check(trials, &settings.ground_effect)?;
    let memory = form.entry().is_some_and(|entry| entry.state.is_some());
    let mut fitted = match form {
        Form::Derivative => Derivative::fit(trials, settings)?.card(settings, origin),
        _ if memory => dynamic::fit(form, trials, settings, origin)?,
        _ => statics::fit(form, trials, settings, origin)?,
    };
    fitted.check_finite()?;
    trial::validity(&mut fitted.card, trials, settings);
    let mut estimated = fitted.card.terms.len();
    if memory {
        let zero = trial::zero_terms(&fitted.card, trials);
        estimated -= zero.len();
        if !zero.is_empty() {
            fitted.warnings.push(Warning::ZeroTerms(zero));
        }
        let mut most_n = 0.0;
        for trial in trials {
            // A model of which no term is left has no free run.
            let predicted = predict(&fitted.card, trial).unwrap_or_default();
            most_n = predicted
                .into_iter()
                .map(|f| if f.is_nan() { f64::INFINITY } else { f.abs() })
                .fold(most_n, f64::max);
        }
        let forces = trials.iter().flat_map(|trial| &trial.force_n);
        let largest_n = forces
            .filter(|f| f.is_finite())
            .fold(0.0, |most, f| f.abs().max(most));
        fitted.judge_divergence(most_n, largest_n, "N");
    }
    if trials.len() <= estimated {
        fitted.warnings.push(Warning::TooFewLogs {
            logs: trials.len(),
            coefficients: estimated,
        });
    }
    fitted.card.warnings.extend(sentences(&fitted.warnings));
    let doubts = doubts.iter().map(ToString::to_string);
    fitted.card.warnings.extend(doubts);
    Ok(fitted)
}
