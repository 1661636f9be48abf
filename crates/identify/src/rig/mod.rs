//! Ground-effect models from trials in which thrust and height were measured.
//!
//! The force is what the load cell measures beyond the free-air thrust, `f = F - T̂`, where `T̂` is the
//! free run of a thrust card on the trial's own throttle. [`GroundTrial`] holds it; [`fit`] makes a card
//! of any form from it; [`identifiability`] says what the data identify, [`levels`] sets the levels of identification side by
//! side, [`relative`] asks whether eq. (9) needs both velocities.

mod derivative;
mod dynamic;
pub mod identifiability;
pub mod levels;
pub mod relative;
mod statics;
mod trial;

pub use trial::{GroundTrial, predict, prepare};

use derivative::Derivative;
use dynamic::DynamicForm;
use statics::{Empirical, StaticMap};

use crate::error::Result;
use crate::fitted::{FittedCard, Origin};
use crate::settings::{GroundEffectForm, IdentificationSettings};
use crate::warning::sentences;

/// Fits one form to `trials`.
///
/// # Errors
/// Too few trials, or data that the form cannot be fitted to.
pub fn fit(
    form: GroundEffectForm,
    trials: &[GroundTrial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let lengths_m = settings.ground_effect.lengths_m;
    let mut fitted = match form {
        GroundEffectForm::Empirical => {
            let radius_m = origin.vehicle.rotor_radius_m;
            let radius_m = radius_m.unwrap_or(settings.ground_effect.rotor_radius_m);
            Empirical::fit(trials, settings, radius_m)?.card(origin)
        }
        GroundEffectForm::Static => StaticMap::fit(trials, lengths_m)?.card(origin),
        GroundEffectForm::Derivative => Derivative::fit(trials, settings)?.card(settings, origin),
        GroundEffectForm::Ratio => {
            let form = DynamicForm::ratio(trials, settings)?;
            form.fit(trials, settings)?.card(settings, origin)
        }
        GroundEffectForm::Lag => {
            let form = DynamicForm::lag(trials, settings)?;
            form.fit(trials, settings)?.card(settings, origin)
        }
    };
    fitted.check_finite()?;
    trial::validity(&mut fitted.card, trials, settings);
    fitted.card.warnings.extend(sentences(&fitted.warnings));
    Ok(fitted)
}
