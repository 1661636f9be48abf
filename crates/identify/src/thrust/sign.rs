//! The sign of a measured thrust: a sensor that is mounted upside down.

use touchdown_trial::Trial;

use super::plateau::median;
use crate::error::{Error, Result};
use crate::fitted::range;

/// The greatest thrust of a trial (N).
pub(super) fn most_n(trial: &Trial) -> f64 {
    let thrust = trial.channel("thrust_n").unwrap_or_default();
    range(thrust.iter().copied()).map_or(0.0, |[_, most]| most)
}

/// Checks that thrust is above zero where the throttle is in the upper half of its range. Noise alone is above zero
/// somewhere, so its greatest value tells too little.
///
/// # Errors
/// A thrust of gaps only, or with a reversed sign, with what to write into the map.
pub(super) fn check(trial: &Trial, throttle: &[f64]) -> Result<()> {
    let thrust = trial.require("thrust_n")?;
    let expected = |found: String| {
        Err(Error::data(
            trial.name(),
            "values of `thrust_n` above 0",
            found,
        ))
    };
    let reversed = |found: String| {
        expected(format!(
            "{found}: is its sign reversed? Put a minus before the expression of thrust_n in the map"
        ))
    };
    match range(thrust.iter().copied()) {
        None => return expected("gaps only".into()),
        Some([_, most]) if most <= 0.0 => return reversed(format!("{most} N at most")),
        Some(_) => {}
    }
    let Some([low, high]) = range(throttle.iter().copied()) else {
        return Err(Error::data(trial.name(), "values of throttle", "gaps only"));
    };
    let upper = throttle.iter().zip(thrust);
    let upper = upper
        .filter(|(s, _)| **s > 0.5 * (low + high))
        .map(|(_, f)| *f);
    match median(upper) {
        Some(usual) if usual < 0.0 => reversed(format!(
            "{usual} N, the median in the upper half of throttle"
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_noise_above_zero_does_not_hide_a_reversed_sign() {
        let rows = 40;
        let throttle: Vec<f64> = (0..rows).map(|i| f64::from(i) / 40.0).collect();
        let check = |sign: f64| {
            // 0.05 N of noise at rest, and 8 N at full throttle.
            let noise = |s: f64| if s < 0.1 { 0.05 } else { 0.0 };
            let thrust = throttle.iter().map(|s| sign * 8.0 * s * s + noise(*s));
            let trial = Trial::new("t", (0..rows).map(f64::from).collect()).unwrap();
            let trial = trial.with_channel("thrust_n", thrust.collect()).unwrap();
            check(&trial, &throttle)
        };
        assert!(check(1.0).is_ok());
        let text = check(-1.0).unwrap_err().to_string();
        assert!(text.contains("is its sign reversed? Put a minus"), "{text}");
    }
}
