use serde::{Deserialize, Serialize};
use std::fmt;

/// The unit of a channel. All are SI, but for the revolution per minute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Unit {
    /// 1.
    Dimensionless,
    /// s.
    Second,
    /// Hz.
    Hertz,
    /// kg.
    Kilogram,
    /// m.
    Metre,
    /// m/s.
    MetrePerSecond,
    /// m/s².
    MetrePerSecondSquared,
    /// rad.
    Radian,
    /// rad/s.
    RadianPerSecond,
    /// 1/min.
    RevolutionPerMinute,
    /// N.
    Newton,
    /// N·m.
    NewtonMetre,
    /// V.
    Volt,
    /// A.
    Ampere,
    /// W.
    Watt,
}

/// Ends of channel names, a longer one before any that it ends with.
const SUFFIXES: [(&str, Unit); 14] = [
    ("_n_m", Unit::NewtonMetre),
    ("_mps2", Unit::MetrePerSecondSquared),
    ("_mps", Unit::MetrePerSecond),
    ("_radps", Unit::RadianPerSecond),
    ("_rad", Unit::Radian),
    ("_rpm", Unit::RevolutionPerMinute),
    ("_hz", Unit::Hertz),
    ("_kg", Unit::Kilogram),
    ("_s", Unit::Second),
    ("_m", Unit::Metre),
    ("_n", Unit::Newton),
    ("_v", Unit::Volt),
    ("_a", Unit::Ampere),
    ("_w", Unit::Watt),
];

/// The unit that the end of a channel's name tells: `thrust_n` is in newton, `torque_n_m` in
/// newton metre, `throttle` without dimension. A number at the end counts the channels of one
/// kind and is passed over: `rotor_rpm_3` is in revolutions per minute, `throttle_3` without
/// dimension.
///
/// ```
/// use touchdown_trial::{Unit, unit_of};
/// assert_eq!(unit_of("deck_velocity_mps"), Unit::MetrePerSecond);
/// assert_eq!(unit_of("rotor_rpm_3").symbol(), "1/min");
/// assert_eq!(unit_of("throttle"), Unit::Dimensionless);
/// ```
#[must_use]
pub fn unit_of(name: &str) -> Unit {
    let kind = match name.rsplit_once('_') {
        Some((kind, number))
            if !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()) =>
        {
            kind
        }
        _ => name,
    };
    SUFFIXES
        .iter()
        .find(|(suffix, _)| kind.len() > suffix.len() && kind.ends_with(suffix))
        .map_or(Unit::Dimensionless, |&(_, unit)| unit)
}

impl Unit {
    /// The symbol, for axes and tables: `m/s²`; `1` where there is no dimension.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Dimensionless => "1",
            Self::Second => "s",
            Self::Hertz => "Hz",
            Self::Kilogram => "kg",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::MetrePerSecondSquared => "m/s²",
            Self::Radian => "rad",
            Self::RadianPerSecond => "rad/s",
            Self::RevolutionPerMinute => "1/min",
            Self::Newton => "N",
            Self::NewtonMetre => "N·m",
            Self::Volt => "V",
            Self::Ampere => "A",
            Self::Watt => "W",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}
