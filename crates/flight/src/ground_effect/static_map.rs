//! Static map of height (this project's own).

use super::{GroundEffect, GroundEffectInput, Lift, default_lengths, psi};
use crate::error::{SettingsError, finite, positive};
use crate::real::Real;

/// `y = f / T = h0 + h1 ψ1(z) + h2 ψ2(z) + h3 ψ3(z)` with
/// `ψ_i = 1 / (1 + (z / L_i)²)`: bounded at every height.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct StaticMap<R> {
    /// `h0 .. h3`.
    pub h: [R; 4],
    /// Lengths `L1 .. L3`, m.
    pub length_m: [R; 3],
}

impl<R: Real> StaticMap<R> {
    /// The terms of `h`.
    pub const TERMS: [&'static str; 4] = ["1", "psi1", "psi2", "psi3"];

    /// A map with the default lengths 0.08, 0.20 and 0.45 m.
    #[must_use]
    pub fn new(h: [R; 4]) -> Self {
        Self {
            h,
            length_m: default_lengths(),
        }
    }

    /// The ratio `y` at a height.
    pub fn ratio(&self, height_m: R) -> R {
        self.at(psi(height_m, self.length_m))
    }

    pub(super) fn at(&self, [p1, p2, p3]: [R; 3]) -> R {
        let [h0, h1, h2, h3] = self.h;
        h0 + h1 * p1 + h2 * p2 + h3 * p3
    }
}

impl<R: Real> GroundEffect<R> for StaticMap<R> {
    type State = ();

    fn rest(&self, _input: &GroundEffectInput<R>) {}

    fn lift(&self, _state: &(), input: &GroundEffectInput<R>) -> Lift<R> {
        Lift::from_ratio(self.ratio(input.height_m))
    }

    fn advance(&self, _state: &mut (), _input: &GroundEffectInput<R>, _dt: R) {}

    fn validate(&self) -> Result<(), SettingsError> {
        for value in self.h {
            finite("ground_effect.static.h", value)?;
        }
        for value in self.length_m {
            positive("ground_effect.static.length_m", value)?;
        }
        Ok(())
    }
}
