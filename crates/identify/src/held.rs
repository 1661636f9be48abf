//! Sensors that are slower than their log or their link: these repeat the last value until there is a new one.

/// Changes that are looked at at least: fewer say nothing of a sensor's period.
const FEWEST_CHANGES: usize = 20;
/// Share of the intervals between changes that may be shorter than a sensor's period: jitter of two clocks gives a hundredth. Noise
/// about a step of a coarse sensor gives a third of single rows.
const SHORTEST_SHARE: f64 = 0.05;

/// Relative difference of values that are one: repeats may have been turned and turned back.
const ALIKE: f64 = 1e-9;

/// The values where they change, if those between are repeats of a slow sensor: nearly no two that follow one another differ.
pub(crate) fn once(values: &[f64]) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    let changes: Vec<usize> = known
        .windows(2)
        .enumerate()
        .filter(|(_, w)| (values[w[0]] - values[w[1]]).abs() > ALIKE * values[w[0]].abs())
        .map(|(k, _)| k + 1)
        .collect();
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    let single = changes.windows(2).filter(|w| w[1] - w[0] == 1).count();
    if single as f64 > SHORTEST_SHARE * changes.len() as f64 {
        return None;
    }
    let mut out = vec![f64::NAN; values.len()];
    for k in std::iter::once(0).chain(changes) {
        out[known[k]] = values[known[k]];
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of thrust, measured in every `every`-th row and rounded to `digit`.
    fn wave(every: usize, digit: f64) -> Vec<f64> {
        let of = |i: usize| 5.0 + (0.05 * (i - i % every) as f64).sin();
        (0..1000)
            .map(|i| match digit > 0.0 {
                true => (of(i) / digit).round() * digit,
                false => of(i),
            })
            .collect()
    }

    #[test]
    fn analytic_repeats_of_a_slow_sensor_are_gaps() {
        let values = wave(4, 0.0);
        let found = once(&values).unwrap();
        let kept = found.iter().filter(|v| v.is_finite()).count();
        assert_eq!(kept, 250);
        assert!((0..1000).all(|i| found[i].is_finite() == (i % 4 == 0)));
    }

    #[test]
    fn analytic_a_sensor_of_every_row_stays() {
        assert!(once(&wave(1, 0.0)).is_none());
        // Plateaus of a few values alone say nothing.
        assert!(once(&[1.0, 1.0, 2.0, 2.0, 3.0, 3.0]).is_none());
        // A coarse sensor with noise of its last digit.
        let noisy: Vec<f64> = wave(1, 0.1)
            .iter()
            .enumerate()
            .map(|(i, v)| v + 0.1 * f64::from(u8::from(i * i % 7 == 2)))
            .collect();
        assert!(once(&noisy).is_none());
    }
}
