//! The slow part of a measured heave (tide, drift of the sensor), which is no wave.

use super::character::HEAVE;
use super::series::MotionSeries;

/// Longest period that counts as waves by default, s. The filter halves the power there. A swell of 15 s loses 0.4 % of its
/// amplitude, one of 20 s 4 %; of motion of 300 s, 1.4 % stays. Half of it takes a quarter of a swell of 15 s.
pub const LONGEST_PERIOD_S: f64 = 60.0;
/// Share of the slow part's range below which the rest is its rounding errors: a million times those of double precision.
const ROUNDING_SHARE: f64 = 1e-9;
/// Blocks per longest period: the slow part is averaged block by block. An eighth of the kernel's standard deviation.
const BLOCKS: f64 = 64.0;

impl MotionSeries {
    /// The series without heave of longer periods than the given one, and the range of that slow part from its lowest to its
    /// highest, m. The slow part is a straight line and the mean of the rest, weighted by a Gaussian that halves the power at
    /// that period; without the line, a steady drift would remain near the ends. A rest of rounding errors becomes 0. The whole
    /// series, and no range, where the series is not longer than the period.
    #[must_use]
    pub fn without_slow_heave(&self, longest_period_s: f64) -> (Self, Option<f64>) {
        if !(longest_period_s < self.duration_s()) {
            return (self.clone(), None);
        }
        let (times_s, heave) = (self.times_s(), self.coordinate(HEAVE));
        let [level, slope] = line(times_s, &heave);
        let rest: Vec<f64> = times_s
            .iter()
            .zip(&heave)
            .map(|(t, z)| z - level - slope * t)
            .collect();
        let slow = self
            .of_blocks(&rest, longest_period_s / BLOCKS)
            .averaged(1.0 / longest_period_s)
            .spline();
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut values = self.values().to_vec();
        for (row, t) in times_s.iter().enumerate() {
            let slow_m = level + slope * t + slow.at(*t).value[HEAVE];
            lowest = slow_m.min(lowest);
            highest = slow_m.max(highest);
            values[row][HEAVE] -= slow_m;
        }
        let range_m = highest - lowest;
        let most_m = values.iter().fold(0.0, |m: f64, v| m.max(v[HEAVE].abs()));
        if most_m < ROUNDING_SHARE * range_m {
            values.iter_mut().for_each(|value| value[HEAVE] = 0.0);
        }
        (self.with_values(values), Some(range_m))
    }

    /// The means of a heave in blocks of the given length, at the mean times of their rows.
    fn of_blocks(&self, heave: &[f64], block_s: f64) -> Self {
        let (mut times_s, mut values) = (Vec::new(), Vec::new());
        let mut from = 0;
        while from < heave.len() {
            let end_s = ((self.times_s()[from] / block_s).floor() + 1.0) * block_s;
            let to = self.times_s().partition_point(|t| *t < end_s).max(from + 1);
            let rows = (to - from) as f64;
            times_s.push(self.times_s()[from..to].iter().sum::<f64>() / rows);
            let mean_m = heave[from..to].iter().sum::<f64>() / rows;
            values.push([0.0, 0.0, mean_m, 0.0, 0.0]);
            from = to;
        }
        Self::of(times_s, values)
    }
}

/// Level at the time 0 and slope of the line with the least squares.
fn line(times_s: &[f64], values: &[f64]) -> [f64; 2] {
    let rows = times_s.len() as f64;
    let (mean_t, mean) = (
        times_s.iter().sum::<f64>() / rows,
        values.iter().sum::<f64>() / rows,
    );
    let (mut of_times, mut of_both) = (0.0, 0.0);
    for (t, value) in times_s.iter().zip(values) {
        of_times += (t - mean_t) * (t - mean_t);
        of_both += (t - mean_t) * (value - mean);
    }
    let slope = of_both / of_times;
    [mean - slope * mean_t, slope]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A swell of 0.5 m amplitude and 8 s at 4 Hz for an hour, on a slow motion.
    fn swell(slow: impl Fn(f64) -> f64) -> MotionSeries {
        let times_s: Vec<f64> = (0..14_400).map(|i| 0.25 * f64::from(i)).collect();
        let heave = times_s
            .iter()
            .map(|t| 0.5 * (TAU * t / 8.0).sin() + slow(*t));
        let values = heave.map(|z| [0.1, 0.0, z, 0.0, 0.0]).collect();
        MotionSeries::of(times_s, values)
    }

    #[test]
    fn analytic_tide_and_drift_leave_the_swell() {
        // A drift of 1 mm/s over an hour, and half a tide of ±1.5 m and 2 h.
        let drift = |t: f64| 0.001 * t;
        let tide = |t: f64| 1.5 * (TAU * t / 7200.0).cos();
        for (slow, range_m) in [(&drift as &dyn Fn(f64) -> f64, 3.6), (&tide, 3.0)] {
            let (waves, left_out_m) = swell(slow).without_slow_heave(LONGEST_PERIOD_S);
            // 4 standard deviations of a sine. The ends of an hour, where the mean has one side, are less than a percent.
            let height_m = waves.significant_height_m();
            assert!((height_m / 2_f64.sqrt() - 1.0).abs() < 0.005, "{height_m}");
            // At the ends a part of the swell, 0.13 of 0.5 m, is taken for slow.
            assert!(
                (left_out_m.unwrap() - range_m).abs() < 0.15,
                "{left_out_m:?}"
            );
            assert!((waves.mean_period_s().unwrap() - 8.0).abs() < 0.02);
            // Other coordinates stay as they are.
            assert!(waves.values().iter().all(|v| v[0] == 0.1));
        }
    }

    #[test]
    fn analytic_half_of_the_power_is_at_the_longest_period() {
        let slow = |t: f64| 2.0 * (TAU * t / 60.0).sin();
        let (waves, _) = swell(slow).without_slow_heave(60.0);
        let difference = waves.values()[4800..9600]
            .iter()
            .zip(&swell(|_| 0.0).values()[4800..9600])
            .map(|(a, b)| (a[HEAVE] - b[HEAVE]).abs())
            .fold(0.0, f64::max);
        // 1 − √½ of 2 m; blocks of a 64th of the period lose (π/64)²/6 = 4e-4 of the mean.
        assert!(
            (difference / 2.0 - (1.0 - 0.5_f64.sqrt())).abs() < 2e-3,
            "{difference}"
        );
    }

    #[test]
    fn regress_a_steady_drift_leaves_neither_waves_nor_noise_nor_faults() {
        let times_s: Vec<f64> = (0..2000).map(|i| 0.1 * f64::from(i)).collect();
        let values = times_s.iter().map(|t| [0.0, 0.0, 0.02 * t, 0.0, 0.0]);
        let drift = MotionSeries::of(times_s.clone(), values.collect());
        let (waves, range_m) = drift.without_slow_heave(LONGEST_PERIOD_S);
        // Rounding of 4 m.
        assert!((range_m.unwrap() - 0.02 * times_s[1999]).abs() < 1e-9);
        assert!(waves.values().iter().all(|v| v[HEAVE] == 0.0));
        assert_eq!(drift.noise().sd_m, 0.0);
        assert_eq!(drift.cutoff_of_noise_hz(), None);
        assert_eq!(drift.faults(&waves, None), []);
        // Waves of 1 µm on it stay: a millionth of a metre is no rounding of 4 m.
        let mut ripple = drift.values().to_vec();
        for (value, t) in ripple.iter_mut().zip(&times_s) {
            value[HEAVE] += 1e-6 * (TAU * t / 8.0).sin();
        }
        let (waves, _) = drift
            .with_values(ripple)
            .without_slow_heave(LONGEST_PERIOD_S);
        assert!(waves.significant_height_m() > 1e-6);
    }

    #[test]
    fn analytic_short_series_and_no_limit_keep_everything() {
        let series = swell(|t| 0.001 * t);
        for longest_s in [f64::INFINITY, 4000.0] {
            assert_eq!(series.without_slow_heave(longest_s), (series.clone(), None));
        }
    }
}
