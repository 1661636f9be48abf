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
    let mut made = match form {
        GroundEffectForm::Empirical => statics::empirical(trials, settings, origin),
        GroundEffectForm::Static => statics::map(trials, settings, origin),
        GroundEffectForm::Derivative => derivative::fit(trials, settings, origin),
        GroundEffectForm::Ratio => dynamic::ratio(trials, settings, origin),
        GroundEffectForm::Lag => dynamic::lag(trials, settings, origin),
    }?;
    trial::validity(&mut made.card, trials, settings);
    made.card.warnings.extend(sentences(&made.warnings));
    Ok(made)
}
