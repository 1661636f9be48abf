//! Adaptation of the scale factor of the ground-effect model.

use super::observer::Felt;
use crate::check::positive;
use touchdown_flight::error::{SettingsError, ordered};
use touchdown_flight::kernel::{lag_share, lag_step, usable_dt};
use touchdown_flight::real::{Real, r};

/// Scale factor θ of the ground effect, by regression of the measured force beyond
/// thrust, d, on the model's force f^:
///
/// ```text
/// θ = (<(d - d0) f^> + w) / (<f^²> + w)         w: weight of θ = 1, N²
/// ```
///
/// The averages <> have an exponential memory. Out of ground effect (`f^/T` below
/// `active_ratio`) both are frozen. Far out of it (below `baseline_ratio`) d - θ f^ is
/// averaged to the offset d0, which a wrong thrust scale or wind causes; elsewhere d0 is
/// frozen. The scaled model is `θ f^`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Adaptation<R> {
    /// Memory of the averages, s.
    pub memory_s: R,
    /// Weight w of the unscaled model (θ = 1), N².
    pub prior_n2: R,
    /// Smallest scale factor.
    pub strength_min: R,
    /// Largest scale factor.
    pub strength_max: R,
    /// Ratio of the model's lift to thrust above which the scale factor is adapted.
    pub active_ratio: R,
    /// Ratio of the model's lift to thrust below which d0 is learnt.
    pub baseline_ratio: R,
    /// Memory of d0, s.
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
    /// Memory 2 s, prior weight 0.05 N², scale factor within 0.2 to 2.5, active above a
    /// ratio of 0.03, d0 below a ratio of 0.01 over 0.5 s.
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
    /// Times, weight and limits must be positive. `strength_min` must be below
    /// `strength_max`, and `baseline_ratio` below `active_ratio`.
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

    /// The state before the first step.
    #[must_use]
    pub fn initial(&self) -> AdaptationState<R> {
        AdaptationState {
            product_n2: R::ZERO,
            square_n2: R::ZERO,
            baseline_n: R::ZERO,
        }
    }

    /// The scale factor θ.
    #[must_use]
    pub fn strength(&self, state: &AdaptationState<R>) -> R {
        ((state.product_n2 + self.prior_n2) / (state.square_n2 + self.prior_n2))
            .clamp(self.strength_min, self.strength_max)
    }

    /// Updates the averages with the measured force over `dt` seconds.
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
