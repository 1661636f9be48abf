//! Thrust: in newtons, upwards, of all rotors, with the load cell's zero at rest.

use super::{DataWarning, label, quantile, sorted};
use crate::error::{Error, Result};
use crate::map_line::map_line;
use crate::rig::GroundTrial;
use crate::rig::trial::greatest_n;
use crate::thrust_scale::ThrustCause;

/// Share of the rows that counts as far from the deck: the highest third.
const FAR_SHARE: f64 = 2.0 / 3.0;
/// Share of the greatest free-air thrust below which a row has no ratio: noise would be divided by nearly nothing.
const LEAST_SHARE: f64 = 0.1;
/// Ratios of measured to free-air thrust that a ground effect, another battery or air density explain. Outside, the log
/// has another unit, sign, zero or number of rotors than the card: the greatest effects at half a radius add 50 to 60 %.
const POSSIBLE: [f64; 2] = [0.5, 2.0];

/// Median throttle above which it is no share of the greatest command: in percent, 1.5 is idle.
const MOST_THROTTLE: f64 = 1.5;
/// What to do where no cause is known.
const UNKNOWN: &str = "Check that the thrust card is of this vehicle with this battery, and that `thrust_n` is the force on all of it, in newtons";

/// Compares the measured thrust with that of the card where the deck is far. Refuses what no ground effect explains, and
/// warns of what the card could not express.
pub(super) fn check(trials: &[GroundTrial], ratio_limits: [f64; 2]) -> Result<Option<DataWarning>> {
    check_throttle(trials)?;
    let (free_n, measured_n) = far_rows(trials);
    let ratios = free_n.iter().zip(&measured_n).map(|(t, f)| f / t);
    let Some(ratio) = quantile(&sorted(ratios), 0.5) else {
        return Ok(None);
    };
    let limits = ratio_limits.map(|r| 1.0 + r);
    if (limits[0]..=limits[1]).contains(&ratio) {
        return Ok(None);
    }
    let cause = ThrustCause::of(&free_n, &measured_n);
    let sentence = cause.map_or_else(|| UNKNOWN.to_string(), |cause| cause.to_string());
    if (POSSIBLE[0]..=POSSIBLE[1]).contains(&ratio) {
        return Ok(Some(DataWarning::ThrustOffCard {
            ratio,
            limits,
            cause: sentence,
        }));
    }
    Err(Error::data(
        label(trials),
        "a measured thrust (`thrust_n`) near that of the thrust card far from the deck",
        format!("{ratio:.3} times that of the card. {sentence}"),
    ))
}

/// A throttle is a share of the greatest command.
fn check_throttle(trials: &[GroundTrial]) -> Result<()> {
    let throttles = trials.iter().flat_map(|t| t.throttle.iter().copied());
    match quantile(&sorted(throttles), 0.5) {
        Some(middle) if middle > MOST_THROTTLE => Err(Error::data(
            label(trials),
            "a throttle from 0 to 1",
            format!(
                "{middle}, the median: is it in percent? Then {}; of pulses in microseconds (`throttle` - 1000)/1000",
                map_line("throttle", "0.01 * ", "")
            ),
        )),
        _ => Ok(()),
    }
}

/// Free-air and measured thrust of the rows of the greatest heights.
fn far_rows(trials: &[GroundTrial]) -> (Vec<f64>, Vec<f64>) {
    let heights = sorted(trials.iter().flat_map(|t| t.height_m.iter().copied()));
    let from_m = quantile(&heights, FAR_SHARE).unwrap_or(f64::NAN);
    let least_n = LEAST_SHARE * greatest_n(trials);
    trials
        .iter()
        .flat_map(|t| {
            let forces = t.free_air_thrust_n.iter().zip(&t.force_n);
            t.height_m.iter().zip(forces)
        })
        .filter(|(z, (free_n, force_n))| **z >= from_m && **free_n > least_n && force_n.is_finite())
        .map(|(_, (free_n, force_n))| (*free_n, free_n + force_n))
        .unzip()
}
