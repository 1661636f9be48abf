//! Thrust of a load cell that is slower than its log.

use touchdown_trial::Trial;

use super::plateau::median;
use crate::error::Result;
use crate::held::once;

/// The trials, with each thrust where it was measured and gaps elsewhere; the median time between measurements (s) of the slowest
/// sensor, if any repeats its values.
pub(super) fn measured_thrust(trials: &[Trial]) -> Result<(Vec<Trial>, Option<f64>)> {
    let mut out = trials.to_vec();
    let mut slowest: Option<f64> = None;
    for trial in &mut out {
        let Some(once) = trial.channel("thrust_n").and_then(once) else {
            continue;
        };
        let known = |i: &usize| once[*i].is_finite();
        let at: Vec<f64> = (0..once.len())
            .filter(known)
            .map(|i| trial.time_s()[i])
            .collect();
        let period_s = median(at.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
        slowest = Some(slowest.unwrap_or(0.0).max(period_s));
        trial.insert("thrust_n", once)?;
    }
    Ok((out, slowest))
}
