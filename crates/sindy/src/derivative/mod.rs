//! Derivatives of sampled signals, with the smoothing that noise asks for.
//!
//! How strongly a signal is smoothed before it is differentiated matters as much to an identified model as
//! the solver: plain differences turn noise `σ` into `σ/(√2 Δt)`. Every method is settings checked when
//! built and one `apply(time, y)` that returns value and slope at each sample as [`Smoothed`];
//! [`Differentiator`] is any one of them.
//!
//! | method | grid | smoothing strength | source of strength |
//! | --- | --- | --- | --- |
//! | [`FiniteDifference`] | any | none | – |
//! | [`SavitzkyGolay`] | any | window, degree | given, or [`choose_savgol`] (uniform grids) |
//! | [`SmoothingSpline`] | any | `λ` | given, or generalised cross-validation |
//! | [`KalmanSmoother`] | any | `q/σ²` | given, or maximum likelihood |
//! | [`Spectral`] | uniform | cut-off | given, or generalised cross-validation |
//!
//! Cross-validation and likelihood suit the value; the slope wants somewhat more smoothing.
//! [`choose_savgol`] weighs bias and noise of the slope itself and is the recommended choice on noisy
//! uniform data. [`noise_level`] estimates `σ`; [`spikes`] finds single samples that are far off; [`segments`](crate::data::gaps::segments) splits a trajectory
//! at gaps.
//! [`Rates`] differentiates samples block by block on their way to the statistics.
//!
//! ```
//! use sindy::derivative::{Differentiator, FiniteDifference, SavgolSearch, choose_savgol};
//!
//! let time: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
//! // A sine with an error of alternating sign.
//! let y: Vec<f64> = (0..400).map(|i| time[i].sin() + 1e-3 * [1.0, -1.0][i % 2]).collect();
//! let choice = choose_savgol(&[(&time, &y)], &SavgolSearch::default())?;
//! let error = |d: Differentiator| -> Result<f64, sindy::SindyError> {
//!     Ok((d.apply(&time, &y)?.derivative[200] - time[200].cos()).abs())
//! };
//! assert!(error(choice.filter.into())? < 1e-3);
//! assert!(error(FiniteDifference::new(4)?.into())? < 0.2);
//! # Ok::<(), sindy::SindyError>(())
//! ```

mod choose;
mod finite;
mod kalman;
mod noise;
mod rates;
pub mod savgol;
mod spectral;
mod spikes;
mod spline;

pub use choose::{SavgolCandidate, SavgolChoice, SavgolReason, SavgolSearch, choose_savgol};
pub use finite::FiniteDifference;
pub use kalman::{KalmanFit, KalmanSmoother, Motion};
pub use noise::{NoiseLevel, noise_level};
pub use rates::Rates;
pub use savgol::SavitzkyGolay;
pub use spectral::{Cutoff, Ends, Spectral};
pub use spikes::{Spike, spikes};
pub use spline::{SmoothingSpline, SplineFit};

use crate::error::SindyError;
use savgol::Smoothed;

/// Any method of differentiation. Each is checked when it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Differentiator {
    /// Finite differences.
    FiniteDifference(FiniteDifference),
    /// Savitzky–Golay.
    SavitzkyGolay(SavitzkyGolay),
    /// Cubic smoothing spline.
    SmoothingSpline(SmoothingSpline),
    /// Kalman smoother.
    Kalman(KalmanSmoother),
    /// Fast Fourier transform.
    Spectral(Spectral),
}

impl Differentiator {
    /// Value and slope of `y` sampled at `time`, one of each per sample, in the unit of `y` and per unit of
    /// time.
    ///
    /// # Errors
    /// Too few samples for the method, lengths that differ, non-finite values, times that do not increase;
    /// for [`Spectral`] a grid that is not uniform.
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        match self {
            Self::FiniteDifference(d) => d.apply(time, y),
            Self::SavitzkyGolay(d) => d.apply(time, y),
            Self::SmoothingSpline(d) => d.apply(time, y),
            Self::Kalman(d) => d.apply(time, y),
            Self::Spectral(d) => d.apply(time, y),
        }
    }
}

impl From<FiniteDifference> for Differentiator {
    fn from(d: FiniteDifference) -> Self {
        Self::FiniteDifference(d)
    }
}

impl From<SavitzkyGolay> for Differentiator {
    fn from(d: SavitzkyGolay) -> Self {
        Self::SavitzkyGolay(d)
    }
}

impl From<SmoothingSpline> for Differentiator {
    fn from(d: SmoothingSpline) -> Self {
        Self::SmoothingSpline(d)
    }
}

impl From<KalmanSmoother> for Differentiator {
    fn from(d: KalmanSmoother) -> Self {
        Self::Kalman(d)
    }
}

impl From<Spectral> for Differentiator {
    fn from(d: Spectral) -> Self {
        Self::Spectral(d)
    }
}

#[cfg(test)]
pub(crate) mod tests;
