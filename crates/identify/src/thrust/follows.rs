//! Whether thrust follows the throttle.

use touchdown_trial::Trial;

use super::choice::FINEST;
use super::{LEAST_MOTION, throttle};
use crate::error::{Error, Result};
use crate::fitted::range;

/// Checks that the thrust of `trials` changes where their throttle does.
///
/// # Errors
/// A thrust that is the same in all rows.
pub(super) fn check_changes(trials: &[Trial]) -> Result<()> {
    let thrust = trials.iter().filter_map(|t| t.channel("thrust_n"));
    let Some([least_n, most_n]) = range(thrust.flatten().copied()) else {
        return Ok(());
    };
    let Some([low, high]) = throttles(trials)? else {
        return Ok(());
    };
    if most_n - least_n > FINEST * most_n.abs() || high - low <= LEAST_MOTION {
        return Ok(());
    }
    Err(Error::data(
        trials.first().map_or("no trial", Trial::name),
        "a thrust that follows the throttle",
        format!(
            "{least_n} to {most_n} N in all rows, while the throttle goes from {low} to {high}: thrust does not follow the \
             throttle. Check the map: is `thrust_n` the column of the load cell?"
        ),
    ))
}

/// Lowest and highest throttle of all trials.
fn throttles(trials: &[Trial]) -> Result<Option<[f64; 2]>> {
    let all: Vec<Vec<f64>> = trials.iter().map(throttle).collect::<Result<_>>()?;
    Ok(range(all.into_iter().flatten()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_constant_thrust_is_refused() {
        let rows = 200;
        let log = |thrust_n: f64| {
            let trial = Trial::new("t", (0..rows).map(f64::from).collect()).unwrap();
            let throttle = (0..rows).map(|i| f64::from(i % 10) / 10.0).collect();
            let trial = trial.with_channel("throttle", throttle).unwrap();
            let mut thrust = vec![5.0; 200];
            thrust[7] = thrust_n;
            trial.with_channel("thrust_n", thrust).unwrap()
        };
        let text = check_changes(&[log(5.0)]).unwrap_err().to_string();
        assert!(
            text.contains("thrust does not follow the throttle"),
            "{text}"
        );
        assert!(text.contains("from 0 to 0.9"), "{text}");
        assert!(check_changes(&[log(5.1)]).is_ok());
        // Steady points in files of their own: the thrust of each is constant, that of all is not.
        let each = [5.0, 6.0].map(|thrust_n| {
            let trial = Trial::new("t", vec![0.0, 1.0]).unwrap();
            let trial = trial
                .with_channel("throttle", vec![0.1 * thrust_n; 2])
                .unwrap();
            trial.with_channel("thrust_n", vec![thrust_n; 2]).unwrap()
        });
        assert!(check_changes(&each).is_ok());
        assert!(
            check_changes(&each[..1]).is_ok(),
            "a throttle that stands still has an error of its own"
        );
    }
}
