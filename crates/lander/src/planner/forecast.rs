//! Prediction of the deck's motion for the planner.

use crate::estimate::deck::DeckMotionPrediction;
use touchdown_flight::real::Real;

/// The deck at a future time, with standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DeckOutlook<R> {
    /// Heave velocity, up, m/s.
    pub velocity_mps: R,
    /// Heave acceleration, up, m/s².
    pub acceleration_mps2: R,
    /// Tilt of the deck, rad.
    pub tilt_rad: R,
    /// Standard deviation of the velocity, m/s.
    pub velocity_sd_mps: R,
    /// Standard deviation of the acceleration, m/s².
    pub acceleration_sd_mps2: R,
    /// Standard deviation of the tilt, rad.
    pub tilt_sd_rad: R,
}

impl<R: Real> DeckOutlook<R> {
    /// The predicted heave of the deck estimator, together with a tilt and its standard
    /// deviation, which that estimator does not provide.
    #[must_use]
    pub fn from_heave(heave: &DeckMotionPrediction<R>, tilt_rad: R, tilt_sd_rad: R) -> Self {
        Self {
            velocity_mps: heave.velocity_mps,
            acceleration_mps2: heave.acceleration_mps2,
            tilt_rad,
            velocity_sd_mps: heave.velocity_sd_mps,
            acceleration_sd_mps2: heave.acceleration_sd_mps2,
            tilt_sd_rad,
        }
    }
}

/// A prediction of the deck's motion. Any function of the time ahead implements it.
pub trait DeckForecast<R> {
    /// The deck `ahead_s` seconds from now.
    fn at(&self, ahead_s: R) -> DeckOutlook<R>;
}

impl<R, F: Fn(R) -> DeckOutlook<R>> DeckForecast<R> for F {
    fn at(&self, ahead_s: R) -> DeckOutlook<R> {
        self(ahead_s)
    }
}
