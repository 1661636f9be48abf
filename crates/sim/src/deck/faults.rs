//! Rows of a measured motion that no sea makes: jumps, spikes and a sensor that stands still; and motion that is too fast.

use std::f64::consts::TAU;
use std::fmt;

use super::character::{HEAVE, HIGHEST_PER_MEAN};
use super::series::MotionSeries;
use super::spline::natural_cubic;

/// A step between two rows is a jump beyond the noise times this. Of a million rows of white noise, none is.
const NOISES: f64 = 10.0;
/// … and beyond this share of the significant height, because rounded values have steps without noise.
const SHARE_OF_HEIGHT: f64 = 0.1;
/// … and beyond this multiple of 4 standard deviations of the speed, for the greatest of many waves and for wind sea on swell.
const SPEEDS: f64 = 2.0;
/// Greatest acceleration of waves over its root mean square. Of ten thousand waves of a normal sea it is 4.3; steep ones reach 6.
const GREATEST_RATIO: f64 = 7.0;
/// From the ends, over the cutoff: nearer, smoothing has neighbours on one side, and noise makes accelerations. Twice the
/// standard deviation of its kernel.
const ENDS: f64 = 0.5;
/// Mean periods without motion that are a fault. A calm between groups of waves has fewer.
const STILL_PERIODS: f64 = 3.0;
/// Share of the significant height within which heave counts as still. One wave in 200 is lower.
const STILL_SHARE: f64 = 0.05;
/// Rows of one value that are a fault, if they last a mean period.
const EQUAL_ROWS: usize = 10;
/// Times that the mean period is found again without faster motion. A ripple of 2 cm at 4 Hz on waves of half a metre needs two.
const PASSES: usize = 3;
/// Faults that are named by their places; the others are counted.
const NAMED: usize = 3;

/// A fault of a measured heave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeriesFault {
    /// The heave steps, and stays there.
    Jump {
        /// The first row after the step, from 1.
        row: usize,
        /// Its time, s.
        time_s: f64,
        /// The step, m.
        step_m: f64,
    },
    /// A row that is far from both its neighbours.
    Spike {
        /// The row, from 1.
        row: usize,
        /// Its time, s.
        time_s: f64,
        /// The step to it, m.
        step_m: f64,
    },
    /// An acceleration that is far from all others, as in a burst of errors over several rows.
    Burst {
        /// The row, from 1.
        row: usize,
        /// Its time, s.
        time_s: f64,
        /// The acceleration over its root mean square.
        ratio: f64,
    },
    /// The heave does not move, as that of a sensor that hangs.
    Still {
        /// First row, from 1.
        row: usize,
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
    },
}

impl fmt::Display for SeriesFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Jump {
                row,
                time_s,
                step_m,
            } => write!(f, "jump of {step_m:.2} m at {time_s:.2} s (row {row})"),
            Self::Spike {
                row,
                time_s,
                step_m,
            } => write!(f, "spike of {step_m:.2} m at {time_s:.2} s (row {row})"),
            Self::Burst { row, time_s, ratio } => write!(
                f,
                "an acceleration of {ratio:.0} times its root mean square at {time_s:.2} s (row {row})"
            ),
            Self::Still { row, from_s, to_s } => {
                write!(
                    f,
                    "no motion from {from_s:.1} to {to_s:.1} s (from row {row})"
                )
            }
        }
    }
}

/// The faults in a line: the first by their places, the number of the others.
#[must_use]
pub fn listed(faults: &[SeriesFault]) -> String {
    let mut words: Vec<String> = faults.iter().take(NAMED).map(ToString::to_string).collect();
    if faults.len() > NAMED {
        words.push(format!("{} more", faults.len() - NAMED));
    }
    words.join(", ")
}

/// Motion that is faster than waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastMotion {
    /// Highest frequency of waves, Hz: five over the mean period.
    pub above_hz: f64,
    /// Greatest acceleration without it, m/s².
    pub peak_without_mps2: f64,
}

impl MotionSeries {
    /// Steps that are larger than noise and waves make, and stretches without motion. The significant height and the mean
    /// period are those of `waves`: this series without its slow part, smoothed at a cutoff if there is one.
    #[must_use]
    pub fn faults(&self, waves: &Self, cutoff_hz: Option<f64>) -> Vec<SeriesFault> {
        let Some(period_s) = waves.period_of_waves_s() else {
            return Vec::new();
        };
        let height_m = waves.significant_height_m();
        let mut faults = self.steps(height_m, period_s);
        if faults.is_empty() {
            faults.extend(waves.burst(cutoff_hz.map_or(0.0, |hz| ENDS / hz)));
        }
        let raw = self.coordinate(HEAVE);
        let mut still = self.still(&raw, 0.0, period_s, EQUAL_ROWS);
        let smooth = self.smoothed(HIGHEST_PER_MEAN / period_s).coordinate(HEAVE);
        let within_m = STILL_SHARE * height_m;
        for [from, to] in self.still(&smooth, within_m, STILL_PERIODS * period_s, 1) {
            if still.iter().all(|[a, b]| *b < from || *a > to) {
                still.push([from, to]);
            }
        }
        still.sort_unstable();
        faults.extend(still.into_iter().map(|[from, to]| SeriesFault::Still {
            row: from + 1,
            from_s: self.times_s()[from],
            to_s: self.times_s()[to],
        }));
        faults
    }

    /// Jumps and spikes, the largest first.
    fn steps(&self, height_m: f64, period_s: f64) -> Vec<SeriesFault> {
        let (times_s, heave) = (self.times_s(), self.coordinate(HEAVE));
        let noise_m = NOISES * self.noise().greatest_sd_m;
        let speed_mps = TAU * height_m / period_s;
        let step = |row: usize| {
            let step_m = heave[row] - heave[row - 1];
            let by_waves_m = SPEEDS * speed_mps * (times_s[row] - times_s[row - 1]);
            let most_m = noise_m + by_waves_m.max(SHARE_OF_HEIGHT * height_m);
            (step_m.abs() > most_m).then_some(step_m)
        };
        let mut found = Vec::new();
        let mut row = 1;
        while row < heave.len() {
            if let Some(step_m) = step(row) {
                let (place, time_s) = (row + 1, times_s[row]);
                let back = (row + 1 < heave.len()).then(|| step(row + 1)).flatten();
                let spike = back.is_some_and(|back_m| back_m * step_m < 0.0);
                // The step back is part of the spike.
                row += usize::from(spike);
                found.push(if spike {
                    SeriesFault::Spike {
                        row: place,
                        time_s,
                        step_m,
                    }
                } else {
                    SeriesFault::Jump {
                        row: place,
                        time_s,
                        step_m,
                    }
                });
            }
            row += 1;
        }
        let size_m = |fault: &SeriesFault| match fault {
            SeriesFault::Jump { step_m, .. } | SeriesFault::Spike { step_m, .. } => step_m.abs(),
            SeriesFault::Burst { .. } | SeriesFault::Still { .. } => 0.0,
        };
        found.sort_by(|a, b| size_m(b).total_cmp(&size_m(a)));
        found
    }

    /// The greatest acceleration farther than the given time from the ends, if no waves have it.
    fn burst(&self, ends_s: f64) -> Option<SeriesFault> {
        let second = natural_cubic(self.times_s(), &self.coordinate(HEAVE));
        let square = second.iter().map(|a| a * a).sum::<f64>() / second.len() as f64;
        let inner = ends_s..=self.duration_s() - ends_s;
        let rows = second.iter().enumerate();
        let rows = rows.filter(|(row, _)| inner.contains(&self.times_s()[*row]));
        let greatest = |a: &(usize, &f64), b: &(usize, &f64)| a.1.abs().total_cmp(&b.1.abs());
        let (row, acceleration) = rows.max_by(greatest)?;
        let ratio = acceleration.abs() / square.sqrt();
        (ratio > GREATEST_RATIO).then(|| SeriesFault::Burst {
            row: row + 1,
            time_s: self.times_s()[row],
            ratio,
        })
    }

    /// First and last rows of the stretches of a heave that are within a band for a time and a number of rows.
    fn still(
        &self,
        heave: &[f64],
        within_m: f64,
        least_s: f64,
        least_rows: usize,
    ) -> Vec<[usize; 2]> {
        let times_s = self.times_s();
        let mut found = Vec::new();
        let mut from = 0;
        while from < heave.len() {
            let (mut lowest, mut highest, mut to) = (heave[from], heave[from], from);
            while to + 1 < heave.len() {
                let (low, high) = (lowest.min(heave[to + 1]), highest.max(heave[to + 1]));
                if high - low > within_m {
                    break;
                }
                (lowest, highest, to) = (low, high, to + 1);
            }
            if times_s[to] - times_s[from] >= least_s && to - from + 1 >= least_rows {
                found.push([from, to]);
                from = to;
            }
            from += 1;
        }
        found
    }

    /// The mean period of the waves, s. Faster motion crosses the mean more often, so it is left out, and the period found again.
    fn period_of_waves_s(&self) -> Option<f64> {
        let mut period_s = self.mean_period_s()?;
        for _ in 0..PASSES {
            period_s = self.smoothed(HIGHEST_PER_MEAN / period_s).mean_period_s()?;
        }
        Some(period_s)
    }

    /// What motion that is faster than waves adds to the greatest acceleration: the frequency where it begins, and the
    /// greatest acceleration without it. Absent with fewer than two waves.
    #[must_use]
    pub fn fast_motion(&self) -> Option<FastMotion> {
        let above_hz = HIGHEST_PER_MEAN / self.period_of_waves_s()?;
        Some(FastMotion {
            above_hz,
            peak_without_mps2: self.smoothed(above_hz).peak_acceleration_mps2(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Stream};

    /// Waves of 5 and 7 s with noise, 10 minutes at 50 Hz, changed row by row.
    fn waves(change: impl Fn(usize, f64) -> f64) -> MotionSeries {
        let mut random = Stream::new(3, 0, Purpose::Deck);
        let times_s: Vec<f64> = (0..30_000).map(|i| 0.02 * f64::from(i)).collect();
        let heave = times_s.iter().enumerate().map(|(row, t)| {
            let sea = 0.12 * (TAU * t / 5.0).sin() + 0.12 * (TAU * t / 7.0).sin();
            change(row, sea) + 0.01 * (random.uniform() - 0.5)
        });
        let values = heave.map(|z| [0.0, 0.0, z, 0.0, 0.0]).collect();
        MotionSeries::of(times_s, values)
    }

    fn faults(series: &MotionSeries) -> Vec<SeriesFault> {
        let cutoff_hz = series.cutoff_of_noise_hz().unwrap();
        series.faults(&series.smoothed(cutoff_hz), Some(cutoff_hz))
    }

    #[test]
    fn prop_clean_waves_have_no_fault() {
        assert_eq!(faults(&waves(|_, sea| sea)), []);
    }

    #[test]
    fn prop_jumps_and_spikes_are_named_with_their_rows() {
        let jump = waves(|row, sea| sea + if row >= 15_000 { 1.0 } else { 0.0 });
        let found = faults(&jump);
        let text = listed(&found);
        assert!(
            matches!(found[..], [SeriesFault::Jump { row: 15_001, step_m, .. }] if (step_m - 1.0).abs() < 0.03),
            "{text}"
        );
        assert!(text.contains("at 300.00 s (row 15001)"), "{text}");
        let spikes = waves(|row, sea| sea + if row % 5000 == 2500 { -2.0 } else { 0.0 });
        let found = faults(&spikes);
        assert_eq!(found.len(), 6, "{found:?}");
        assert!(
            found
                .iter()
                .all(|fault| matches!(fault, SeriesFault::Spike { row, .. } if row % 5000 == 2501))
        );
        assert!(listed(&found).ends_with(", 3 more"));
    }

    #[test]
    fn prop_a_burst_of_errors_is_named() {
        // Half a second that leaves the sea smoothly by 15 cm: no step is larger than 3 cm.
        let burst = waves(|row, sea| {
            let share = (row as f64 - 15_000.0) / 25.0;
            let inside = (0.0..1.0).contains(&share);
            sea + if inside {
                0.15 * (TAU / 2.0 * share).sin().powi(2)
            } else {
                0.0
            }
        });
        let found = faults(&burst);
        assert!(
            matches!(found[..], [SeriesFault::Burst { time_s, .. }] if (time_s - 300.25).abs() < 0.3),
            "{}",
            listed(&found)
        );
    }

    #[test]
    fn prop_still_stretches_are_named_with_and_without_noise() {
        let frozen = waves(|row, sea| {
            if (10_000..13_000).contains(&row) {
                0.1
            } else {
                sea
            }
        });
        let mut equal = waves(|_, sea| sea).values().to_vec();
        equal[10_000..13_000].fill([0.0, 0.0, 0.1, 0.0, 0.0]);
        let equal = MotionSeries::of(frozen.times_s().to_vec(), equal);
        for series in [frozen, equal] {
            let found = faults(&series);
            let still = |fault: &&SeriesFault| {
                // Smoothing takes half a second from the ends.
                matches!(fault, SeriesFault::Still { from_s, to_s, .. } if (from_s - 200.0).abs() < 1.0 && (to_s - 260.0).abs() < 1.0)
            };
            assert_eq!(found.iter().filter(still).count(), 1, "{}", listed(&found));
        }
    }

    #[test]
    fn analytic_fast_motion_is_what_waves_do_not_have() {
        // 2 cm at 4 Hz: 12.6 m/s², where the waves have less than 0.29.
        let slow = |row: usize, sea: f64| sea + 0.02 * (TAU * 4.0 * 0.02 * row as f64).sin();
        let found = waves(slow).smoothed(8.0).fast_motion().unwrap();
        // Five times the mean frequency of both waves, which is between theirs.
        assert!(
            found.above_hz > 5.0 / 7.0 && found.above_hz < 5.0 / 5.0,
            "{found:?}"
        );
        // The waves have 0.29 m/s². At the ends, where the mean has one side, smoothing doubles that.
        assert!(found.peak_without_mps2 < 0.6, "{found:?}");
        assert!(waves(slow).smoothed(8.0).peak_acceleration_mps2() > 8.0);
    }
}
