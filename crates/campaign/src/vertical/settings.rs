//! Settings of a vertical landing and its controllers.

use serde::{Deserialize, Serialize};
use touchdown_flight::method::{C_DECK_PER_S, VerticalSettings};
use touchdown_sim::landing::vertical::LandingScenario;

/// A landing: what is landed on, and the controllers.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandSettings {
    /// Vehicle, air, deck, sensors and spreads.
    pub scenario: LandingScenario,
    /// The controllers.
    pub control: VerticalSettings<f64>,
}

impl Default for LandSettings {
    fn default() -> Self {
        Self::ground()
    }
}

impl LandSettings {
    /// The landing on the ground (IV-C).
    #[must_use]
    pub fn ground() -> Self {
        Self {
            scenario: LandingScenario::default(),
            control: VerticalSettings::default(),
        }
    }

    /// The landing on the oscillating deck (IV-D).
    #[must_use]
    pub fn deck() -> Self {
        Self {
            scenario: LandingScenario::oscillating_deck(),
            control: VerticalSettings {
                c_per_s: C_DECK_PER_S,
                ..VerticalSettings::default()
            },
        }
    }
}
