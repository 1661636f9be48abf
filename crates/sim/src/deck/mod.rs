//! Prescribed motion of the deck.
//!
//! This file is the vertical motion of the level deck. [`rigid`] moves it in
//! five degrees of freedom: sums of sines, a ship ([`ship`]) in an irregular sea
//! ([`wave`]), measured series ([`series`]), all as fast splines ([`spline`]). A deck under way has a
//! course besides ([`course`]).

pub mod character;
pub mod course;
mod encounter;
pub mod faults;
pub mod harmonics;
pub mod noise;
pub mod rigid;
pub mod series;
pub mod ship;
pub mod slow;
mod smoothing;
pub mod spline;
pub mod wave;

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;

/// How the deck moves about its mean height 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum DeckMotion {
    /// The deck does not move.
    #[default]
    Still,
    /// `p = A sin(2π f t + φ)`.
    Sine {
        /// Amplitude A, m.
        amplitude_m: f64,
        /// Frequency f, Hz.
        frequency_hz: f64,
        /// Phase φ at t = 0, rad.
        #[serde(default)]
        phase_rad: f64,
    },
    /// Up and down at constant speed between ± the amplitude.
    Triangle {
        /// Amplitude, m.
        amplitude_m: f64,
        /// Speed, m/s.
        speed_mps: f64,
        /// Phase at t = 0, rad: 0 is the mean height, rising.
        #[serde(default)]
        phase_rad: f64,
    },
}

/// The deck at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeckPoint {
    /// Height above its mean, m.
    pub height_m: f64,
    /// Velocity, up, m/s.
    pub velocity_mps: f64,
}

impl DeckMotion {
    /// Checks the motion.
    ///
    /// # Errors
    /// Amplitudes must not be negative; frequency and speed must be positive.
    pub fn validate(&self) -> Result<(), SimError> {
        match *self {
            Self::Still => Ok(()),
            Self::Sine {
                amplitude_m,
                frequency_hz,
                phase_rad,
            } => {
                check::not_negative("amplitude_m", amplitude_m)?;
                check::positive("frequency_hz", frequency_hz)?;
                check::finite("phase_rad", phase_rad)
            }
            Self::Triangle {
                amplitude_m,
                speed_mps,
                phase_rad,
            } => {
                check::positive("amplitude_m", amplitude_m)?;
                check::positive("speed_mps", speed_mps)?;
                check::finite("phase_rad", phase_rad)
            }
        }
    }

    /// Greatest height above the mean, m.
    #[must_use]
    pub fn highest_m(&self) -> f64 {
        match *self {
            Self::Still => 0.0,
            Self::Sine { amplitude_m, .. } | Self::Triangle { amplitude_m, .. } => amplitude_m,
        }
    }

    /// Angular frequency of the (fundamental) motion, rad/s; `None` when still.
    #[must_use]
    pub fn angular_frequency(&self) -> Option<f64> {
        use std::f64::consts::{FRAC_PI_2, TAU};
        match *self {
            Self::Still => None,
            Self::Sine { frequency_hz, .. } => Some(TAU * frequency_hz),
            Self::Triangle {
                amplitude_m,
                speed_mps,
                ..
            } => Some(FRAC_PI_2 * speed_mps / amplitude_m),
        }
    }

    /// The same motion, ahead by a phase in rad.
    #[must_use]
    pub fn advanced(mut self, by_rad: f64) -> Self {
        match &mut self {
            Self::Still => {}
            Self::Sine { phase_rad, .. } | Self::Triangle { phase_rad, .. } => *phase_rad += by_rad,
        }
        self
    }

    /// Acceleration at the time t, m/s²; none between the triangle's corners.
    #[must_use]
    pub fn acceleration_mps2(&self, time_s: f64) -> f64 {
        match self {
            Self::Still | Self::Triangle { .. } => 0.0,
            Self::Sine { frequency_hz, .. } => {
                let omega = std::f64::consts::TAU * frequency_hz;
                -omega * omega * self.at(time_s).height_m
            }
        }
    }

    /// Height and velocity at the time t.
    #[inline]
    #[must_use]
    pub fn at(&self, time_s: f64) -> DeckPoint {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        match *self {
            Self::Still => DeckPoint::default(),
            Self::Sine {
                amplitude_m,
                frequency_hz,
                phase_rad,
            } => {
                let omega = TAU * frequency_hz;
                let (sin, cos) = (omega * time_s + phase_rad).sin_cos();
                DeckPoint {
                    height_m: amplitude_m * sin,
                    velocity_mps: amplitude_m * omega * cos,
                }
            }
            Self::Triangle {
                amplitude_m,
                speed_mps,
                phase_rad,
            } => {
                let angle = FRAC_PI_2 * speed_mps / amplitude_m * time_s + phase_rad + FRAC_PI_2;
                let angle = angle.rem_euclid(TAU);
                let rising = angle < PI;
                let from_low = if rising { angle } else { TAU - angle };
                DeckPoint {
                    height_m: amplitude_m * (from_low / FRAC_PI_2 - 1.0),
                    velocity_mps: if rising { speed_mps } else { -speed_mps },
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motions() -> [DeckMotion; 2] {
        [
            DeckMotion::Sine {
                amplitude_m: 0.05,
                frequency_hz: 0.5,
                phase_rad: 0.3,
            },
            DeckMotion::Triangle {
                amplitude_m: 0.05,
                speed_mps: 0.08,
                phase_rad: 0.3,
            },
        ]
    }

    #[test]
    fn analytic_velocity_is_the_derivative_of_height() {
        for motion in motions() {
            for i in 0..500 {
                let t = 0.0137 * f64::from(i);
                let (a, b) = (motion.at(t - 5e-7), motion.at(t + 5e-7));
                let slope = (b.height_m - a.height_m) / 1e-6;
                // Rounding of a difference over 1e-6 s.
                assert!((slope - motion.at(t).velocity_mps).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn analytic_bounds_and_start() {
        for motion in motions() {
            let heights: Vec<f64> = (0..20_000)
                .map(|i| motion.at(f64::from(i) * 1e-3).height_m)
                .collect();
            let high = heights.iter().copied().fold(f64::MIN, f64::max);
            let low = heights.iter().copied().fold(f64::MAX, f64::min);
            // At 1 ms and 0.157 m/s at most, the peak is met within 8e-5 m.
            assert!((high - 0.05).abs() < 8e-5 && (low + 0.05).abs() < 8e-5);
        }
        let rising = DeckMotion::Triangle {
            amplitude_m: 0.05,
            speed_mps: 0.08,
            phase_rad: 0.0,
        };
        // Rounding only.
        assert!(rising.at(0.0).height_m.abs() < 1e-15 && rising.at(0.0).velocity_mps > 0.0);
    }
}
