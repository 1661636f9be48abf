//! Touchdown, judged in the deck's frame.

use crate::error::{SettingsError, finite};
use crate::kernel::{Sum, usable_dt};
use crate::real::{Real, r};

/// The first crossing of a height above the deck; a first sample at or below it
/// counts as touchdown at time zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct TouchdownDetector<R> {
    /// The height that counts as landed, m.
    pub height_m: R,
}

/// A touchdown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Touchdown<R> {
    /// Time since the first sample, s.
    pub time_s: R,
    /// Velocity relative to the deck v, m/s (negative when descending).
    pub relative_velocity_mps: R,
}

/// A sample of height and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample<R> {
    time_s: R,
    height_m: R,
    velocity_mps: R,
}

/// State of a [`TouchdownDetector`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchdownState<R> {
    time: Sum<R>,
    last: Option<Sample<R>>,
    touchdown: Option<Touchdown<R>>,
}

impl<R: Real> TouchdownState<R> {
    /// Time since the first sample, s.
    pub fn time_s(&self) -> R {
        self.time.value()
    }

    /// The touchdown, once it has happened.
    #[must_use]
    pub fn touchdown(&self) -> Option<Touchdown<R>> {
        self.touchdown
    }
}

impl<R: Real> Default for TouchdownDetector<R> {
    /// 0.1 m.
    fn default() -> Self {
        Self { height_m: r(0.1) }
    }
}

impl<R: Real> TouchdownDetector<R> {
    /// Checks the setting.
    ///
    /// # Errors
    /// The height must be finite.
    pub fn validate(&self) -> Result<(), SettingsError> {
        finite("touchdown.height_m", self.height_m)
    }

    /// Takes in the sample `dt` seconds after the one before (the first sample is
    /// at time zero, its `dt` is not used). The crossing lies where the line
    /// between two samples meets the height. Samples that are not finite are
    /// left out.
    pub fn step(
        &self,
        state: &mut TouchdownState<R>,
        height_m: R,
        relative_velocity_mps: R,
        dt: R,
    ) -> Option<Touchdown<R>> {
        if state.last.is_some() {
            state.time.add(usable_dt(dt));
        }
        if state.touchdown.is_some() || !height_m.is_finite() || !relative_velocity_mps.is_finite()
        {
            return state.touchdown;
        }
        let sample = Sample {
            time_s: state.time.value(),
            height_m,
            velocity_mps: relative_velocity_mps,
        };
        if height_m <= self.height_m {
            state.touchdown = Some(self.crossing(state.last, sample));
        }
        state.last = Some(sample);
        state.touchdown
    }

    fn crossing(&self, last: Option<Sample<R>>, now: Sample<R>) -> Touchdown<R> {
        let Some(last) = last else {
            return Touchdown {
                time_s: now.time_s,
                relative_velocity_mps: now.velocity_mps,
            };
        };
        let part = ((last.height_m - self.height_m) / (last.height_m - now.height_m))
            .finite_or(R::ONE)
            .clamp(R::ZERO, R::ONE);
        Touchdown {
            time_s: last.time_s + part * (now.time_s - last.time_s),
            relative_velocity_mps: last.velocity_mps
                + part * (now.velocity_mps - last.velocity_mps),
        }
    }
}
