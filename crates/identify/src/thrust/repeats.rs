//! Thrust of a load cell that is slower than its log.

use touchdown_trial::Trial;

use super::plateau::median;
use crate::error::Result;
use crate::held::{bends, once};
use crate::warning::Warning;

/// The trials, with each thrust where it was measured and gaps elsewhere; a warning of the slowest sensor, if the log repeats its
/// values or joins them by lines.
pub(super) fn measured_thrust(mut trials: Vec<Trial>) -> Result<(Vec<Trial>, Option<Warning>)> {
    let mut slowest: Option<(f64, Warning)> = None;
    for trial in &mut trials {
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
    Ok((trials, slowest.map(|(_, warning)| warning)))
}

/// The median time between two measurements, s.
fn period_s(at: impl Iterator<Item = f64>) -> f64 {
    let at: Vec<f64> = at.collect();
    median(at.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0)
}

/// A trial with a row for each measurement of the thrust, and without the thrusts between. There the throttle is that of the row
/// before, also of single motors, and other channels lie on lines.
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
                _ if share == 0.0 || name.starts_with("throttle") => values[i],
                _ => values[i] + share * (values[i + 1] - values[i]),
            }
        };
        out.insert(name, rows.iter().map(of).collect())?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_at_a_measurement_between_rows_throttles_are_held() {
        let trial = Trial::new("t", vec![0.0, 1.0, 2.0]).unwrap();
        let trial = trial
            .with_channel("throttle_1", vec![0.2, 0.4, 0.8])
            .unwrap()
            .with_channel("battery_v", vec![16.0, 15.0, 14.0])
            .unwrap()
            .with_channel("thrust_n", vec![1.0, 2.0, 3.0])
            .unwrap();
        let out = at_bends(&trial, &[(0.5, 1.7), (2.0, 3.0)]).unwrap();
        assert_eq!(out.time_s(), [0.0, 0.5, 1.0, 2.0]);
        assert_eq!(out.channel("throttle_1").unwrap(), [0.2, 0.2, 0.4, 0.8]);
        assert_eq!(out.channel("battery_v").unwrap(), [16.0, 15.5, 15.0, 14.0]);
        let thrust_n = out.channel("thrust_n").unwrap();
        assert_eq!([thrust_n[1], thrust_n[3]], [1.7, 3.0]);
        assert!(thrust_n[0].is_nan() && thrust_n[2].is_nan());
    }
}
