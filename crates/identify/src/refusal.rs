//! What flights do not identify, why, and what to record to cure that.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::estimate::Estimate;

/// Why the ground effect is identified from hovers at rest alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoForce {
    /// No specific force was logged, and poses give none.
    NotMeasured,
    /// The throttle is logged too seldom: between its samples it is not known.
    SlowThrottle {
        /// Time between its samples (s).
        period_s: f64,
        /// The rate that the settings ask for (Hz).
        least_rate_hz: f64,
    },
    /// Hovers check another route, or are more certain than it.
    Beside,
}

impl NoForce {
    pub(super) fn found(&self) -> String {
        match self {
            Self::NotMeasured => "no specific force".into(),
            Self::SlowThrottle { period_s, .. } => format!("throttle logged every {period_s:.3} s"),
            Self::Beside => "a more certain ground effect in them than in passes".into(),
        }
    }

    /// Why hovers alone count.
    pub(super) fn only_hovers(&self) -> String {
        match self {
            Self::Beside => "for this route has hovers alone".into(),
            _ => format!(
                "for the log has {} and hovers are all that counts",
                self.found()
            ),
        }
    }

    pub(super) fn record(&self) -> String {
        match self {
            Self::NotMeasured => "the accelerometer, and the throttle at 100 Hz or more".into(),
            Self::SlowThrottle { least_rate_hz, .. } => {
                format!("throttle at {least_rate_hz} Hz or more")
            }
            Self::Beside => "more flights with the accelerometer".into(),
        }
    }
}

/// What flights do not identify, by the reason. In results it is what, what was found, and what to record.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// Lags of motors and wake: acceleration from poses is smoothed.
    LagsFromPoses,
    /// Lags of motors and wake: the vehicle is at rest in hover.
    LagsFromHovers(NoForce),
    /// Effect of climb: acceleration from poses is smoothed.
    ClimbFromPoses,
    /// Effect of climb: the vehicle is at rest in hover.
    ClimbFromHovers(NoForce),
    /// Effect of climb: neither heights nor climb rates are quick enough.
    NoClimbRate,
    /// Effect of climb: held-out flights are predicted no better with it.
    ClimbPredictsNoBetter,
    /// Effect of climb: confounded with the wake's lag.
    ClimbConfoundedWithLag,
    /// Effect of climb: its interval holds zero.
    ClimbMayBeZero,
    /// Thrust by throttle: hovers alone give no law of it, so a power of throttle is assumed.
    ThrustLawAssumed {
        /// Its exponent.
        exponent: f64,
        /// Standard deviation of that.
        exponent_sd: f64,
    },
    /// Lag of the wake: held-out flights are predicted no better with it.
    WakeLagPredictsNoBetter,
    /// Lag of the wake: its interval, if there is one, is too wide.
    WakeLagUnresolved(Option<Estimate>),
    /// Lag of the motors: the throttle is logged too seldom.
    MotorLagSlowThrottle {
        /// Time between its samples (s).
        period_s: f64,
        /// The rate that the settings ask for (Hz).
        least_rate_hz: f64,
    },
    /// Lag of the motors: acceleration from poses is smoothed.
    MotorLagFromPoses {
        /// The rate that the settings ask for (Hz).
        least_rate_hz: f64,
    },
    /// Lag of the motors: its interval is too wide.
    MotorLagUnresolved(Estimate),
    /// Lag of the motors: the search ends at its upper bound.
    MotorLagAtBound {
        /// The bound (s).
        bound_s: f64,
    },
}

impl Refusal {
    /// What is not identified.
    #[must_use]
    pub fn what(&self) -> &'static str {
        match self {
            Self::LagsFromPoses | Self::LagsFromHovers(_) => "lags of motors and wake",
            Self::ClimbFromPoses
            | Self::ClimbFromHovers(_)
            | Self::NoClimbRate
            | Self::ClimbPredictsNoBetter
            | Self::ClimbConfoundedWithLag
            | Self::ClimbMayBeZero => "effect of climb and sink on the ground effect",
            Self::ThrustLawAssumed { .. } => "thrust by throttle",
            Self::WakeLagPredictsNoBetter | Self::WakeLagUnresolved(_) => "lag of the wake",
            Self::MotorLagSlowThrottle { .. }
            | Self::MotorLagFromPoses { .. }
            | Self::MotorLagUnresolved(_)
            | Self::MotorLagAtBound { .. } => "lag of the motors",
        }
    }

    /// What was found in the logs.
    #[must_use]
    pub fn found(&self) -> String {
        match self {
            Self::LagsFromPoses | Self::ClimbFromPoses | Self::MotorLagFromPoses { .. } => {
                "specific force from poses, smoothed over 0.2 s".into()
            }
            Self::LagsFromHovers(why) | Self::ClimbFromHovers(why) => {
                format!("hovers at rest only, for the logs have {}", why.found())
            }
            Self::NoClimbRate => "no climb rate".into(),
            Self::ClimbPredictsNoBetter | Self::WakeLagPredictsNoBetter => {
                "flights left out are predicted no better with it".into()
            }
            Self::ClimbConfoundedWithLag => "it cannot be told from the wake's lag".into(),
            Self::ClimbMayBeZero => "its interval holds zero".into(),
            Self::ThrustLawAssumed {
                exponent,
                exponent_sd,
            } => format!(
                "no law of it: thrust was taken to go with throttle to the power {exponent} with a standard deviation of \
                 {exponent_sd}, which stands in all intervals"
            ),
            Self::WakeLagUnresolved(None) => "a lag at the bound of its search, or none".into(),
            Self::WakeLagUnresolved(Some(lag)) | Self::MotorLagUnresolved(lag) => format!(
                "{:.3} s, 95 % interval {:.3} to {:.3} s",
                lag.value, lag.ci95[0], lag.ci95[1]
            ),
            Self::MotorLagSlowThrottle { period_s, .. } => {
                format!("throttle logged every {period_s:.3} s")
            }
            Self::MotorLagAtBound { bound_s } => format!(
                "none up to {bound_s} s that fits: slow changes of thrust go with the throttle, quick ones do not"
            ),
        }
    }

    /// What to record to cure that.
    #[must_use]
    pub fn record(&self) -> String {
        match self {
            Self::LagsFromHovers(why) => return why.record(),
            Self::ClimbFromHovers(why) => {
                let record = why.record();
                return format!("{record}, in climbs and descents below two rotor radii");
            }
            Self::MotorLagSlowThrottle { least_rate_hz, .. }
            | Self::MotorLagFromPoses { least_rate_hz } => {
                return format!("throttle and accelerometer at {least_rate_hz} Hz or more");
            }
            Self::LagsFromPoses | Self::ClimbFromPoses => {
                "the accelerometer (`specific_force_mps2`) at 100 Hz or more"
            }
            Self::NoClimbRate => "height or climb rate at 20 Hz or more",
            Self::ClimbPredictsNoBetter | Self::ClimbConfoundedWithLag | Self::ClimbMayBeZero => {
                "climbs and descents through the same heights below two rotor radii at 0.1 to 0.5 m/s"
            }
            Self::ThrustLawAssumed { .. } => {
                "rotor speeds (`rotor_rpm`), or identify with a thrust card from a thrust stand"
            }
            Self::WakeLagPredictsNoBetter | Self::WakeLagUnresolved(_) => {
                "quick climbs and descents below two rotor radii, back and forth within a second, in several flights"
            }
            Self::MotorLagUnresolved(_) | Self::MotorLagAtBound { .. } => {
                "quick throttle pulses out of ground effect, a second up and a second down"
            }
        }
        .into()
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, found, record) = (self.what(), self.found(), self.record());
        write!(f, "{what} not identified: {found}; record {record}")
    }
}

impl Serialize for Refusal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Texts {
            what: &'static str,
            found: String,
            record: String,
        }
        Texts {
            what: self.what(),
            found: self.found(),
            record: self.record(),
        }
        .serialize(serializer)
    }
}
