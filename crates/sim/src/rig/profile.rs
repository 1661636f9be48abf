//! Prescribed signals of the rig: value and rate at any time.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// A throttle or the height of the vehicle above the plate, over time. Values
/// are in the unit of the signal, rates in that unit per second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Profile {
    /// The same value throughout.
    Constant {
        /// The value.
        value: f64,
    },
    /// Hold `from`, move to `to` at a constant rate, then hold there or, if
    /// `back`, move back at once and hold `from` again.
    Ramp {
        /// First value.
        from: f64,
        /// Second value.
        to: f64,
        /// Speed of the move, above 0.
        rate: f64,
        /// Time before the move, s.
        #[serde(default)]
        hold_s: f64,
        /// Whether to return.
        #[serde(default)]
        back: bool,
    },
    /// Hold a value, then `mean + amplitude sin(ω (t - hold_s))`.
    Sine {
        /// Mean.
        mean: f64,
        /// Amplitude.
        amplitude: f64,
        /// Angular frequency ω, rad/s.
        angular_frequency: f64,
        /// Time before the sine, s.
        #[serde(default)]
        hold_s: f64,
        /// Value before the sine; the mean if absent.
        #[serde(default)]
        hold_value: Option<f64>,
    },
    /// Between two bounds at constant speed, from `high` downwards first.
    Triangle {
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// Speed, above 0.
        speed: f64,
    },
    /// Sum of sines of equal amplitude, frequencies in geometric progression,
    /// phases drawn from the trial's seed.
    MultiSine {
        /// Mean.
        mean: f64,
        /// Sum of all amplitudes: the greatest possible excursion.
        amplitude: f64,
        /// Number of tones, at least 2.
        tones: usize,
        /// Lowest angular frequency, rad/s.
        lowest: f64,
        /// Highest angular frequency, rad/s.
        highest: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Tone {
    angular_frequency: f64,
    phase_rad: f64,
}

/// A profile with its random phases drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    profile: Profile,
    tones: Vec<Tone>,
}

impl Profile {
    /// Checks the profile and draws its phases, if it has any, from `stream`.
    ///
    /// # Errors
    /// Rates and frequencies must be positive, times not negative, all finite.
    pub fn resolve(&self, stream: &mut Stream) -> Result<Signal, SimError> {
        let mut drawn = Vec::new();
        match *self {
            Self::Constant { value } => check::finite("value", value)?,
            Self::Ramp {
                from,
                to,
                rate,
                hold_s,
                ..
            } => {
                check::finite("from", from)?;
                check::finite("to", to)?;
                check::positive("rate", rate)?;
                check::not_negative("hold_s", hold_s)?;
            }
            Self::Sine {
                mean,
                amplitude,
                angular_frequency,
                hold_s,
                hold_value,
            } => {
                check::finite("mean", mean)?;
                check::not_negative("amplitude", amplitude)?;
                check::positive("angular_frequency", angular_frequency)?;
                check::not_negative("hold_s", hold_s)?;
                check::finite("hold_value", hold_value.unwrap_or(mean))?;
            }
            Self::Triangle { low, high, speed } => {
                check::finite("low", low)?;
                check::finite("high", high)?;
                check::that(high > low, "high", "a number above `low`", high)?;
                check::positive("speed", speed)?;
            }
            Self::MultiSine {
                mean,
                amplitude,
                tones,
                lowest,
                highest,
            } => {
                check::finite("mean", mean)?;
                check::not_negative("amplitude", amplitude)?;
                check::within("tones", tones as f64, 2.0, 1000.0)?;
                check::positive("lowest", lowest)?;
                check::positive("highest", highest)?;
                check::that(highest > lowest, "highest", "above `lowest`", highest)?;
                let ratio = (highest / lowest).powf(1.0 / (tones - 1) as f64);
                drawn.extend((0..tones).map(|tone| Tone {
                    angular_frequency: lowest * ratio.powf(tone as f64),
                    phase_rad: TAU * stream.uniform(),
                }));
            }
        }
        Ok(Signal {
            profile: *self,
            tones: drawn,
        })
    }

    /// Least and greatest value that the profile can take.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        match *self {
            Self::Constant { value } => (value, value),
            Self::Ramp { from, to, .. } => (from.min(to), from.max(to)),
            Self::Sine {
                mean,
                amplitude,
                hold_value,
                ..
            } => {
                let held = hold_value.unwrap_or(mean);
                (held.min(mean - amplitude), held.max(mean + amplitude))
            }
            Self::Triangle { low, high, .. } => (low, high),
            Self::MultiSine {
                mean, amplitude, ..
            } => (mean - amplitude, mean + amplitude),
        }
    }
}

impl Signal {
    /// Value and rate at the time `t` in s, from 0.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> (f64, f64) {
        match self.profile {
            Profile::Constant { value } => (value, 0.0),
            Profile::Ramp {
                from,
                to,
                rate,
                hold_s,
                back,
            } => {
                let span = to - from;
                let moved = (t - hold_s) * rate;
                let length = span.abs();
                if moved < 0.0 {
                    (from, 0.0)
                } else if moved < length {
                    (from + moved * span.signum(), rate * span.signum())
                } else if !back {
                    (to, 0.0)
                } else if moved < 2.0 * length {
                    (to - (moved - length) * span.signum(), -rate * span.signum())
                } else {
                    (from, 0.0)
                }
            }
            Profile::Sine {
                mean,
                amplitude,
                angular_frequency,
                hold_s,
                hold_value,
            } => {
                if t < hold_s {
                    (hold_value.unwrap_or(mean), 0.0)
                } else {
                    let (sin, cos) = (angular_frequency * (t - hold_s)).sin_cos();
                    (mean + amplitude * sin, amplitude * angular_frequency * cos)
                }
            }
            Profile::Triangle { low, high, speed } => {
                let span = high - low;
                let along = (t * speed).rem_euclid(2.0 * span);
                if along < span {
                    (high - along, -speed)
                } else {
                    (low + (along - span), speed)
                }
            }
            Profile::MultiSine {
                mean, amplitude, ..
            } => {
                let each = amplitude / self.tones.len() as f64;
                self.tones.iter().fold((mean, 0.0), |(value, rate), tone| {
                    let w = tone.angular_frequency;
                    let (sin, cos) = (w * t + tone.phase_rad).sin_cos();
                    (value + each * sin, rate + each * w * cos)
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    fn profiles() -> Vec<Profile> {
        vec![
            Profile::Constant { value: 0.4 },
            Profile::Ramp {
                from: 0.75,
                to: 0.10,
                rate: 0.2,
                hold_s: 1.0,
                back: true,
            },
            Profile::Ramp {
                from: 0.2,
                to: 0.8,
                rate: 0.06,
                hold_s: 0.5,
                back: false,
            },
            Profile::Sine {
                mean: 0.5,
                amplitude: 0.25,
                angular_frequency: 0.8,
                hold_s: 2.0,
                hold_value: Some(0.25),
            },
            Profile::Triangle {
                low: 0.1,
                high: 0.3,
                speed: 0.08,
            },
            Profile::MultiSine {
                mean: 0.25,
                amplitude: 0.15,
                tones: 8,
                lowest: 0.6,
                highest: 7.0,
            },
        ]
    }

    #[test]
    fn analytic_rate_is_the_derivative_and_bounds_hold() {
        for profile in profiles() {
            let mut stream = Stream::new(5, 0, Purpose::Signal);
            let signal = profile.resolve(&mut stream).expect("valid profile");
            let (low, high) = profile.bounds();
            for i in 0..20_000 {
                // Odd multiples keep clear of the corners.
                let t = 1e-3 + 0.001_370_3 * f64::from(i);
                let (a, b) = (signal.at(t - 5e-7).0, signal.at(t + 5e-7).0);
                let (value, rate) = signal.at(t);
                let corner = (signal.at(t - 5e-7).1 - signal.at(t + 5e-7).1).abs() > 1e-4;
                // Rounding of a difference over 1e-6 s.
                assert!(
                    corner || ((b - a) / 1e-6 - rate).abs() < 1e-8,
                    "{profile:?} {t}"
                );
                assert!(value >= low - 1e-12 && value <= high + 1e-12);
            }
        }
    }

    #[test]
    fn analytic_starts_turns_and_ends() {
        let mut stream = Stream::new(5, 0, Purpose::Signal);
        let mut at = |profile: &Profile, t: f64| {
            profile.resolve(&mut stream).expect("valid profile").at(t).0
        };
        let all = profiles();
        // Rounding only in all of these.
        for (profile, t, value) in [
            (1, 0.0, 0.75),
            (1, 1.0 + 0.65 / 0.2, 0.10),
            (1, 60.0, 0.75),
            (2, 60.0, 0.8),
            (3, 1.9, 0.25),
            (3, 2.0, 0.5),
            (4, 0.0, 0.3),
            (4, 2.5, 0.1),
            (4, 5.0, 0.3),
        ] {
            assert!((at(&all[profile], t) - value).abs() < 1e-12);
        }
    }

    #[test]
    fn prop_phases_follow_the_seed() {
        let value = |seed| {
            let mut stream = Stream::new(seed, 0, Purpose::Signal);
            let signal = profiles()[5].resolve(&mut stream).expect("valid profile");
            signal.at(1.0).0
        };
        assert_eq!(value(1), value(1));
        assert_ne!(value(1), value(2));
    }
}
