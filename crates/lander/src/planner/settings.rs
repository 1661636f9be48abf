//! Limits of a planner.

use super::quintic;
use crate::check::{not_negative, positive};
use touchdown_flight::error::{SettingsError, ordered, within};
use touchdown_flight::real::{Real, r};
use touchdown_flight::reference::Terminal;

/// Limits of the deck's motion at touchdown.
///
/// `confidence` standard deviations are added to each predicted value. The limits of
/// velocity and acceleration together select the phase of the motion: at a crest the
/// velocity is small and the acceleration negative.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Quiescence<R> {
    /// Greatest vertical speed of the deck, m/s.
    pub speed_mps: R,
    /// Least (most downward) acceleration of the deck, m/s².
    pub acceleration_min_mps2: R,
    /// Greatest acceleration of the deck, m/s².
    pub acceleration_max_mps2: R,
    /// Greatest tilt of the deck, rad.
    pub tilt_rad: R,
    /// Greatest speed of the vehicle relative to the deck, m/s.
    pub relative_speed_mps: R,
    /// Time by which the vehicle lags behind the deck's acceleration, s: an acceleration
    /// a causes a relative speed of `response_s · a`.
    pub response_s: R,
    /// Number of standard deviations that are added to predictions.
    pub confidence: R,
    /// Time around the touchdown in which all limits must hold, s.
    pub dwell_s: R,
}

/// Limits of a descent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Descent<R> {
    /// Height at touchdown, m.
    pub end_height_m: R,
    /// Least rate of descent at touchdown, m/s.
    pub sink_rate_mps: R,
    /// Increase of that rate per standard deviation of the deck's velocity. A vehicle
    /// whose sink rate is below its velocity error touches more than once.
    pub sink_per_sd: R,
    /// Greatest rate of descent at touchdown, m/s.
    pub sink_rate_max_mps: R,
    /// Least duration, s.
    pub duration_min_s: R,
    /// Greatest duration, s.
    pub duration_max_s: R,
    /// Greatest rate of descent, relative to the deck, m/s.
    pub speed_mps: R,
    /// Greatest acceleration, including that of the deck during the descent, m/s².
    pub acceleration_mps2: R,
    /// Height above its end from which a descent takes longer, m.
    #[cfg_attr(feature = "serde", serde(default = "low_m"))]
    pub low_m: R,
}

/// Planner of the descent; see the [module](super).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Planner<R> {
    /// Limits of the deck's motion at touchdown.
    pub quiescence: Quiescence<R>,
    /// Limits of a descent.
    pub descent: Descent<R>,
    /// Horizon of the predictions, s.
    pub horizon_s: R,
    /// Greatest time to wait for a window, s.
    pub wait_s: R,
    /// Cost of a second of descent, in units of severity.
    pub cost_per_s: R,
}

impl<R: Real> Default for Quiescence<R> {
    /// Deck within 0.25 m/s, ±1.5 m/s² and 0.10 rad; 0.15 m/s relative, response
    /// 0.05 s, one standard deviation, for 0.2 s.
    fn default() -> Self {
        Self {
            speed_mps: r(0.25),
            acceleration_min_mps2: r(-1.5),
            acceleration_max_mps2: r(1.5),
            tilt_rad: r(0.10),
            relative_speed_mps: r(0.15),
            response_s: r(0.05),
            confidence: R::ONE,
            dwell_s: r(0.2),
        }
    }
}

/// Height of the default hover above the end, with its tolerance. Halved, descents from 0.8 m take 2.8 s
/// instead of 2; doubled, one from 1.5 m exceeds the speed limit.
fn low_m<R: Real>() -> R {
    r(0.85)
}

impl<R: Real> Default for Descent<R> {
    /// To 0.1 m at 0.03 m/s (and 0.5 of the deck's uncertainty, up to 0.08 m/s)
    /// within 2.2 to 3.5 s, 0.7 m/s and 3.5 m/s², of which a rough sea takes 2 m/s².
    fn default() -> Self {
        Self {
            end_height_m: r(0.1),
            sink_rate_mps: r(0.03),
            sink_per_sd: r(0.5),
            sink_rate_max_mps: r(0.08),
            duration_min_s: r(2.2),
            duration_max_s: r(3.5),
            speed_mps: r(0.7),
            acceleration_mps2: r(3.5),
            low_m: low_m(),
        }
    }
}

impl<R: Real> Default for Planner<R> {
    /// The defaults of the parts; horizon 10 s, wait 30 s, 0.1 per second.
    fn default() -> Self {
        Self {
            quiescence: Quiescence::default(),
            descent: Descent::default(),
            horizon_s: r(10.0),
            wait_s: r(30.0),
            cost_per_s: r(0.1),
        }
    }
}

impl<R: Real> Quiescence<R> {
    fn validate(&self) -> Result<(), SettingsError> {
        positive("planner.quiescence.speed_mps", self.speed_mps)?;
        ordered(
            "planner.quiescence.acceleration_min_mps2",
            self.acceleration_min_mps2,
            "planner.quiescence.acceleration_max_mps2",
            self.acceleration_max_mps2,
        )?;
        positive("planner.quiescence.tilt_rad", self.tilt_rad)?;
        positive(
            "planner.quiescence.relative_speed_mps",
            self.relative_speed_mps,
        )?;
        not_negative("planner.quiescence.response_s", self.response_s)?;
        not_negative("planner.quiescence.confidence", self.confidence)?;
        not_negative("planner.quiescence.dwell_s", self.dwell_s)
    }
}

impl<R: Real> Descent<R> {
    /// The limits of a descent from a height. Those of the settings hold up to `low_m` above
    /// its end. From higher, durations and greatest speed grow with the square root of
    /// the height, so that the acceleration stays.
    pub(super) fn at_height(&self, start_height_m: R) -> Self {
        let ratio = (start_height_m - self.end_height_m) / self.low_m;
        let factor = ratio.max(R::ONE).finite_or(R::ONE).sqrt();
        Self {
            duration_min_s: self.duration_min_s * factor,
            duration_max_s: self.duration_max_s * factor,
            speed_mps: self.speed_mps * factor,
            ..*self
        }
    }

    /// Whether a descent is within these limits while the deck accelerates by up to
    /// `deck_mps2`.
    pub(super) fn allows(&self, reference: &Terminal<R>, deck_mps2: R) -> bool {
        let t = reference.duration_s;
        if !(t >= self.duration_min_s && t <= self.duration_max_s) || reference.validate().is_err()
        {
            return false;
        }
        let (speed_mps, acceleration_mps2) = quintic::peaks(reference);
        speed_mps <= self.speed_mps && acceleration_mps2 + deck_mps2 <= self.acceleration_mps2
    }

    fn validate(&self) -> Result<(), SettingsError> {
        not_negative("planner.descent.end_height_m", self.end_height_m)?;
        not_negative("planner.descent.sink_rate_mps", self.sink_rate_mps)?;
        not_negative("planner.descent.sink_per_sd", self.sink_per_sd)?;
        within(
            "planner.descent.sink_rate_max_mps",
            self.sink_rate_max_mps,
            self.sink_rate_max_mps >= self.sink_rate_mps,
            "not less than sink_rate_mps",
        )?;
        positive("planner.descent.duration_min_s", self.duration_min_s)?;
        ordered(
            "planner.descent.duration_min_s",
            self.duration_min_s,
            "planner.descent.duration_max_s",
            self.duration_max_s,
        )?;
        positive("planner.descent.speed_mps", self.speed_mps)?;
        positive("planner.descent.acceleration_mps2", self.acceleration_mps2)?;
        positive("planner.descent.low_m", self.low_m)
    }
}

impl<R: Real> Planner<R> {
    /// The greatest height from which the longest descent ends within the horizon, m.
    pub(crate) fn reach_m(&self) -> R {
        let factor = self.horizon_s / self.descent.duration_max_s;
        self.descent.end_height_m + self.descent.low_m * factor * factor
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// Limits must be positive and in their order. The horizon must be longer than the
    /// longest descent, and its steps must resolve the range of durations. The sink rate
    /// at touchdown must be within the relative speed.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.quiescence.validate()?;
        self.descent.validate()?;
        ordered(
            "planner.descent.sink_rate_max_mps",
            self.descent.sink_rate_max_mps,
            "planner.quiescence.relative_speed_mps",
            self.quiescence.relative_speed_mps,
        )?;
        ordered(
            "planner.descent.duration_max_s",
            self.descent.duration_max_s,
            "planner.horizon_s",
            self.horizon_s,
        )?;
        within(
            "planner.horizon_s",
            self.horizon_s,
            self.horizon_s / r(super::STEPS as f64)
                <= self.descent.duration_max_s - self.descent.duration_min_s,
            "at most 128 times duration_max_s less duration_min_s",
        )?;
        not_negative("planner.wait_s", self.wait_s)?;
        not_negative("planner.cost_per_s", self.cost_per_s)
    }
}
