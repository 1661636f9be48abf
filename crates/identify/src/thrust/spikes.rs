//! Single rows of a load cell that no rotor explains: bytes that were misread, dropouts to zero.

use touchdown_trial::Trial;

use super::is_flight;
use super::plateau::{median, tenths};
use crate::error::Result;
use crate::warning::Warning;

/// Least difference of a row from both neighbours, over the spread of the thrust. A rotor with a lag does not change its thrust by half of the
/// spread and back within three rows, unless the throttle changes in every row.
const LEAST_SHARE: f64 = 0.5;
/// The same over the robust spread of such differences. Other values were not measured.
const LEAST_SPREADS: f64 = 12.0;
/// A normal standard deviation over the median of its amounts.
const OF_MEDIAN: f64 = 1.4826;

/// The trials without such rows, and a warning that says how many there were.
pub(super) fn without_spikes(trials: &[Trial]) -> Result<(Vec<Trial>, Option<Warning>)> {
    let mut out = trials.to_vec();
    let mut found: Option<(usize, f64)> = None;
    for trial in &mut out {
        let of_flight = is_flight(trial);
        let Some(thrust_n) = trial.channel("thrust_n").filter(|_| !of_flight) else {
            continue;
        };
        let rows = spikes(thrust_n);
        let Some(&first) = rows.first() else {
            continue;
        };
        let mut left = thrust_n.to_vec();
        rows.iter().for_each(|&row| left[row] = f64::NAN);
        let at_s = trial.time_s()[first];
        found = Some(found.map_or((rows.len(), at_s), |(count, at_s)| {
            (count + rows.len(), at_s)
        }));
        trial.insert("thrust_n", left)?;
    }
    Ok((
        out,
        found.map(|(count, at_s)| Warning::ThrustSpikes { count, at_s }),
    ))
}

/// The rows that differ from both neighbours in the same way by too much.
fn spikes(thrust_n: &[f64]) -> Vec<usize> {
    let known: Vec<usize> = (0..thrust_n.len())
        .filter(|&i| thrust_n[i].is_finite())
        .collect();
    let Some([low_n, high_n]) = tenths(thrust_n.iter().copied()) else {
        return Vec::new();
    };
    // The lesser difference of a row that lies beyond both neighbours, otherwise 0.
    let beyond = |w: &[usize]| {
        let [before, after] = [w[0], w[2]].map(|i| thrust_n[w[1]] - thrust_n[i]);
        if before * after > 0.0 {
            before.abs().min(after.abs())
        } else {
            0.0
        }
    };
    let all: Vec<f64> = known.windows(3).map(beyond).collect();
    let amounts = all.iter().copied().filter(|d| *d > 0.0);
    let spread_n = OF_MEDIAN * median(amounts).unwrap_or(0.0);
    let least_n = (LEAST_SHARE * (high_n - low_n)).max(LEAST_SPREADS * spread_n);
    let rows = known.windows(3).zip(all);
    rows.filter(|(_, beyond)| *beyond > least_n)
        .map(|(w, _)| w[1])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thrust of 2 to 12 N in steps behind a lag, at 100 Hz, with noise of up to 0.01 N.
    fn steps(rows: u32, held: u32) -> Vec<f64> {
        let mut x = 5.0;
        let of = |i: u32| {
            let level = 2.0 + f64::from((7 * (i / held)) % 11);
            x += (level - x) * (1.0 - (-0.01_f64 / 0.06).exp());
            x + 0.01 * (2.4 * f64::from(i * i % 1009)).sin()
        };
        (0..rows).map(of).collect()
    }

    #[test]
    fn analytic_single_rows_that_no_rotor_explains_are_spikes() {
        let mut thrust = steps(2000, 100);
        assert_eq!(spikes(&thrust), [0; 0]);
        let wrong = [(3, -50.0), (700, 0.0), (1234, 200.0), (1500, 40.0)];
        for (row, value) in wrong {
            thrust[row] = value;
        }
        thrust[1233] = f64::NAN;
        let at_rest = thrust[700 + 1] < 6.0;
        assert!(!at_rest, "a dropout from a thrust that is far from zero");
        assert_eq!(spikes(&thrust), wrong.map(|(row, _)| row));
    }

    #[test]
    fn prop_a_throttle_as_fast_as_the_rows_makes_no_spike() {
        // Another level in every row and every second row, behind a lag and without one.
        for held in [1, 2, 5] {
            assert_eq!(spikes(&steps(2000, held)), [0; 0], "{held}");
            let at_once: Vec<f64> = (0..500_u32)
                .map(|i| f64::from((7 * (i / held)) % 11))
                .collect();
            assert_eq!(spikes(&at_once), [0; 0], "{held}");
        }
        // A burst of vibration on a quiet log is loud, but small against the thrust.
        let burst = |(i, n): (usize, f64)| {
            n + if i % 400 < 20 {
                [0.3, -0.3][i % 2]
            } else {
                0.0
            }
        };
        let quiet = steps(2000, 100)
            .into_iter()
            .map(|n| (1000.0 * n).round() / 1000.0);
        let thrust: Vec<f64> = quiet.enumerate().map(burst).collect();
        assert_eq!(spikes(&thrust), [0; 0]);
        // Few rows, a constant, and none.
        for few in [vec![], vec![1.0], vec![1.0, 9.0, 1.0], vec![3.0; 50]] {
            assert!(spikes(&few).is_empty(), "{few:?}");
        }
    }

    #[test]
    fn analytic_spikes_of_a_stand_are_left_out_and_counted() {
        let mut thrust = steps(2000, 100);
        (thrust[500], thrust[900]) = (99.0, -40.0);
        let stand = Trial::new("t", (0..2000).map(|i| 0.01 * f64::from(i)).collect()).unwrap();
        let stand = stand.with_channel("thrust_n", thrust.clone()).unwrap();
        let (out, told) = without_spikes(std::slice::from_ref(&stand)).unwrap();
        let left = out[0].channel("thrust_n").unwrap();
        assert!((0..2000).all(|i| left[i].is_nan() == (i == 500 || i == 900)));
        let expected = Warning::ThrustSpikes {
            count: 2,
            at_s: 5.0,
        };
        assert_eq!(told.unwrap().to_string(), expected.to_string());
        let flight = stand.with_channel("specific_force_mps2", thrust).unwrap();
        assert!(without_spikes(&[flight]).unwrap().1.is_none());
    }
}
