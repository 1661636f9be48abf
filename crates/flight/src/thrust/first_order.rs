//! Eq. (7): first-order lag to a line in throttle.

use crate::error::{SettingsError, finite, positive};
use crate::kernel::{first_rise, lag_step};
use crate::real::Real;

/// Eq. (7), `x' = (c0 s + c1 - x) / T_m` with `x = √T`: rotor speed proportional to
/// throttle, thrust to its square, one time constant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct FirstOrder<R> {
    /// Slope, √N per unit of throttle.
    pub c0: R,
    /// Intercept, √N.
    pub c1: R,
    /// Time constant, s.
    pub t_m_s: R,
}

impl<R: Real> FirstOrder<R> {
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        positive("thrust.first_order.c0", self.c0)?;
        finite("thrust.first_order.c1", self.c1)?;
        positive("thrust.first_order.t_m_s", self.t_m_s)
    }

    pub(super) fn derivative(&self, x: R, s: R) -> R {
        (self.rest(s) - x) / self.t_m_s
    }

    pub(super) fn step(&self, x: R, s: R, dt: R) -> R {
        lag_step(x, self.rest(s), self.t_m_s, dt)
    }

    pub(super) fn rest(&self, s: R) -> R {
        self.c0 * s + self.c1
    }

    pub(super) fn throttle_for(&self, x: R, near: R) -> R {
        first_rise([self.c1 - x, self.c0, R::ZERO, R::ZERO], near)
    }
}
