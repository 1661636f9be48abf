//! Random values of a trial.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use statrs::distribution::{ContinuousCDF as _, Normal};

/// Distribution of a setting whose value is random in every trial.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Distribution {
    /// Every number from `min` to `max` alike.
    Uniform {
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// Every ratio alike: the logarithm is uniform.
    LogUniform {
        /// Least value, above 0.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// The normal distribution, cut off at `min` and `max` where they are given.
    Normal {
        /// Mean before the cut.
        mean: f64,
        /// Standard deviation before the cut.
        sd: f64,
        /// Least value.
        #[serde(skip_serializing_if = "Option::is_none")]
        min: Option<f64>,
        /// Greatest value.
        #[serde(skip_serializing_if = "Option::is_none")]
        max: Option<f64>,
    },
    /// One of the values, all alike.
    Choice {
        /// The values.
        of: Vec<toml::Value>,
    },
}

impl Distribution {
    /// Checks the distribution; the message says what was expected and found.
    pub(super) fn check(&self) -> Result<(), String> {
        let ordered = |key: &str, low: f64, high: f64| {
            if low.is_finite() && high.is_finite() && low < high {
                return Ok(());
            }
            Err(format!(
                "{key}: expected `min` below `max`, found {low} and {high}"
            ))
        };
        match self {
            Self::Uniform { min, max } => ordered("uniform", *min, *max),
            Self::LogUniform { min, max } => {
                if !(*min > 0.0) {
                    return Err(format!("log_uniform: expected `min` above 0, found {min}"));
                }
                ordered("log_uniform", *min, *max)
            }
            Self::Normal { mean, sd, min, max } => {
                if !(*sd > 0.0 && sd.is_finite() && mean.is_finite()) {
                    return Err(format!(
                        "normal: expected a finite `mean` and an `sd` above 0, found {mean} and {sd}"
                    ));
                }
                let (low, high) = (min.unwrap_or(f64::MIN), max.unwrap_or(f64::MAX));
                ordered("normal", low, high)?;
                // Eight standard deviations out, doubles have no values left to draw.
                if low > mean + 8.0 * sd || high < mean - 8.0 * sd {
                    return Err(format!(
                        "normal: expected limits within 8 `sd` of `mean`, found {low} to {high}"
                    ));
                }
                Ok(())
            }
            Self::Choice { of } if of.is_empty() => {
                Err("choice: expected at least one value in `of`, found none".into())
            }
            Self::Choice { .. } => Ok(()),
        }
    }

    /// The least and the greatest value that can be drawn, each with the limit next to it, and all of a choice, twice.
    /// Those of a normal distribution are not among them: they lie where nothing is ever drawn.
    pub(super) fn ends(&self) -> Vec<[toml::Value; 2]> {
        match self {
            Self::Uniform { min, max } | Self::LogUniform { min, max } => {
                let [least, greatest] = SHARES.map(|share| self.at(share));
                vec![[least, (*min).into()], [greatest, (*max).into()]]
            }
            Self::Normal { .. } => Vec::new(),
            Self::Choice { of } => of.iter().map(|v| [v.clone(), v.clone()]).collect(),
        }
    }

    /// The value of a trial: a function of seed, trial and key alone, so that a further key changes no other.
    pub(super) fn draw(&self, seed: u64, trial: u64, key: &str) -> toml::Value {
        self.at(uniform(seed, trial, key))
    }

    /// The value that replaces one that was not accepted, for the n-th time.
    pub(super) fn redraw(&self, seed: u64, trial: u64, key: &str, n: u32) -> toml::Value {
        self.draw(seed, trial, &format!("{key}#{n}"))
    }

    /// The value below which a share of all draws lies.
    fn at(&self, share: f64) -> toml::Value {
        match self {
            Self::Uniform { min, max } => (min + share * (max - min)).into(),
            Self::LogUniform { min, max } => {
                (min * (max / min).powf(share)).clamp(*min, *max).into()
            }
            Self::Normal { mean, sd, min, max } => {
                let (low, high) = (
                    min.unwrap_or(f64::NEG_INFINITY),
                    max.unwrap_or(f64::INFINITY),
                );
                let cut = |low: f64, high: f64| {
                    Normal::new(*mean, *sd).map_or(*mean, |normal| {
                        let (from, to) = (normal.cdf(low), normal.cdf(high));
                        normal.inverse_cdf(from + share * (to - from))
                    })
                };
                // Doubles near 0 tell a tail's values apart, those near 1 do not: of what
                // lies above the mean the mirror image is drawn.
                let value = if low > *mean {
                    2.0 * mean - cut(2.0 * mean - high, 2.0 * mean - low)
                } else {
                    cut(low, high)
                };
                value.clamp(low, high).into()
            }
            Self::Choice { of } => {
                let place = ((share * of.len() as f64) as usize).min(of.len() - 1);
                of[place].clone()
            }
        }
    }
}

/// The least and the greatest number of [`uniform`].
const SHARES: [f64; 2] = [0.5 * f64::EPSILON, 1.0 - 0.5 * f64::EPSILON];

/// A number above 0 and below 1 from the SHA-256 of what it is for.
fn uniform(seed: u64, trial: u64, key: &str) -> f64 {
    let mut hash = Sha256::new();
    hash.update(seed.to_le_bytes());
    hash.update(trial.to_le_bytes());
    hash.update(key.as_bytes());
    let first = hash
        .finalize()
        .iter()
        .take(8)
        .fold(0_u64, |sum, byte| (sum << 8) | u64::from(*byte));
    share_of(first)
}

/// The number of 64 random bits.
fn share_of(bits: u64) -> f64 {
    // 52 bits and a half: never 0, never 1.
    ((bits >> 12) as f64 + 0.5) / 2.0_f64.powi(52)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(of: &Distribution, count: u64) -> Vec<f64> {
        (0..count)
            .map(|trial| of.draw(1, trial, "key").as_float().unwrap())
            .collect()
    }

    #[test]
    fn analytic_moments_of_draws() {
        let uniform = values(
            &Distribution::Uniform {
                min: -1.0,
                max: 3.0,
            },
            4000,
        );
        let normal = values(
            &Distribution::Normal {
                mean: 2.0,
                sd: 0.5,
                min: None,
                max: None,
            },
            4000,
        );
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        // Four standard errors: 4/√12/√4000 = 0.018 and 0.5/√4000 = 0.008.
        assert!((mean(&uniform) - 1.0).abs() < 0.073, "{}", mean(&uniform));
        assert!((mean(&normal) - 2.0).abs() < 0.032, "{}", mean(&normal));
        let sd = (normal.iter().map(|v| (v - 2.0).powi(2)).sum::<f64>() / 4000.0).sqrt();
        // The standard error of a standard deviation is σ/√(2n) = 0.0056.
        assert!((sd - 0.5).abs() < 0.023, "{sd}");
        let ratio = values(
            &Distribution::LogUniform {
                min: 0.1,
                max: 10.0,
            },
            4000,
        );
        // As many below 1 as above: four standard errors of a share are 0.032.
        let below = ratio.iter().filter(|v| **v < 1.0).count() as f64 / 4000.0;
        assert!((below - 0.5).abs() < 0.032, "{below}");
    }

    #[test]
    fn prop_limits_are_kept_and_choices_are_all_made() {
        let cut = Distribution::Normal {
            mean: 0.0,
            sd: 1.0,
            min: Some(0.5),
            max: Some(0.6),
        };
        assert!(values(&cut, 200).iter().all(|v| (0.5..=0.6).contains(v)));
        // As far out as can be: exponential there, with a mean of sd/8 beyond the limit and
        // a median of ln 2 of that, less a few hundredths by the curvature.
        for side in [1.0, -1.0] {
            let limit = Some(side * 8.0);
            let tail = Distribution::Normal {
                mean: 0.0,
                sd: 1.0,
                min: limit.filter(|_| side > 0.0),
                max: limit.filter(|_| side < 0.0),
            };
            tail.check().unwrap();
            let mut beyond: Vec<f64> = values(&tail, 1000).iter().map(|v| side * v - 8.0).collect();
            beyond.sort_by(f64::total_cmp);
            assert!(beyond[0] >= 0.0 && beyond[999].is_finite(), "{side}");
            // Standard error of the median: 1/(2 f √n) = 0.004.
            assert!(
                (beyond[500] - 0.0855).abs() < 0.012,
                "{side} {}",
                beyond[500]
            );
            assert!(beyond.windows(2).all(|pair| pair[0] < pair[1]), "{side}");
        }
        let choice = Distribution::Choice {
            of: vec![1.0.into(), 2.0.into(), 3.0.into()],
        };
        let made = values(&choice, 100);
        assert!([1.0, 2.0, 3.0].iter().all(|v| made.contains(v)));
        // Keys, seeds and trials draw apart.
        assert_ne!(uniform(1, 0, "a"), uniform(1, 0, "b"));
        assert_ne!(uniform(1, 0, "a"), uniform(2, 0, "a"));
    }

    #[test]
    fn prop_ends_are_what_can_be_drawn() {
        assert_eq!(SHARES, [share_of(0), share_of(u64::MAX)]);
        let (min, max) = (0.0, 2.0);
        let ends = Distribution::Uniform { min, max }.ends();
        let drawn = SHARES.map(|share| 2.0 * share);
        assert_eq!(
            ends,
            [[drawn[0], min], [drawn[1], max]].map(|end| end.map(Into::into))
        );
        assert_ne!(drawn, [min, max]);
    }

    #[test]
    fn prop_what_cannot_be_drawn_is_said() {
        for (bad, said) in [
            (
                Distribution::Uniform { min: 2.0, max: 1.0 },
                "found 2 and 1",
            ),
            (
                Distribution::LogUniform { min: 0.0, max: 1.0 },
                "above 0, found 0",
            ),
            (
                Distribution::Normal {
                    mean: 0.0,
                    sd: -1.0,
                    min: None,
                    max: None,
                },
                "-1",
            ),
            (
                Distribution::Normal {
                    mean: 0.0,
                    sd: 1.0,
                    min: Some(9.0),
                    max: None,
                },
                "8 `sd`",
            ),
            (Distribution::Choice { of: Vec::new() }, "found none"),
        ] {
            assert!(bad.check().unwrap_err().contains(said), "{bad:?}");
        }
    }
}
