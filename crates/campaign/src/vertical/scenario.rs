//! The scenario file of vertical landings.

use serde::{Deserialize, Serialize};
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::vertical::LandingScenario;

use touchdown_flight::Method;
use touchdown_flight::method::VerticalSettings;

use super::controllers;
use super::settings::LandSettings;
use crate::cards::CardPaths;
use crate::error::{Error, Result};
use crate::measured_deck::SeriesSettings;
use crate::settings_file::check_seed;
use crate::vehicle::VehicleSettings;

/// What `touchdown land` runs.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandScenario {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Landings of every method.
    pub trials: usize,
    /// The methods.
    pub controllers: Vec<Method>,
    /// Whether the deck's acceleration is estimated and fed forward.
    pub deck_acceleration: bool,
    /// Model cards.
    pub cards: CardPaths,
    /// What is known of the vehicle beside its cards.
    pub vehicle: VehicleSettings,
    /// A measured motion of the deck, in place of `scenario.deck`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<SeriesSettings>,
    /// The controllers' settings.
    pub control: VerticalSettings<f64>,
    /// Vehicle, air, deck, sensors and spreads.
    pub scenario: LandingScenario,
}

impl Default for LandScenario {
    fn default() -> Self {
        let deck = LandSettings::deck();
        Self {
            seed: 1,
            trials: 40,
            controllers: Method::VERTICAL.to_vec(),
            deck_acceleration: true,
            cards: CardPaths::default(),
            vehicle: VehicleSettings::default(),
            series: None,
            control: deck.control,
            scenario: deck.scenario,
        }
    }
}

impl LandScenario {
    /// Landing settings: scenario and controllers.
    #[must_use]
    pub fn land(&self) -> LandSettings {
        LandSettings {
            scenario: self.scenario,
            control: self.control,
        }
    }

    /// Checks all settings; `file` names them in errors.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn check(&self, file: &str) -> Result<()> {
        let bad = |key: &str, message: String| Error::Settings {
            file: file.to_string(),
            message: format!("key `{key}`: {message}"),
        };
        check_seed(self.seed, file)?;
        self.vehicle.check(file)?;
        let prescribed = [DeckMotion::Still, Self::default().scenario.deck];
        if self.series.is_some() && !prescribed.contains(&self.scenario.deck) {
            return Err(bad(
                "series",
                "the deck moves as measured: remove `scenario.deck`".to_string(),
            ));
        }
        if !(1..=1_000_000).contains(&self.trials) {
            return Err(bad(
                "trials",
                format!("expected 1 to 1000000, found {}", self.trials),
            ));
        }
        let names = Method::VERTICAL.map(Method::name);
        if self.controllers.is_empty() {
            return Err(bad(
                "controllers",
                format!("expected some of {}; found none", names.join(", ")),
            ));
        }
        if let Some(method) = self
            .controllers
            .iter()
            .find(|m| !Method::VERTICAL.contains(m))
        {
            return Err(bad(
                "controllers",
                format!(
                    "`{}` needs six degrees of freedom (--space); expected some of {}",
                    method.name(),
                    names.join(", ")
                ),
            ));
        }
        for (i, method) in self.controllers.iter().enumerate() {
            if self.controllers[..i].contains(method) {
                return Err(bad(
                    "controllers",
                    format!("`{}` stands twice", method.name()),
                ));
            }
        }
        self.scenario
            .validate()
            .map_err(|e| bad("scenario", e.to_string()))?;
        controllers::check(&self.land()).map_err(|(key, message)| bad(&key, message))
    }
}
