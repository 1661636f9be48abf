//! Thrust of a load cell that is slower than its log.

use touchdown_trial::Trial;

use super::plateau::median;
use crate::error::Result;
use crate::held::{bends, once};
use crate::warning::Warning;

/// The trials, with each thrust where it was measured and gaps elsewhere; a warning of the slowest sensor, if the log repeats its
/// values or joins them by lines.
pub(super) fn measured_thrust(trials: &[Trial]) -> Result<(Vec<Trial>, Option<Warning>)> {
    let mut out = trials.to_vec();
    let mut slowest: Option<(f64, Warning)> = None;
    for trial in &mut out {
        let Some(thrust_n) = trial.channel("thrust_n") else {
            continue;
        };
        let (period_s, warning) = if let Some(once) = once(thrust_n) {
            let known = trial.time_s().iter().zip(&once);
            let at = known.filter(|(_, n)| n.is_finite()).map(|(t, _)| *t);
            let period_s = period_s(at);
            trial.insert("thrust_n", once)?;
            (period_s, Warning::ThrustRepeats { period_s })
        } else if let Some(bends) = bends(trial.time_s(), thrust_n) {
            let period_s = period_s(bends.iter().map(|(t, _)| *t));
            *trial = at_bends(trial, &bends)?;
            (period_s, Warning::ThrustJoined { period_s })
        } else {
            continue;
        };
        if slowest.as_ref().is_none_or(|(most, _)| *most < period_s) {
            slowest = Some((period_s, warning));
        }
    }
    Ok((out, slowest.map(|(_, warning)| warning)))
}

/// The median time between two measurements, s.
fn period_s(at: impl Iterator<Item = f64>) -> f64 {
    let at: Vec<f64> = at.collect();
    median(at.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0)
}

/// A trial with a row for each measurement of the thrust, and without the thrusts between. There the throttle is that of the row
/// before, and other channels lie on lines.
fn at_bends(trial: &Trial, bends: &[(f64, f64)]) -> Result<Trial> {
    let time = trial.time_s();
    // Time, place among the rows, and thrust.
    let mut rows: Vec<(f64, f64, f64)> = Vec::with_capacity(time.len() + bends.len());
    let mut next = bends.iter().peekable();
    for (i, &t) in time.iter().enumerate() {
        while let Some(&(at, thrust_n)) = next.next_if(|(at, _)| *at < t) {
            let before = i.saturating_sub(1);
            let share = (at - time[before]) / (t - time[before]);
            rows.push((at, before as f64 + share, thrust_n));
        }
        let measured = next.next_if(|(at, _)| *at <= t);
        rows.push((t, i as f64, measured.map_or(f64::NAN, |(_, n)| *n)));
    }
    let mut out = Trial::new(trial.name(), rows.iter().map(|row| row.0).collect())?
        .with_provenance(trial.provenance().clone());
    for (name, values) in trial.channels() {
        let of = |&(_, place, thrust_n): &(f64, f64, f64)| {
            let (i, share) = (place.floor() as usize, place.fract());
            match name {
                "thrust_n" => thrust_n,
                "throttle" => values[i],
                _ if share == 0.0 => values[i],
                _ => values[i] + share * (values[i + 1] - values[i]),
            }
        };
        out.insert(name, rows.iter().map(of).collect())?;
    }
    Ok(out)
}
