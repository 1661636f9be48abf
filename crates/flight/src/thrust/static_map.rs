//! Cubic static map with a first-order lag: eq. (7) with a cubic in place of the line.

use crate::error::{SettingsError, finite, positive};
use crate::kernel::{first_rise, lag_step};
use crate::real::Real;

/// `x' = (p(s) - x) / T_m` with `x = √T` and
/// `p(s) = a0 + a1 s + a2 s² + a3 s³`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct StaticThrust<R> {
    /// `a0 .. a3`, √N.
    pub coefficients: [R; 4],
    /// Time constant, s.
    pub t_m_s: R,
}

impl<R: Real> StaticThrust<R> {
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        for value in self.coefficients {
            finite("thrust.static.coefficients", value)?;
        }
        positive("thrust.static.t_m_s", self.t_m_s)
    }

    pub(super) fn derivative(&self, x: R, s: R) -> R {
        (self.rest(s) - x) / self.t_m_s
    }

    pub(super) fn step(&self, x: R, s: R, dt: R) -> R {
        lag_step(x, self.rest(s), self.t_m_s, dt)
    }

    pub(super) fn rest(&self, s: R) -> R {
        let [a0, a1, a2, a3] = self.coefficients;
        a0 + s * (a1 + s * (a2 + s * a3))
    }

    pub(super) fn throttle_for(&self, x: R, near: R) -> R {
        let [a0, a1, a2, a3] = self.coefficients;
        first_rise([a0 - x, a1, a2, a3], near)
    }
}
