//! Smooth sliding-mode control, reconstructed.

use super::{ControlInput, Demand};
use crate::error::{SettingsError, not_negative, positive};
use crate::kernel::{lag_step, usable_dt};
use crate::real::{Real, r};

/// Smooth sliding control, reconstructed: the paper compares with it and prints no equation.
/// A saturated switching term behind a low-pass filter.
///
/// ```text
/// u = m g + m (z_p''^ + z_r'' - Γ (v - z_r')) - K_P s - ρ tanh(s / φ)
/// T' = (u - T) / τ
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Ssc<R> {
    /// K_P, N s/m.
    pub k_p: R,
    /// Γ, 1/s.
    pub gamma: R,
    /// Greatest switching force ρ, N.
    pub rho_n: R,
    /// Boundary layer φ, m/s.
    pub phi_mps: R,
    /// Time constant τ of the filter, s.
    pub filter_s: R,
}

/// State of an [`Ssc`] law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SscState<R> {
    /// The filtered thrust, N.
    pub thrust_n: R,
}

impl<R: Real> Default for Ssc<R> {
    /// K_P 4, Γ 2, ρ 1.5 N, φ 0.15 m/s, filter 0.03 s.
    fn default() -> Self {
        Self {
            k_p: r(4.0),
            gamma: r(2.0),
            rho_n: r(1.5),
            phi_mps: r(0.15),
            filter_s: r(0.03),
        }
    }
}

impl<R: Real> Ssc<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// ρ must not be negative, the rest positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("ssc.k_p", self.k_p)?;
        positive("ssc.gamma", self.gamma)?;
        not_negative("ssc.rho_n", self.rho_n)?;
        positive("ssc.phi_mps", self.phi_mps)?;
        positive("ssc.filter_s", self.filter_s)
    }

    /// The thrust asked for: the filter's output at the end of `dt`.
    pub fn demand(&self, state: &SscState<R>, input: &ControlInput<R>, dt: R) -> Demand<R> {
        let s = input.sliding(self.gamma);
        let acceleration =
            input.deck_acceleration_mps2 + input.relative_acceleration_mps2(self.gamma);
        let u = input.weight_n() + input.mass_kg * acceleration
            - self.k_p * s
            - self.rho_n * (s / self.phi_mps).tanh();
        Demand {
            thrust_n: lag_step(state.thrust_n, u, self.filter_s, usable_dt(dt)),
            sliding_mps: s,
        }
    }

    /// Takes over the thrust that was sent, so that the filter does not wind up
    /// beyond the actuators' limits.
    pub fn advance(&self, state: &mut SscState<R>, sent_thrust_n: R) {
        state.thrust_n = sent_thrust_n.finite_or(state.thrust_n);
    }
}
