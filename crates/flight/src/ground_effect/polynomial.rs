//! Eq. (9): eleven-term polynomial model of the force's derivative.

use super::{GroundEffect, GroundEffectInput, Lift};
use crate::error::{SettingsError, finite};
use crate::kernel::{linear_rest, linear_step, usable_dt};
use crate::real::{Real, r};

/// Eq. (9), `f' = θ · (1, f, s, z, v_p, v_q, s², v_p v_q, z², v_p², v_q²)`, f in N,
/// throttle s, height z in m, velocities of deck and vehicle in m/s.
///
/// Between samples the input is constant and the equation linear in f, so that
/// the step is exact. The published coefficients were identified at heights of
/// 0.1 to 0.3 m; the polynomial in z is not bounded, so that limits of validity
/// matter (see [`super::Guarded`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Polynomial<R> {
    /// Coefficients in the order of [`Polynomial::TERMS`].
    pub theta: [R; 11],
}

impl<R: Real> Polynomial<R> {
    /// The terms, as expressions in `f`, `s`, `z`, `v_p`, `v_q`.
    pub const TERMS: [&'static str; 11] = [
        "1", "f", "s", "z", "v_p", "v_q", "s^2", "v_p*v_q", "z^2", "v_p^2", "v_q^2",
    ];

    /// The published coefficients, eq. (12).
    #[must_use]
    pub fn published() -> Self {
        Self {
            theta: [
                r(0.804),
                r(-0.088),
                r(-3.912),
                r(0.586),
                r(1.051),
                r(-1.049),
                r(4.854),
                r(1.103),
                r(-2.504),
                r(-0.535),
                r(-0.562),
            ],
        }
    }

    /// `df/dt` at a force, N/s.
    pub fn derivative(&self, force_n: R, input: &GroundEffectInput<R>) -> R {
        let (a, b) = self.linear(input);
        a + b * force_n
    }

    /// `f' = a + b f` for a given input.
    fn linear(&self, input: &GroundEffectInput<R>) -> (R, R) {
        let [one, f, s, z, vp, vq, s2, vpvq, z2, vp2, vq2] = self.theta;
        let (throttle, height) = (input.throttle, input.height_m);
        let (deck, vehicle) = (input.deck_velocity_mps, input.vehicle_velocity_mps);
        let a = one
            + throttle * (s + s2 * throttle)
            + height * (z + z2 * height)
            + deck * (vp + vp2 * deck + vpvq * vehicle)
            + vehicle * (vq + vq2 * vehicle);
        (a, f)
    }
}

impl<R: Real> GroundEffect<R> for Polynomial<R> {
    /// The force f, N.
    type State = R;

    fn rest(&self, input: &GroundEffectInput<R>) -> R {
        let (a, b) = self.linear(input);
        linear_rest(a, b)
    }

    fn lift(&self, state: &R, _input: &GroundEffectInput<R>) -> Lift<R> {
        Lift::from_force(*state)
    }

    fn advance(&self, state: &mut R, input: &GroundEffectInput<R>, dt: R) {
        let (a, b) = self.linear(input);
        *state = linear_step(*state, a, b, usable_dt(dt));
    }

    fn limit(&self, state: &mut R, thrust_n: R, ratio_min: R, ratio_max: R) {
        *state = state.clamp(ratio_min * thrust_n, ratio_max * thrust_n);
    }

    fn validate(&self) -> Result<(), SettingsError> {
        for value in self.theta {
            finite("ground_effect.polynomial.theta", value)?;
        }
        Ok(())
    }
}
