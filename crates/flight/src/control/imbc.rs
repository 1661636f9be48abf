//! Internal-model regulator, reconstructed.

use super::{ControlInput, Demand, Saturation};
use crate::error::{SettingsError, positive};
use crate::kernel::usable_dt;
use crate::real::{Real, r};

/// Greatest contribution of the internal model, N.
const INTERNAL_LIMIT_N: f64 = 20.0;

/// Internal-model based control for a deck that heaves at a known frequency, a
/// reconstruction after Marconi, Isidori and Serrani (Automatica 38, 2002).
///
/// ```text
/// u_st = -K_P s
/// ξ1' = ξ2,  ξ2' = ξ3,  ξ3' = -c0 ξ1 - c1 ξ2 - c2 ξ3 + u_im + u_st
/// u_im = c0 ξ1 + (c1 - ω²) ξ2 + c2 ξ3
/// T = m g + m (z_r'' - Γ (v - z_r')) + u_st + u_im
/// ```
///
/// `c0, c1, c2` are the coefficients of `(p + p1)(p + p2)(p + p3)`. The model
/// then holds a constant and a sine of frequency ω (poles 0, ±jω), and no
/// estimate of the deck's acceleration is used. Between samples, with u_st
/// held, its step is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Imbc<R> {
    /// K_P, N s/m.
    pub k_p: R,
    /// Γ, 1/s.
    pub gamma: R,
    /// Angular frequency ω of the deck, rad/s.
    pub angular_frequency: R,
    /// Rates p1, p2, p3 of the internal model's filter, 1/s.
    pub poles_per_s: [R; 3],
}

/// State of an [`Imbc`] law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImbcState<R> {
    /// ξ.
    pub xi: [R; 3],
}

impl<R: Real> Imbc<R> {
    /// The law with K_P 4, Γ 2 and rates 1.5, 2 and 2.5 1/s. Rates much above
    /// that destabilise the loop at this K_P.
    #[must_use]
    pub fn new(angular_frequency: R) -> Self {
        Self {
            k_p: r(4.0),
            gamma: r(2.0),
            angular_frequency,
            poles_per_s: [r(1.5), r(2.0), r(2.5)],
        }
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// Every one must be positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("imbc.k_p", self.k_p)?;
        positive("imbc.gamma", self.gamma)?;
        positive("imbc.angular_frequency", self.angular_frequency)?;
        for pole in self.poles_per_s {
            positive("imbc.poles_per_s", pole)?;
        }
        Ok(())
    }

    /// The internal model's contribution u_im, N.
    fn internal(&self, [xi1, xi2, xi3]: [R; 3]) -> R {
        let [p1, p2, p3] = self.poles_per_s;
        let w = self.angular_frequency;
        let c0 = p1 * p2 * p3;
        let c1 = p1 * p2 + p2 * p3 + p3 * p1;
        let c2 = p1 + p2 + p3;
        c0 * xi1 + (c1 - w * w) * xi2 + c2 * xi3
    }

    /// The thrust asked for.
    pub fn demand(&self, state: &ImbcState<R>, input: &ControlInput<R>) -> Demand<R> {
        let s = input.sliding(self.gamma);
        let tracking = input.mass_kg * input.relative_acceleration_mps2(self.gamma);
        Demand {
            thrust_n: input.weight_n() + tracking - self.k_p * s + self.internal(state.xi),
            sliding_mps: s,
        }
    }

    /// Advances the internal model over `dt` seconds. It is not driven where
    /// that would push a command further beyond the actuators' limits, and its
    /// contribution stays within 20 N.
    pub fn advance(
        &self,
        state: &mut ImbcState<R>,
        demand: &Demand<R>,
        saturation: Saturation,
        dt: R,
    ) {
        let dt = usable_dt(dt);
        let mut u = -self.k_p * demand.sliding_mps;
        if saturation.resists(u) {
            u = R::ZERO;
        }
        // In closed loop ξ3' = -ω² ξ2 + u_st: an oscillator with a constant push.
        let w = self.angular_frequency;
        let (sin, cos) = ((w * dt).sin(), (w * dt).cos());
        let half_sin = (r::<R>(0.5) * w * dt).sin();
        let s1 = sin / w;
        let s2 = r::<R>(2.0) * half_sin * half_sin / (w * w);
        let s3 = (dt - s1) / (w * w);
        let [xi1, xi2, xi3] = state.xi;
        let mut next = [
            xi1 + s1 * xi2 + s2 * xi3 + s3 * u,
            cos * xi2 + s1 * xi3 + s2 * u,
            cos * xi3 - w * sin * xi2 + s1 * u,
        ];
        let size = self.internal(next).abs();
        let limit = r::<R>(INTERNAL_LIMIT_N);
        if size > limit {
            next = next.map(|xi| xi * (limit / size));
        }
        if next.iter().all(|xi| xi.is_finite()) {
            state.xi = next;
        }
    }
}
