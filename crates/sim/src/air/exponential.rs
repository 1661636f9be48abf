//! The second plant: an exponential ground effect with one lag.
//!
//! `T_IGE/T_OGE = 1 + y`, `y' = (k C_a e^(-C_b z) - y)/τ`. C_a = 0.111 and
//! C_b = 5.39 1/m are of the order measured on a 1.5 kg quadrotor with rotors
//! of 0.12 m radius, normalised to hover far from the ground. z is the height of the
//! vehicle's reference point. The law shares nothing with the wake model of
//! [`crate::air::ground`]: it has no images and no fountain, and its lag is constant.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::number::Number;

/// Settings of the exponential law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExponentialSettings {
    /// Amplitude C_a.
    pub amplitude: f64,
    /// Decay C_b, 1/m.
    pub decay_per_m: f64,
    /// Time constant of the lag τ, s.
    pub lag_s: f64,
}

impl Default for ExponentialSettings {
    fn default() -> Self {
        Self {
            amplitude: 0.111,
            decay_per_m: 5.39,
            lag_s: 0.15,
        }
    }
}

/// Exponential ground effect with a first-order lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    amplitude: f64,
    scale: f64,
    decay_per_m: f64,
    rate_per_s: f64,
}

impl Exponential {
    /// Builds the law; `scale` multiplies the amplitude.
    ///
    /// # Errors
    /// Amplitude and scale must not be negative, decay and lag be positive.
    pub fn new(settings: &ExponentialSettings, scale: f64) -> Result<Self, SimError> {
        check::not_negative("amplitude", settings.amplitude)?;
        check::positive("decay_per_m", settings.decay_per_m)?;
        check::positive("lag_s", settings.lag_s)?;
        check::not_negative("ground_effect_scale", scale)?;
        Ok(Self {
            amplitude: settings.amplitude,
            scale,
            decay_per_m: settings.decay_per_m,
            rate_per_s: 1.0 / settings.lag_s,
        })
    }

    /// Lift ratio at rest at the height z of the reference point.
    #[inline]
    #[must_use]
    pub fn target(&self, height_m: f64) -> f64 {
        self.target_at(self.scale, height_m)
    }

    /// [`Self::target`] with the scale given.
    #[inline(always)]
    pub(crate) fn target_at<N: Number>(&self, scale: N, height_m: N) -> N {
        let depth = height_m.at_least(0.0) * -self.decay_per_m;
        scale * self.amplitude * depth.each(f64::exp)
    }

    /// What the amplitude is multiplied by.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The same law with another scale.
    #[must_use]
    pub(crate) fn with_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// Rate of the lagged lift ratio.
    #[inline(always)]
    #[must_use]
    pub fn derivative<N: Number>(&self, ratio: N, target: N) -> N {
        (target - ratio) * self.rate_per_s
    }
}
