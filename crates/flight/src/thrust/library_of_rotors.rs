//! Eq. (8) of some rotors for a vehicle that has more of them, or fewer.

use super::library::Library;
use crate::error::{SettingsError, positive};
use crate::real::Real;

/// `X' = k Θ(X/k, s)`, `X = √T` of the vehicle, where Θ is eq. (8) of the measured rotors and
/// `k² = rotors of the vehicle / rotors measured`: equal rotors share the thrust equally.
///
/// The terms e^(-x) and sin(x) of eq. (8) do not scale, so that no other coefficients give the same thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LibraryOfRotors<R> {
    /// Eq. (8) of the measured rotors.
    pub library: Library<R>,
    /// k, above 0.
    pub root_factor: R,
}

impl<R: Real> LibraryOfRotors<R> {
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        positive("thrust.library_of_rotors.root_factor", self.root_factor)?;
        self.library.validate()
    }

    pub(super) fn derivative(&self, x: R, s: R) -> R {
        self.root_factor * self.library.derivative(x / self.root_factor, s)
    }

    pub(super) fn step(&self, x: R, s: R, dt: R) -> R {
        self.root_factor * self.library.step(x / self.root_factor, s, dt)
    }

    pub(super) fn rest(&self, s: R) -> R {
        self.root_factor * self.library.rest(s)
    }

    pub(super) fn throttle_for(&self, x: R, near: R) -> R {
        self.library.throttle_for(x / self.root_factor, near)
    }
}
