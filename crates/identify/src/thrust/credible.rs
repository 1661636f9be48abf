//! Values that no channel of a thrust log has, such as bytes that were misread.

use touchdown_trial::Trial;

use crate::error::{Error, Result};

/// Greatest credible amount of a value, in any unit that logs have: 1e9 mN are the weight of a hundred tonnes, a pulse
/// width in nanoseconds is 2e6, and a voltage in microvolts 1e8.
const MOST: f64 = 1e9;

/// Checks the channels that a fit of thrust reads. The squares of values far beyond are beyond all numbers, and one of
/// them outweighs all others of a log.
///
/// # Errors
/// The first incredible value, with its channel, row and time.
pub(super) fn check(trial: &Trial) -> Result<()> {
    for (name, values) in trial.channels() {
        let is_read = ["thrust_n", "throttle", "battery_v", "rotor_rpm"]
            .iter()
            .any(|read| name.starts_with(read));
        let wrong = |v: &f64| v.abs() > MOST;
        if let (true, Some(row)) = (is_read, values.iter().position(wrong)) {
            return Err(Error::data(
                trial.name(),
                format!("values of `{name}` of at most {MOST:e}"),
                format!(
                    "{:e} in row {row} (from 0) of those in use, at {} s: correct it in the log, or leave its row out by \
                     `keep` in the table [filter] of the map",
                    values[row],
                    trial.time_s()[row]
                ),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_one_incredible_value_is_named_with_its_row_and_time() {
        let log = |channel: &str, value: f64| {
            let trial = Trial::new("t", vec![0.0, 0.5, 1.0, 1.5]).unwrap();
            trial
                .with_channel(channel, vec![1.0, f64::NAN, value, 2.0])
                .unwrap()
        };
        for channel in ["thrust_n", "throttle", "throttle_2", "battery_v"] {
            let text = check(&log(channel, -1e300)).unwrap_err().to_string();
            let start = format!(
                "t: expected values of `{channel}` of at most 1e9, found -1e300 in row 2 (from 0)"
            );
            assert!(text.starts_with(&start), "{text}");
            assert!(text.contains("at 1 s"), "{text}");
            // 1 N in millinewtons, and the pulse width of full throttle in nanoseconds.
            assert!(check(&log(channel, 1e3)).is_ok() && check(&log(channel, 2e6)).is_ok());
        }
        // No fit of thrust reads a channel of the user's own.
        assert!(check(&log("stamp_ns_s", 1.7e18)).is_ok());
    }
}
