//! Sparse model of the ratio's derivative: eq. (9) for f / T in place of f, with functions of
//! height that stay bounded (this project's own).

use super::{GroundEffect, GroundEffectInput, Lift, default_lengths, psi};
use crate::error::{SettingsError, finite, positive};
use crate::kernel::{linear_rest, linear_step, usable_dt};
use crate::real::Real;

/// `y = f / T`,
/// `y' = ξ · (1, y, ψ1, ψ2, ψ3, v_p, v_p², v_p ψ2, v_p ψ3)` with
/// `ψ_i(z) = 1 / (1 + (z / L_i)²)`, rates in 1/s, v_p in m/s.
///
/// Between samples the input is constant and the equation linear in y, so that
/// the step is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Ratio<R> {
    /// Coefficients in the order of [`Ratio::TERMS`].
    pub xi: [R; 9],
    /// Lengths `L1 .. L3`, m.
    pub length_m: [R; 3],
}

impl<R: Real> Ratio<R> {
    /// The terms, as expressions in `y`, `v_p` and the ψ.
    pub const TERMS: [&'static str; 9] = [
        "1", "y", "psi1", "psi2", "psi3", "v_p", "v_p^2", "v_p*psi2", "v_p*psi3",
    ];

    /// A model with the default lengths 0.08, 0.20 and 0.45 m.
    #[must_use]
    pub fn new(xi: [R; 9]) -> Self {
        Self {
            xi,
            length_m: default_lengths(),
        }
    }

    /// `y' = a + b y` for a given input.
    fn linear(&self, input: &GroundEffectInput<R>) -> (R, R) {
        let [one, y, xi1, xi2, xi3, v, v2, v_psi2, v_psi3] = self.xi;
        let [p1, p2, p3] = psi(input.height_m, self.length_m);
        let deck = input.deck_velocity_mps;
        let a = one
            + xi1 * p1
            + xi2 * p2
            + xi3 * p3
            + deck * (v + v2 * deck + v_psi2 * p2 + v_psi3 * p3);
        (a, y)
    }
}

impl<R: Real> GroundEffect<R> for Ratio<R> {
    /// The ratio y.
    type State = R;

    fn rest(&self, input: &GroundEffectInput<R>) -> R {
        let (a, b) = self.linear(input);
        linear_rest(a, b)
    }

    fn lift(&self, state: &R, _input: &GroundEffectInput<R>) -> Lift<R> {
        Lift::from_ratio(*state)
    }

    fn advance(&self, state: &mut R, input: &GroundEffectInput<R>, dt: R) {
        let (a, b) = self.linear(input);
        *state = linear_step(*state, a, b, usable_dt(dt));
    }

    fn limit(&self, state: &mut R, _thrust_n: R, ratio_min: R, ratio_max: R) {
        *state = state.clamp(ratio_min, ratio_max);
    }

    fn validate(&self) -> Result<(), SettingsError> {
        for value in self.xi {
            finite("ground_effect.ratio.xi", value)?;
        }
        for value in self.length_m {
            positive("ground_effect.ratio.length_m", value)?;
        }
        Ok(())
    }
}
