//! Sensors that are slower than their log or their link: these repeat the last value until there is a new one, or join the values
//! by lines.

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

/// Least share of the rows that lie on such lines: five rows for a measurement and more, where measurements fall between rows.
const LEAST_ON_LINES: f64 = 0.55;
/// Least and greatest time between two bends over the median: a sensor has a period.
const PERIOD_SHARES: [f64; 2] = [0.5, 2.0];

/// The times and values of the bends, if the values between lie on the lines that join them: those of a slow sensor. A bend may lie
/// between two rows, where their lines cross.
pub(crate) fn bends(time_s: &[f64], values: &[f64]) -> Option<Vec<(f64, f64)>> {
    let known: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    let greatest = known
        .iter()
        .fold(0.0_f64, |most, &i| most.max(values[i].abs()));
    let least = ALIKE * greatest;
    // The value at a time of the line through two rows.
    let line = |[a, b]: [usize; 2], t: f64| {
        let share = (t - time_s[a]) / (time_s[b] - time_s[a]);
        values[a] + share * (values[b] - values[a])
    };
    let (mut on_lines, mut bent) = (0, Vec::new());
    for (k, w) in known.windows(3).enumerate() {
        if (line([w[0], w[2]], time_s[w[1]]) - values[w[1]]).abs() > least {
            bent.push(k + 1);
        } else if (values[w[1]] - values[w[0]]).abs() > least {
            on_lines += 1;
        }
    }
    if (on_lines as f64) < LEAST_ON_LINES * known.len() as f64 {
        return None;
    }
    // Two rows, one behind the other, beside a bend between them.
    let mut found = Vec::new();
    for group in bent.chunk_by(|a, b| b - a == 1) {
        match *group {
            // Beside the end, the bend may lie between both.
            [k] if k > 1 && k + 2 < known.len() => {
                found.push((time_s[known[k]], values[known[k]]));
            }
            [_] => {}
            [k, next] if next + 1 < known.len() => {
                let (a, b) = (known[k], known[next]);
                let lines = [[known[k - 1], a], [b, known[next + 1]]];
                let [at_a, at_b] =
                    [a, b].map(|i| line(lines[0], time_s[i]) - line(lines[1], time_s[i]));
                let share = (at_a / (at_a - at_b)).clamp(0.0, 1.0);
                let t = time_s[a] + share * (time_s[b] - time_s[a]);
                found.push((t, line(lines[0], t)));
            }
            _ => return None,
        }
    }
    is_regular(&found).then_some(found)
}

/// Whether bends are those of a sensor, which has a period.
fn is_regular(bends: &[(f64, f64)]) -> bool {
    let mut periods: Vec<f64> = bends.windows(2).map(|w| w[1].0 - w[0].0).collect();
    if periods.len() < FEWEST_CHANGES {
        return false;
    }
    periods.sort_by(f64::total_cmp);
    let median = periods[periods.len() / 2];
    let [least, most] = PERIOD_SHARES.map(|share| share * median);
    let irregular = periods
        .iter()
        .filter(|&&p| !(least..=most).contains(&p))
        .count();
    irregular as f64 <= SHORTEST_SHARE * periods.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The k-th measurement.
    fn measured(k: f64) -> f64 {
        5.0 + (0.9 * k).sin() + 0.3 * (2.3 * k * k).sin()
    }

    /// A thrust of every `period_s` from `start_s` on, joined by lines, in rows of 0.01 s.
    fn joined(period_s: f64, start_s: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let values = time.iter().map(|t| {
            let k = (t - start_s) / period_s;
            measured(k.floor())
                + (k - k.floor()) * (measured(k.floor() + 1.0) - measured(k.floor()))
        });
        (time.clone(), values.collect())
    }

    #[test]
    fn analytic_values_that_are_joined_by_lines_count_at_their_bends() {
        for (period_s, start_s) in [(0.1, 0.0), (0.1, 0.003), (0.1, 0.008), (0.083, 0.0)] {
            let (time, values) = joined(period_s, start_s);
            let found = bends(&time, &values).unwrap();
            let expected = 10.0 / period_s;
            // Not the ends, which are no bends.
            assert!(
                (found.len() as f64 - expected).abs() <= 2.0,
                "{}",
                found.len()
            );
            for (t, value) in found {
                let k = ((t - start_s) / period_s).round();
                // Lines that cross at a small angle, through values with roundings of 1e-15: not the time, but the value is as good.
                assert!((t - start_s - k * period_s).abs() < 1e-9, "{t}");
                assert!((value - measured(k)).abs() < 1e-9, "{t}");
            }
        }
    }

    #[test]
    fn analytic_what_only_looks_like_lines_stays() {
        let time: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        // Measured in every row, repeated in four, at rest for the most part, and a few long ramps.
        let noise = |i: usize| (((i * i) as f64 * 0.37).sin() * 1e4).fract();
        let every: Vec<f64> = (0..1000).map(noise).collect();
        let repeated: Vec<f64> = (0..1000).map(|i| noise(i - i % 4)).collect();
        let rest: Vec<f64> = (0..1000).map(|i| noise(i - i % 100)).collect();
        let ramps: Vec<f64> = (0..1000_u32)
            .map(|i| f64::from(i % 200).min(f64::from(200 - i % 200)))
            .collect();
        for values in [every, repeated, rest, ramps] {
            assert!(bends(&time, &values).is_none());
        }
        // Bends at any time are those of a throttle, not of a sensor.
        let mut corner = 0;
        let steep: Vec<f64> = (0..1000)
            .map(|i| {
                corner += usize::from(i % 7 == 0 || i % 31 == 0 || i % 5 == 0);
                i as f64 * noise(corner)
            })
            .collect();
        assert!(bends(&time, &steep).is_none());
    }

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
