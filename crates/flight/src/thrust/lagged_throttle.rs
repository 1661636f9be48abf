//! A cubic of lagged throttle for the thrust itself: electronics or motors that follow the command before the rotors do.

use crate::error::{SettingsError, finite, positive};
use crate::kernel::{first_rise, lag_step};
use crate::real::{Real, r};

/// `T = p(u)`, `T_m u' = s - u`, with `p(u) = a0 + a1 u + a2 u² + a3 u³` (N, of all rotors).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LaggedThrottle<R> {
    /// `a0 .. a3`, N.
    pub coefficients: [R; 4],
    /// Time constant, s.
    pub t_m_s: R,
}

impl<R: Real> LaggedThrottle<R> {
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        for value in self.coefficients {
            finite("thrust.lagged_throttle.coefficients", value)?;
        }
        positive("thrust.lagged_throttle.t_m_s", self.t_m_s)
    }

    /// `dx/dt = p'(u) (s - u)/(2 x T_m)` with `x = √T`.
    pub(super) fn derivative(&self, x: R, s: R) -> R {
        let [_, a1, a2, a3] = self.coefficients;
        let u = self.throttle_for(x, s);
        let slope = a1 + u * (r::<R>(2.0) * a2 + u * r::<R>(3.0) * a3);
        slope * (s - u) / (r::<R>(2.0) * x * self.t_m_s)
    }

    pub(super) fn step(&self, x: R, s: R, dt: R) -> R {
        let u = self.throttle_for(x, s);
        self.rest(lag_step(u, s, self.t_m_s, dt))
    }

    pub(super) fn rest(&self, s: R) -> R {
        let [a0, a1, a2, a3] = self.coefficients;
        (a0 + s * (a1 + s * (a2 + s * a3))).max(R::ZERO).sqrt()
    }

    pub(super) fn throttle_for(&self, x: R, near: R) -> R {
        let [a0, a1, a2, a3] = self.coefficients;
        first_rise([a0 - x * x, a1, a2, a3], near)
    }
}
