//! Eq. (10): composite tracking law with ground-effect feedforward.

use super::{ControlInput, Demand, Saturation};
use crate::error::{SettingsError, not_negative, positive};
use crate::ground_effect::Lift;
use crate::kernel::usable_dt;
use crate::real::{Real, r};

/// Gains of the composite law, eq. (10).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Gains<R> {
    /// K_P, N s/m.
    pub k_p: R,
    /// K_I, N/m.
    pub k_i: R,
    /// Γ, 1/s.
    pub gamma: R,
    /// Greatest integral force, N.
    pub integral_limit_n: R,
}

impl<R: Real> Default for Gains<R> {
    /// K_P 4, K_I 0.01, Γ 2, integral within 2 N.
    fn default() -> Self {
        Self {
            k_p: r(4.0),
            k_i: r(0.01),
            gamma: r(2.0),
            integral_limit_n: r(2.0),
        }
    }
}

/// Eq. (10) for one axis, `T + f^ = m (z_p''^ + z_r'' - Γ (v - z_r')) - K_P s - K_I ∫ s dt + m g`,
/// called base, solved for the command with `f^ = ratio · T + force`:
/// `T = (base - force) / (1 + ratio)`.
///
/// A constant error of force e leaves `z - z_r = e / (K_P Γ)` without integral
/// action. The integral stops at its limit, and where it would push a command
/// further beyond the actuators' limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Composite<R: Real> {
    /// Gains.
    pub gains: Gains<R>,
}

/// State of a [`Composite`] law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompositeState<R> {
    /// `K_I ∫ s dt`, N.
    pub integral_n: R,
}

impl<R: Real> Composite<R> {
    /// Checks the gains.
    ///
    /// # Errors
    /// K_P and Γ must be positive, K_I and the limit not negative.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("gains.k_p", self.gains.k_p)?;
        not_negative("gains.k_i", self.gains.k_i)?;
        positive("gains.gamma", self.gains.gamma)?;
        not_negative("gains.integral_limit_n", self.gains.integral_limit_n)
    }

    /// The thrust asked for.
    pub fn demand(
        &self,
        state: &CompositeState<R>,
        input: &ControlInput<R>,
        lift: Lift<R>,
    ) -> Demand<R> {
        let Gains { k_p, gamma, .. } = self.gains;
        let s = input.sliding(gamma);
        let acceleration = input.deck_acceleration_mps2 + input.relative_acceleration_mps2(gamma);
        let base = input.mass_kg * acceleration - k_p * s - state.integral_n + input.weight_n();
        Demand {
            thrust_n: (base - lift.force_n) / (R::ONE + lift.ratio),
            sliding_mps: s,
        }
    }

    /// Integrates over `dt` seconds.
    pub fn advance(
        &self,
        state: &mut CompositeState<R>,
        demand: &Demand<R>,
        saturation: Saturation,
        dt: R,
    ) {
        let change = self.gains.k_i * demand.sliding_mps * usable_dt(dt);
        let limit = self.gains.integral_limit_n;
        if !saturation.resists(-change) {
            state.integral_n = (state.integral_n + change)
                .clamp(-limit, limit)
                .finite_or(state.integral_n);
        }
    }
}
