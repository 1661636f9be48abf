//! Quasi-steady map of height behind one lag, with a term in deck velocity (this project's
//! own).

use super::{GroundEffect, GroundEffectInput, Lift, StaticMap, psi};
use crate::error::{SettingsError, finite, positive};
use crate::kernel::{lag_step, usable_dt};
use crate::real::Real;

/// `y = f / T = G + (k0 + k1 ψ3(z)) v_p`, `G' = (h(z) - G) / τ`, with `h` a
/// [`StaticMap`] and v_p the velocity of the deck.
///
/// The step is the exact exponential for a height that is constant over it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Lag<R> {
    /// The ratio at rest, `h(z)`.
    pub map: StaticMap<R>,
    /// `k0, k1`, s/m.
    pub k: [R; 2],
    /// Time constant τ, s.
    pub tau_s: R,
}

impl<R: Real> Lag<R> {
    fn lift_at(&self, state: R, psi3: R, deck_velocity_mps: R) -> Lift<R> {
        let [k0, k1] = self.k;
        Lift::from_ratio(state + (k0 + k1 * psi3) * deck_velocity_mps)
    }
}

impl<R: Real> GroundEffect<R> for Lag<R> {
    /// The lagged ratio G.
    type State = R;

    fn rest(&self, input: &GroundEffectInput<R>) -> R {
        self.map.ratio(input.height_m)
    }

    fn lift(&self, state: &R, input: &GroundEffectInput<R>) -> Lift<R> {
        let [_, _, psi3] = psi(input.height_m, self.map.length_m);
        self.lift_at(*state, psi3, input.deck_velocity_mps)
    }

    fn advance(&self, state: &mut R, input: &GroundEffectInput<R>, dt: R) {
        let target = self.map.ratio(input.height_m);
        *state = lag_step(*state, target, self.tau_s, usable_dt(dt));
    }

    /// With the functions of height found once.
    fn step_within(
        &self,
        state: &mut R,
        input: &GroundEffectInput<R>,
        dt: R,
        ratio_min: R,
        ratio_max: R,
    ) -> Lift<R> {
        let psis = psi(input.height_m, self.map.length_m);
        let lagged = lag_step(*state, self.map.at(psis), self.tau_s, usable_dt(dt));
        *state = lagged.clamp(ratio_min, ratio_max);
        self.lift_at(*state, psis[2], input.deck_velocity_mps)
    }

    fn limit(&self, state: &mut R, _thrust_n: R, ratio_min: R, ratio_max: R) {
        *state = state.clamp(ratio_min, ratio_max);
    }

    fn validate(&self) -> Result<(), SettingsError> {
        for value in self.map.h {
            finite("ground_effect.lag.map.h", value)?;
        }
        for value in self.map.length_m {
            positive("ground_effect.lag.map.length_m", value)?;
        }
        for value in self.k {
            finite("ground_effect.lag.k", value)?;
        }
        positive("ground_effect.lag.tau_s", self.tau_s)
    }
}
