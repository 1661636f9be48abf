//! Reference trajectories of the height above the deck.

use crate::error::{SettingsError, not_negative, ordered, positive, within};
use crate::real::{Real, r};

/// A point of a reference trajectory, relative to the deck.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReferencePoint<R> {
    /// Height z_r, m.
    pub height_m: R,
    /// Velocity z_r', m/s.
    pub velocity_mps: R,
    /// Acceleration z_r'', m/s².
    pub acceleration_mps2: R,
}

/// Eq. (13), critically damped descent,
/// `z_r = h + (z0 - h) (1 + C t) e^(-C t)`: starts at rest, is fastest
/// (`C (z0 - h) / e`) at `t = 1/C`, and approaches the end height.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Exponential<R> {
    /// Rate C, 1/s.
    pub c_per_s: R,
    /// Height at the start z0, m.
    pub start_height_m: R,
    /// Final height h, m.
    pub end_height_m: R,
}

impl<R: Real> Exponential<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// The rate must be positive and the end lie below the start.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("reference.exponential.c_per_s", self.c_per_s)?;
        ordered(
            "reference.exponential.end_height_m",
            self.end_height_m,
            "reference.exponential.start_height_m",
            self.start_height_m,
        )
    }

    /// The reference `time_s` after the start (before it: the start).
    pub fn at(&self, time_s: R) -> ReferencePoint<R> {
        let c = self.c_per_s;
        let u = (c * time_s).max(R::ZERO);
        let scale = (self.start_height_m - self.end_height_m) * (-u).exp();
        ReferencePoint {
            height_m: self.end_height_m + scale * (R::ONE + u),
            velocity_mps: -scale * c * u,
            acceleration_mps2: scale * c * c * (u - R::ONE),
        }
    }

    /// The time at which the reference passes a height, s; `None` for a height
    /// outside the descent.
    pub fn time_to_height_s(&self, height_m: R) -> Option<R> {
        let left = (height_m - self.end_height_m) / (self.start_height_m - self.end_height_m);
        if !(left > R::ZERO && left <= R::ONE) {
            return None;
        }
        // (1 + u) e^(-u) falls from 1 to below the least positive f64 at 760.
        let (mut low, mut high) = (R::ZERO, r::<R>(760.0));
        // 70 halvings resolve an f64.
        for _ in 0..70 {
            let u = r::<R>(0.5) * (low + high);
            if (R::ONE + u) * (-u).exp() > left {
                low = u;
            } else {
                high = u;
            }
        }
        Some(high / self.c_per_s)
    }
}

/// Quintic to a terminal sink rate: from rest at the start height to the end
/// height at `duration_s` with velocity `-sink_rate_mps` and no acceleration,
/// then further at that rate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Terminal<R> {
    /// Height at the start z0, m.
    pub start_height_m: R,
    /// Height at the end of the quintic, m.
    pub end_height_m: R,
    /// Rate of descent at and after the end, m/s.
    pub sink_rate_mps: R,
    /// Duration of the quintic, s.
    pub duration_s: R,
}

impl<R: Real> Terminal<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// The duration must be positive, the end lie below the start, and the sink
    /// rate lie between zero and five halves of the mean rate (above which the
    /// quintic would rise first).
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("reference.terminal.duration_s", self.duration_s)?;
        ordered(
            "reference.terminal.end_height_m",
            self.end_height_m,
            "reference.terminal.start_height_m",
            self.start_height_m,
        )?;
        not_negative("reference.terminal.sink_rate_mps", self.sink_rate_mps)?;
        let mean_rate = (self.start_height_m - self.end_height_m) / self.duration_s;
        within(
            "reference.terminal.sink_rate_mps",
            self.sink_rate_mps,
            self.sink_rate_mps <= r::<R>(2.5) * mean_rate,
            "at most 2.5 times the mean rate of descent",
        )
    }

    /// The reference `time_s` after the start (before it: the start).
    pub fn at(&self, time_s: R) -> ReferencePoint<R> {
        let t_end = self.duration_s;
        if time_s >= t_end {
            return ReferencePoint {
                height_m: self.end_height_m - self.sink_rate_mps * (time_s - t_end),
                velocity_mps: -self.sink_rate_mps,
                acceleration_mps2: R::ZERO,
            };
        }
        let u = (time_s / t_end).max(R::ZERO);
        // z = z0 + u³ (a + b u + c u²) from z = drop, z' = slope, z'' = 0 at u = 1.
        let drop = self.end_height_m - self.start_height_m;
        let slope = -self.sink_rate_mps * t_end;
        let a = r::<R>(10.0) * drop - r::<R>(4.0) * slope;
        let b = r::<R>(7.0) * slope - r::<R>(15.0) * drop;
        let c = r::<R>(6.0) * drop - r::<R>(3.0) * slope;
        ReferencePoint {
            height_m: self.start_height_m + u * u * u * (a + u * (b + u * c)),
            velocity_mps: u * u * (r::<R>(3.0) * a + u * (r::<R>(4.0) * b + u * r::<R>(5.0) * c))
                / t_end,
            acceleration_mps2: u
                * (r::<R>(6.0) * a + u * (r::<R>(12.0) * b + u * r::<R>(20.0) * c))
                / (t_end * t_end),
        }
    }
}

/// A reference trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Reference<R> {
    /// Critically damped descent.
    Exponential(Exponential<R>),
    /// Quintic to a terminal sink rate.
    Terminal(Terminal<R>),
}

impl<R: Real> Reference<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// See [`Exponential::validate`] and [`Terminal::validate`].
    pub fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::Exponential(reference) => reference.validate(),
            Self::Terminal(reference) => reference.validate(),
        }
    }

    /// The height at its end, m.
    pub fn end_height_m(&self) -> R {
        match self {
            Self::Exponential(reference) => reference.end_height_m,
            Self::Terminal(reference) => reference.end_height_m,
        }
    }

    /// The same descent from another height, m.
    #[must_use]
    pub fn starting_at(&self, height_m: R) -> Self {
        match *self {
            Self::Exponential(reference) => Self::Exponential(Exponential {
                start_height_m: height_m,
                ..reference
            }),
            Self::Terminal(reference) => Self::Terminal(Terminal {
                start_height_m: height_m,
                ..reference
            }),
        }
    }

    /// The same descent, start and end higher by `by_m`.
    #[must_use]
    pub fn raised_by(&self, by_m: R) -> Self {
        match *self {
            Self::Exponential(reference) => Self::Exponential(Exponential {
                start_height_m: reference.start_height_m + by_m,
                end_height_m: reference.end_height_m + by_m,
                ..reference
            }),
            Self::Terminal(reference) => Self::Terminal(Terminal {
                start_height_m: reference.start_height_m + by_m,
                end_height_m: reference.end_height_m + by_m,
                ..reference
            }),
        }
    }

    /// The reference `time_s` after the start.
    pub fn at(&self, time_s: R) -> ReferencePoint<R> {
        match self {
            Self::Exponential(reference) => reference.at(time_s),
            Self::Terminal(reference) => reference.at(time_s),
        }
    }
}
