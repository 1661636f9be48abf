//! Why a measured thrust is not that of a card: another unit, sign, zero, or number of rotors.

use std::fmt;

use crate::map_line::map_line;
use crate::thrust::plateau::{median, tenths};

/// Standard gravity (m/s²), which load cells in grams and kilograms are calibrated by.
const GRAVITY_MPS2: f64 = 9.806_65;
/// Ratio of a measured to a predicted thrust, over that of a cause, in which the cause is possible: the ground effect adds up to 60 %,
/// a low battery takes up to 20 %.
const AROUND: [f64; 2] = [0.8, 1.6];
/// Numbers of rotors that a load cell or a card may have one of.
const ROTORS: [u32; 5] = [2, 3, 4, 6, 8];
/// Least spread of the predicted thrust, over its median, at which an offset differs from a factor: below it, noise of a few
/// per cent decides.
const LEAST_SPREAD: f64 = 0.1;
/// Size of a ratio below which nothing is left of the thrust: below that of kilograms for newtons, 0.102 · 0.8.
const NOTHING_LEFT: f64 = 0.08;
/// Change of measured with predicted thrust that is that of newtons.
const SLOPE_OF_NEWTONS: [f64; 2] = [0.6, 1.7];

/// Why a measured thrust is not that of a card.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ThrustCause {
    /// The sensor is mounted upside down.
    Inverted,
    /// Grams for newtons.
    Grams,
    /// Kilograms for newtons.
    Kilograms,
    /// Millinewtons for newtons.
    Millinewtons,
    /// The log has the thrust of one of so many rotors.
    OneOf(u32),
    /// The card has the thrust of one of so many rotors.
    CardOfOneOf(u32),
    /// The sensor was set to zero under this load (N); absent where it differs between logs.
    Tared(Option<f64>),
}

impl ThrustCause {
    /// Why `measured_n` is not `predicted_n`; `None` where it is, or for a reason that is not here.
    #[must_use]
    pub(crate) fn of(predicted_n: &[f64], measured_n: &[f64]) -> Option<Self> {
        let pairs = || {
            let pairs = predicted_n.iter().zip(measured_n);
            pairs.filter(|(p, m)| p.is_finite() && m.is_finite() && **p > 0.0)
        };
        let ratio = median(pairs().map(|(p, m)| m / p))?;
        if (AROUND[0]..=AROUND[1]).contains(&ratio) {
            return None;
        }
        let middle_n = median(pairs().map(|(p, _)| *p))?;
        let [low_n, high_n] = tenths(pairs().map(|(p, _)| *p))?;
        if high_n - low_n > LEAST_SPREAD * middle_n {
            let slope = slope(pairs().map(|(p, m)| (*p, *m)))?;
            if (SLOPE_OF_NEWTONS[0]..=SLOPE_OF_NEWTONS[1]).contains(&slope) {
                let tare_n = median(pairs().map(|(p, m)| p - m));
                return Some(Self::Tared(tare_n));
            }
        }
        Self::of_ratio(ratio)
    }

    /// The cause of a ratio of measured to predicted thrust, by the nearest factor.
    fn of_ratio(ratio: f64) -> Option<Self> {
        if ratio.abs() < NOTHING_LEFT {
            return Some(Self::Tared(None));
        }
        if ratio < 0.0 {
            return Some(Self::Inverted);
        }
        let units = [
            (Self::Grams, 1000.0 / GRAVITY_MPS2),
            (Self::Kilograms, 1.0 / GRAVITY_MPS2),
            (Self::Millinewtons, 1000.0),
        ];
        let rotors = ROTORS.into_iter().flat_map(|n| {
            let factor = f64::from(n);
            [
                (Self::OneOf(n), 1.0 / factor),
                (Self::CardOfOneOf(n), factor),
            ]
        });
        let distance = |factor: f64| (ratio / factor).ln().abs();
        units
            .into_iter()
            .chain(rotors)
            .filter(|(_, factor)| (AROUND[0]..=AROUND[1]).contains(&(ratio / factor)))
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))
            .map(|(cause, _)| cause)
    }
}

/// Slope of a straight line by least squares.
fn slope(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Option<f64> {
    let n = pairs.clone().count() as f64;
    let sum = |f: fn((f64, f64)) -> f64| pairs.clone().map(f).sum::<f64>() / n;
    let (x, y) = (sum(|p| p.0), sum(|p| p.1));
    let covariance = pairs.clone().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>();
    let variance = pairs.map(|p| (p.0 - x).powi(2)).sum::<f64>();
    (variance > 0.0).then(|| covariance / variance)
}

impl fmt::Display for ThrustCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let map = |f: &mut fmt::Formatter<'_>, question: &str, before: &str, after: &str| {
            let line = map_line("thrust_n", before, after);
            write!(f, "{question}? Then {line}")
        };
        match self {
            Self::Inverted => map(f, "Is the load cell inverted", "-", ""),
            Self::Grams => map(f, "Is `thrust_n` in grams", "9.80665e-3 * ", ""),
            Self::Kilograms => map(f, "Is `thrust_n` in kilograms", "9.80665 * ", ""),
            Self::Millinewtons => map(f, "Is `thrust_n` in millinewtons", "0.001 * ", ""),
            Self::OneOf(n) => map(
                f,
                &format!("Is `thrust_n` the force on one of {n} rotors"),
                &format!("{n} * "),
                "",
            ),
            Self::CardOfOneOf(n) => write!(
                f,
                "Is the thrust card that of one of {n} rotors? Then identify the thrust of all of them"
            ),
            Self::Tared(Some(tare_n)) => map(
                f,
                &format!(
                    "It changes by the same newtons as that of the card, {tare_n:.2} N below. Was the load cell set to zero while the rotors turned"
                ),
                "",
                &format!(" + {tare_n:.2}"),
            ),
            Self::Tared(None) => f.write_str(
                "Was the load cell set to zero while the rotors turned? Then add that thrust to `thrust_n` in the map, for each log its own, \
                 or record again with the zero at rest",
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thrusts of 8 to 12 N, and what a load cell makes of them.
    fn cause(measured: impl Fn(f64) -> f64) -> Option<ThrustCause> {
        let predicted: Vec<f64> = (0..100).map(|i| 8.0 + 0.04 * f64::from(i)).collect();
        let measured: Vec<f64> = predicted.iter().map(|p| measured(1.1 * p)).collect();
        ThrustCause::of(&predicted, &measured)
    }

    #[test]
    fn analytic_each_cause_is_told_from_the_others() {
        // A ground effect of 10 % is in all of them.
        assert_eq!(cause(|f| f), None);
        assert_eq!(cause(|f| -f), Some(ThrustCause::Inverted));
        assert_eq!(cause(|f| f / 9.80665e-3), Some(ThrustCause::Grams));
        assert_eq!(cause(|f| f / 9.80665), Some(ThrustCause::Kilograms));
        assert_eq!(cause(|f| 1000.0 * f), Some(ThrustCause::Millinewtons));
        assert_eq!(cause(|f| f / 4.0), Some(ThrustCause::OneOf(4)));
        assert_eq!(cause(|f| 4.0 * f), Some(ThrustCause::CardOfOneOf(4)));
        let Some(ThrustCause::Tared(Some(tare_n))) = cause(|f| f - 11.0) else {
            panic!("a tare");
        };
        // 11 N less the effect of 10 % at the median of 9.98 N.
        assert!((tare_n - (11.0 - 0.998)).abs() < 0.01, "{tare_n}");
        // Each log with a zero of its own: nothing follows the predicted thrust.
        assert_eq!(cause(|_| 0.1), Some(ThrustCause::Tared(None)));
        assert_eq!(cause(|f| 17.0 * f), None);
    }
}
