//! Whether the channels of a force rig have the units, signs and zeros that the fit takes them to have.
//!
//! What no rig measures is an error. What is possible but does not fit together is a warning. Both name the channel and
//! what to write into the map.

mod height;
mod thrust;
mod velocity;

use std::fmt;

use super::GroundTrial;
use crate::error::Result;
use crate::map_line::map_line;
use crate::settings::GroundEffectSettings;

/// What the channels of a force rig show of their units, signs and zeros.
#[derive(Clone, Debug, PartialEq)]
pub enum DataWarning {
    /// Some heights are below the deck.
    HeightsBelowDeck {
        /// Share of the rows.
        share: f64,
        /// Height of the deck by the sensor's zero, at least (m).
        least_m: f64,
    },
    /// The thrust far from the deck is not that of the thrust card.
    ThrustOffCard {
        /// Measured thrust over that of the card.
        ratio: f64,
        /// Ratios that a card of the ground effect can express.
        limits: [f64; 2],
        /// What may be the cause, and what to do.
        cause: String,
    },
    /// The height moves, and neither deck nor vehicle has a velocity.
    VelocitiesMissing {
        /// Logs of which this is true.
        logs: usize,
        /// Root mean square of the rate of the height in them (m/s).
        rate_mps: f64,
    },
    /// The velocities have a wrong sign.
    VelocityFlipped {
        /// Logs of which this is true.
        logs: usize,
        /// The channels whose sign explains the motion of the height.
        channels: Vec<&'static str>,
    },
    /// The velocities have another unit than the height.
    VelocityUnit {
        /// Logs of which this is true.
        logs: usize,
        /// Velocity over the rate of the height.
        factor: f64,
    },
    /// The velocities do not explain the motion of the height.
    VelocitiesUnrelated {
        /// Logs of which this is true.
        logs: usize,
    },
}

/// Checks heights, thrusts and velocities of `trials`.
///
/// # Errors
/// Heights or thrusts that no force rig measures in metres and newtons.
pub(crate) fn check(
    trials: &[GroundTrial],
    settings: &GroundEffectSettings,
) -> Result<Vec<DataWarning>> {
    let heights = height::check(trials, settings)?;
    let thrusts = thrust::check(trials, settings.ratio_limits)?;
    Ok(heights
        .into_iter()
        .chain(thrusts)
        .chain(velocity::check(trials))
        .collect())
}

/// The name of the only trial, or the first with how many there are.
fn label(trials: &[GroundTrial]) -> String {
    match trials {
        [] => "no trial".into(),
        [one] => one.name.clone(),
        [first, others @ ..] => format!("{} and {} more logs", first.name, others.len()),
    }
}

/// Values in ascending order, without those that are not finite.
fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value that a share of `sorted` values lies below; none of none.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    (!sorted.is_empty()).then(|| sindy::numerics::quantile(sorted, share))
}

impl fmt::Display for DataWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::HeightsBelowDeck { share, least_m } => write!(
                f,
                "`height_m` is below 0 in {:.1} % of the rows, {least_m:.3} m at least: the rotors cannot be below the deck. Is its zero \
                 another one? Then {}",
                100.0 * share,
                map_line("height_m", "", &format!(" + {:.2}", -least_m))
            ),
            Self::ThrustOffCard {
                ratio,
                limits: [low, high],
                cause,
            } => write!(
                f,
                "far from the deck the measured thrust is {ratio:.3} times that of the thrust card, expected {low:.2} to {high:.2}. {cause}"
            ),
            Self::VelocitiesMissing { logs, rate_mps } => write!(
                f,
                "in {logs} of the logs the height moves (by {rate_mps:.2} m/s, root mean square), and `deck_velocity_mps` and \
                 `vehicle_velocity_mps` are missing or zero: the effect of the deck's velocity is not identified, and its force errs the \
                 lag and the law of height beyond their intervals. Log the rate of the deck's height as \
                 `deck_velocity_mps`, positive upwards, or that of the vehicle's if it is the vehicle that moves"
            ),
            Self::VelocityFlipped { logs, channels } => {
                let lines: Vec<String> = channels.iter().map(|c| map_line(c, "-", "")).collect();
                write!(
                    f,
                    "in {logs} of the logs the rate of the height is that of `vehicle_velocity_mps` - `deck_velocity_mps` only with the other sign of \
                     `{}` (velocities are positive upwards): {}",
                    channels.join("` and `"),
                    lines.join("; ")
                )
            }
            Self::VelocityUnit { logs, factor } => write!(
                f,
                "in {logs} of the logs `vehicle_velocity_mps` - `deck_velocity_mps` is {factor:.3} times the rate of the height: one of them is not \
                 in metres and seconds. If it is the velocity of the deck, {}",
                map_line("deck_velocity_mps", &format!("{:.3e} * ", 1.0 / factor), "")
            ),
            Self::VelocitiesUnrelated { logs } => write!(
                f,
                "in {logs} of the logs the height moves, but not by `vehicle_velocity_mps` - `deck_velocity_mps`: the effect of the deck's velocity \
                 and the lag may be wrong. Check the map of the velocities, and that all stamps are of one clock"
            ),
        }
    }
}

#[cfg(test)]
mod tests;
