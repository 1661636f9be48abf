//! Airwake: the air behind a deckhouse, slower and more turbulent than the free wind.
//!
//! ```text
//! mean        U (1 - δ f(z)),      δ = min(0.6, 1.2 (x/H)^(-3/2))
//! turbulence  σ = 0.35 δ f(z) U (1, 0.8, 0.6) along, across, vertical;   length H/2
//! height      f = 1 up to H, (1 + cos(2π (z/H - 1)))/2 up to 3H/2, 0 above
//! ```
//!
//! with the house's height H, the distance x of the deck's centre behind it and the height z
//! above the deck. The deficit of a building-like body decays with the power -3/2 of the
//! distance (Counihan, Hunt & Jackson 1974); its size, 0.42 at two heights, and the
//! turbulence, 15 % of the free wind there, have the order of measured airwakes of frigates. The model
//! omits the flow back near the house, so the distance is at least one height. The wind
//! comes over the house from any direction: the house turns with it.

use serde::{Deserialize, Serialize};

use super::wind::{DrydenSettings, WindSettings};
use crate::check;
use crate::error::SimError;

/// Greatest deficit: nearer than 1.6 heights the flow reverses, which the model omits.
const GREATEST_DEFICIT: f64 = 0.6;
/// Deficit at a distance of one height, by extrapolation.
const DEFICIT_AT_HEIGHT: f64 = 1.2;
/// Standard deviation of the turbulence over the lost speed, along the wind.
const TURBULENCE: f64 = 0.35;
/// The same across and vertically, as shares of it.
const ACROSS: [f64; 3] = [1.0, 0.8, 0.6];
/// Length of the eddies over the house's height.
const LENGTH: f64 = 0.5;

/// A deckhouse ahead of the deck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirwakeSettings {
    /// Height of the house above the deck H, m.
    pub house_height_m: f64,
    /// Distance of the deck's centre behind the house x, m; at least the height.
    pub distance_m: f64,
}

impl AirwakeSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// The height must be positive, and the distance at least the height.
    pub fn validate(&self) -> Result<(), SimError> {
        check::positive("airwake.house_height_m", self.house_height_m)?;
        check::that(
            self.distance_m.is_finite() && self.distance_m >= self.house_height_m,
            "airwake.distance_m",
            "at least `airwake.house_height_m`: nearer, the flow reverses",
            self.distance_m,
        )
    }

    /// Share of the wind that is lost on the deck δ.
    #[must_use]
    pub fn deficit(&self) -> f64 {
        let heights = self.distance_m / self.house_height_m;
        GREATEST_DEFICIT.min(DEFICIT_AT_HEIGHT * heights.powf(-1.5))
    }

    /// Share of the wake at a height above the deck f.
    #[must_use]
    pub fn share(&self, height_m: f64) -> f64 {
        let above = height_m / self.house_height_m - 1.0;
        if above <= 0.0 {
            1.0
        } else if above < 0.5 {
            0.5 * (1.0 + (std::f64::consts::TAU * above).cos())
        } else {
            0.0
        }
    }

    /// Turbulence of the whole wake in a wind.
    pub(super) fn turbulence(&self, wind: &WindSettings) -> DrydenSettings {
        let [x, y, _] = wind.steady_mps;
        let wind_mps = x.hypot(y);
        let sd_mps = TURBULENCE * self.deficit() * wind_mps;
        DrydenSettings {
            intensity_mps: ACROSS.map(|share| share * sd_mps),
            length_m: [LENGTH * self.house_height_m; 3],
            // Eddies travel with the slowed wind; in a calm there are none.
            passing_mps: ((1.0 - self.deficit()) * wind_mps).max(0.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUSE: AirwakeSettings = AirwakeSettings {
        house_height_m: 4.0,
        distance_m: 8.0,
    };

    #[test]
    fn analytic_deficit_and_heights_of_the_wake() {
        // 1.2/2^1.5 at two heights; capped close by; an eighth of it at four times the distance.
        assert!((HOUSE.deficit() - 1.2 / 8.0_f64.sqrt()).abs() < 1e-15);
        let at = |distance_m| {
            AirwakeSettings {
                distance_m,
                ..HOUSE
            }
            .deficit()
        };
        assert_eq!(at(4.0), 0.6);
        assert!((at(32.0) - HOUSE.deficit() / 8.0).abs() < 1e-15);
        assert_eq!([0.0, 3.0, 4.0].map(|z| HOUSE.share(z)), [1.0; 3]);
        assert!((HOUSE.share(5.0) - 0.5).abs() < 1e-15);
        assert_eq!(HOUSE.share(6.0), 0.0);
        let bad = AirwakeSettings {
            distance_m: 3.0,
            ..HOUSE
        };
        assert!(bad.validate().is_err());
    }
}
