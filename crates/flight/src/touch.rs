//! When a touch is a landing, a hard landing or a crash: the one definition of simulations, campaigns and flights.
//!
//! | class | speed v towards the deck at the touch, with the crash speed v_c |
//! | --- | --- |
//! | [`TouchClass::Soft`] | `v ≤ v_c / 2` |
//! | [`TouchClass::Hard`] | `v_c / 2 < v ≤ v_c`: it has landed, with up to the energy that the legs bear |
//! | [`TouchClass::Crash`] | `v > v_c`: it has not landed |

use crate::real::{Real, r};

/// Crash speed by default, m/s: that of a fall from 2 cm, which legs of small multirotors bear. At half of it, landings at a
/// usual 0.3 to 0.5 m/s in wind are crashes; at twice, broken legs are landings.
pub const CRASH_MPS: f64 = 0.6;

/// Share of the crash speed above which a landing is hard: a quarter of the energy of a crash. At half of the share, most
/// landings in gusts are hard; at twice, none is.
pub const HARD_SHARE: f64 = 0.5;

/// Class of a touch by its speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum TouchClass {
    /// Landed.
    Soft,
    /// Landed hard.
    Hard,
    /// Crashed.
    Crash,
}

impl TouchClass {
    /// The class of a touch at `speed_mps` towards the deck. A speed that is not a number is a crash.
    pub fn of<R: Real>(speed_mps: R, crash_mps: R) -> Self {
        if speed_mps <= crash_mps * r(HARD_SHARE) {
            Self::Soft
        } else if speed_mps <= crash_mps {
            Self::Hard
        } else {
            Self::Crash
        }
    }

    /// The class in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Soft => "landed",
            Self::Hard => "landed hard",
            Self::Crash => "crashed",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_classes_meet_at_half_and_at_the_whole_crash_speed() {
        let of = |v| TouchClass::of(v, 0.6);
        assert_eq!(of(-0.2), TouchClass::Soft);
        assert_eq!(of(0.3), TouchClass::Soft);
        assert_eq!(of(0.300_001), TouchClass::Hard);
        assert_eq!(of(0.6), TouchClass::Hard);
        assert_eq!(of(0.600_001), TouchClass::Crash);
        assert_eq!(of(f64::NAN), TouchClass::Crash);
    }
}
