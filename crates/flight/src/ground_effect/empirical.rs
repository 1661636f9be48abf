//! Eq. (2): the empirical law of the corrected method of images.

use super::{GroundEffect, GroundEffectInput, Lift};
use crate::error::{SettingsError, finite, not_negative, positive};
use crate::real::{Real, r};

/// Eq. (2), `f = q / (1 - q) T` with `q = μ (R / 4z)²`, at most 0.6.
///
/// `μ = 1` is a single rotor over unbounded ground (Cheeseman and Bennett
/// 1955), valid for about `0.5 <= z/R <= 2`; a larger μ approximates the
/// interaction of several rotors. As a feed-forward it multiplies the command
/// by `1 - q`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Empirical<R> {
    /// Coefficient μ.
    pub mu: R,
    /// Rotor radius R, m.
    pub rotor_radius_m: R,
    /// Height of the rotor plane above the vehicle's reference point, m; zero to
    /// use the reported height as it is, which suits a μ fitted to it. Rotor
    /// heights in the input, where given, are used instead.
    pub rotor_offset_m: R,
}

impl<R: Real> Empirical<R> {
    /// Greatest q: keeps clear of the singularity at `q = 1`.
    pub const Q_MAX: f64 = 0.6;

    /// `q` for a height of the rotor plane.
    fn q(&self, rotor_height_m: R) -> R {
        let floor = r::<R>(1e-3) * self.rotor_radius_m;
        let u = self.rotor_radius_m / (r::<R>(4.0) * rotor_height_m.max(floor));
        (self.mu * u * u).min(r(Self::Q_MAX))
    }
}

impl<R: Real> GroundEffect<R> for Empirical<R> {
    type State = ();

    fn rest(&self, _input: &GroundEffectInput<R>) {}

    fn lift(&self, _state: &(), input: &GroundEffectInput<R>) -> Lift<R> {
        let q = match input.rotor_heights_m {
            None => self.q(input.height_m + self.rotor_offset_m),
            Some([z1, z2, z3, z4]) => {
                r::<R>(0.25) * (self.q(z1) + self.q(z2) + self.q(z3) + self.q(z4))
            }
        };
        Lift::from_ratio(q / (R::ONE - q))
    }

    fn advance(&self, _state: &mut (), _input: &GroundEffectInput<R>, _dt: R) {}

    fn validate(&self) -> Result<(), SettingsError> {
        not_negative("ground_effect.empirical.mu", self.mu)?;
        positive(
            "ground_effect.empirical.rotor_radius_m",
            self.rotor_radius_m,
        )?;
        finite(
            "ground_effect.empirical.rotor_offset_m",
            self.rotor_offset_m,
        )
    }
}
