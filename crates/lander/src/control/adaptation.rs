//! One-parameter adaptation of the ground-effect model's strength.

use super::observer::Felt;
use touchdown_flight::error::{SettingsError, ordered, positive};
use touchdown_flight::kernel::{lag_share, lag_step, usable_dt};
use touchdown_flight::real::{Real, r};

/// Strength θ of the ground effect against its model, by regression of the force
/// felt beyond thrust, d, on the model's force f^:
///
/// ```text
/// θ = (<(d - d0) f^> + w) / (<f^²> + w)         w: weight of θ = 1, N²
/// ```
///
/// with averages that forget exponentially. Out of the ground effect (`f^/T` below
/// `active_ratio`) both averages are frozen; well out of it (below
/// `baseline_ratio`) d - θ f^ is averaged to d0, what a wrong thrust scale and
/// wind give there, and elsewhere d0 is frozen. The scaled model is `θ f^`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Adaptation<R> {
    /// Memory of the averages, s.
    pub memory_s: R,
    /// Weight w of the model as it is, N².
    pub prior_n2: R,
    /// Least strength.
    pub strength_min: R,
    /// Greatest strength.
    pub strength_max: R,
    /// Ratio of the model's lift to thrust from which on it is adapted.
    pub active_ratio: R,
    /// Ratio of the model's lift to thrust up to which d0 is learnt.
    pub baseline_ratio: R,
    /// Memory of what is felt out of the ground effect, s.
    pub baseline_s: R,
}

/// State of an [`Adaptation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptationState<R> {
    /// `<(d - d0) f^>`, N².
    product_n2: R,
    /// `<f^²>`, N².
    square_n2: R,
    /// d0, N.
    baseline_n: R,
}

impl<R: Real> Default for Adaptation<R> {
    /// Memory 2 s, prior weight 0.05 N², strength within 0.2 to 2.5, active from
    /// a ratio of 0.03, baseline up to a ratio of 0.01 over 0.5 s.
    fn default() -> Self {
        Self {
            memory_s: r(2.0),
            prior_n2: r(0.05),
            strength_min: r(0.2),
            strength_max: r(2.5),
            active_ratio: r(0.03),
            baseline_ratio: r(0.01),
            baseline_s: r(0.5),
        }
    }
}

impl<R: Real> Adaptation<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Times, weight and limits must be positive, the least strength lie below the
    /// greatest, and the baseline's ratio below the one of activity.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("adaptation.memory_s", self.memory_s)?;
        positive("adaptation.prior_n2", self.prior_n2)?;
        positive("adaptation.strength_min", self.strength_min)?;
        ordered(
            "adaptation.strength_min",
            self.strength_min,
            "adaptation.strength_max",
            self.strength_max,
        )?;
        ordered(
            "adaptation.baseline_ratio",
            self.baseline_ratio,
            "adaptation.active_ratio",
            self.active_ratio,
        )?;
        positive("adaptation.baseline_s", self.baseline_s)
    }

    /// The state before anything was felt.
    #[must_use]
    pub fn initial(&self) -> AdaptationState<R> {
        AdaptationState {
            product_n2: R::ZERO,
            square_n2: R::ZERO,
            baseline_n: R::ZERO,
        }
    }

    /// The strength θ.
    #[must_use]
    pub fn strength(&self, state: &AdaptationState<R>) -> R {
        ((state.product_n2 + self.prior_n2) / (state.square_n2 + self.prior_n2))
            .clamp(self.strength_min, self.strength_max)
    }

    /// Takes in what was felt over `dt` seconds.
    pub(crate) fn step(&self, state: &mut AdaptationState<R>, felt: &Felt<R>, dt: R) {
        let dt = usable_dt(dt);
        let f = felt.model_n;
        if f >= self.active_ratio * felt.thrust_n {
            let product = (felt.beyond_thrust_n - state.baseline_n) * f;
            if product.is_finite() && (f * f).is_finite() {
                let share = lag_share(self.memory_s, dt);
                state.product_n2 += (product - state.product_n2) * share;
                state.square_n2 += (f * f - state.square_n2) * share;
            }
        } else if f <= self.baseline_ratio * felt.thrust_n {
            let left = felt.beyond_thrust_n - self.strength(state) * f;
            if left.is_finite() {
                state.baseline_n = lag_step(state.baseline_n, left, self.baseline_s, dt);
            }
        }
    }
}
