//! Model cards that landings are flown with, by their paths.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use touchdown_flight::ground_effect::GroundEffectModel;
use touchdown_flight::thrust::ThrustModel;
use touchdown_lander::models::FlightModels;
use touchdown_model::Card;

use crate::error::{Error, Result};

/// Paths of model cards, relative to the scenario file; a model without a card is identified on the virtual
/// rig first.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct CardPaths {
    /// Throttle to thrust.
    pub thrust: Option<PathBuf>,
    /// Eq. (2), for `empirical`.
    pub empirical: Option<PathBuf>,
    /// The model of `dynamic`: any ground-effect form.
    pub dynamic: Option<PathBuf>,
}

impl CardPaths {
    /// The same with relative paths taken from `folder`.
    #[must_use]
    pub fn from(self, folder: &Path) -> Self {
        let join = |p: Option<PathBuf>| p.map(|p| folder.join(p));
        Self {
            thrust: join(self.thrust),
            empirical: join(self.empirical),
            dynamic: join(self.dynamic),
        }
    }
}

impl CardPaths {
    /// Puts the models of the cards that are given in place of others; `model` makes that of thrust for the vehicle's rotors.
    /// Returns the thrust card.
    ///
    /// # Errors
    /// Cards that cannot be read or flown.
    pub fn put_into(
        &self,
        model: &dyn Fn(&Card) -> Result<ThrustModel<f64>>,
        models: &mut FlightModels<f64>,
    ) -> Result<Option<Card>> {
        let read = |path: &Option<PathBuf>| path.as_deref().map(Card::read).transpose();
        let thrust = read(&self.thrust)?;
        put_into(
            None,
            read(&self.empirical)?.as_ref(),
            read(&self.dynamic)?.as_ref(),
            models,
        )?;
        if let Some(card) = &thrust {
            models.thrust = model(card)?;
        }
        Ok(thrust)
    }
}

/// Puts the models of cards in place of others.
///
/// # Errors
/// Cards that cannot be flown.
pub fn put_into(
    thrust: Option<&Card>,
    empirical: Option<&Card>,
    dynamic: Option<&Card>,
    models: &mut FlightModels<f64>,
) -> Result<()> {
    if let Some(card) = thrust {
        models.thrust = card.thrust_model_of(None)?;
    }
    if let Some(card) = dynamic {
        models.dynamic = card.ground_effect()?;
    }
    if let Some(card) = empirical {
        let GroundEffectModel::Empirical(law) = card.ground_effect()?.model else {
            return Err(Error::Arguments(format!(
                "`empirical` needs a card of form `empirical` (eq. 2); card `{}` is of form {:?}",
                card.name, card.form
            )));
        };
        models.mu = law.mu;
    }
    Ok(())
}
