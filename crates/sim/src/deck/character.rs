//! What a measured motion is: length, sampling, sea state, noise, and the peaks of the motion that will be flown.

use std::f64::consts::TAU;
use std::fmt;

use super::series::MotionSeries;
use super::spline::{cubic_rates, natural_cubic};

/// Place of the heave among the coordinates.
pub(crate) const HEAVE: usize = 2;
/// Mean periods in a piece of the spectrum: it resolves a twentieth of the mean frequency. Half of it blurs swell and wind sea
/// into one peak; twice leaves few pieces of short records.
const PIECE_PERIODS: f64 = 20.0;
/// Highest frequency of the spectrum over that of the mean period: seas have less than a thousandth of their variance beyond.
pub(super) const HIGHEST_PER_MEAN: f64 = 5.0;

/// The heave of a measured motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesCharacter {
    /// From the first row to the last, s.
    pub duration_s: f64,
    /// Number of rows.
    pub rows: usize,
    /// Median time between rows, s.
    pub step_s: f64,
    /// 4 standard deviations of the heave, m.
    pub significant_height_m: f64,
    /// Mean time between upward crossings of the mean, s; absent with fewer than two.
    pub mean_period_s: Option<f64>,
    /// Frequency at which the spectrum of the heave is greatest, Hz; absent with fewer than two crossings.
    pub peak_frequency_hz: Option<f64>,
    /// Frequencies below which a quarter and three quarters of the variance of the heave are, Hz; absent with fewer than two
    /// crossings.
    pub middle_half_hz: Option<[f64; 2]>,
    /// Standard deviation of the noise, m: [`MotionSeries::noise`].
    pub noise_sd_m: f64,
    /// Greatest speed of the spline through the rows, at the rows, m/s.
    pub peak_velocity_mps: f64,
    /// Greatest acceleration of the spline through the rows, m/s².
    pub peak_acceleration_mps2: f64,
}

impl fmt::Display for SeriesCharacter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.1} s, {} rows every {:.3} s, significant height {:.3} m, ",
            self.duration_s, self.rows, self.step_s, self.significant_height_m
        )?;
        if let Some(period_s) = self.mean_period_s {
            write!(f, "mean period {period_s:.2} s, ")?;
        }
        if let Some(peak_hz) = self.peak_frequency_hz {
            write!(f, "spectral peak at {peak_hz:.3} Hz, ")?;
        }
        if let Some([low_hz, high_hz]) = self.middle_half_hz {
            write!(
                f,
                "half of the variance from {low_hz:.3} to {high_hz:.3} Hz, "
            )?;
        }
        write!(
            f,
            "noise {:.4} m, peaks {:.2} m/s and {:.2} m/s²",
            self.noise_sd_m, self.peak_velocity_mps, self.peak_acceleration_mps2
        )
    }
}

/// The frequency of the greatest density.
fn peak_hz(spectrum: &[[f64; 2]]) -> Option<f64> {
    let greatest = spectrum.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
    greatest.map(|[frequency_hz, _]| *frequency_hz)
}

/// The frequencies below which a quarter and three quarters of the variance are.
fn middle_half_hz(spectrum: &[[f64; 2]]) -> Option<[f64; 2]> {
    let whole: f64 = spectrum.iter().map(|[_, density]| density).sum();
    let below = |share: f64| {
        let mut sum = 0.0;
        let reached = spectrum.iter().find(|[_, density]| {
            sum += density;
            sum >= share * whole
        });
        reached.map(|[frequency_hz, _]| *frequency_hz)
    };
    Some([below(0.25)?, below(0.75)?])
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

impl MotionSeries {
    /// What the series is.
    #[must_use]
    pub fn character(&self) -> SeriesCharacter {
        let (times_s, heave) = (self.times_s(), self.coordinate(HEAVE));
        let second = natural_cubic(times_s, &heave);
        let rates = cubic_rates(times_s, &heave, &second);
        let period_s = self.mean_period_s();
        let spectrum = period_s.map(|period_s| self.spectrum(period_s));
        SeriesCharacter {
            duration_s: self.duration_s(),
            rows: self.rows(),
            step_s: self.step_s(),
            significant_height_m: self.significant_height_m(),
            mean_period_s: period_s,
            peak_frequency_hz: spectrum.as_deref().and_then(peak_hz),
            middle_half_hz: spectrum.as_deref().and_then(middle_half_hz),
            noise_sd_m: self.noise().sd_m,
            peak_velocity_mps: largest(&rates),
            peak_acceleration_mps2: largest(&second),
        }
    }

    /// Median time between rows, s.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        median(self.times_s().windows(2).map(|t| t[1] - t[0]).collect())
    }

    /// Mean time between upward crossings of the mean, s; absent with fewer than two.
    #[must_use]
    pub fn mean_period_s(&self) -> Option<f64> {
        let (times_s, heave) = (self.times_s(), self.coordinate(HEAVE));
        let crossings: Vec<f64> = times_s
            .windows(2)
            .zip(heave.windows(2))
            .filter(|(_, z)| z[0] < 0.0 && z[1] >= 0.0)
            .map(|(t, z)| t[0] + (t[1] - t[0]) * z[0] / (z[0] - z[1]))
            .collect();
        let (first, last) = crossings.first().zip(crossings.last())?;
        (crossings.len() > 1).then(|| (last - first) / (crossings.len() as f64 - 1.0))
    }

    /// Greatest acceleration of the spline through the rows, m/s².
    #[must_use]
    pub fn peak_acceleration_mps2(&self) -> f64 {
        largest(&natural_cubic(self.times_s(), &self.coordinate(HEAVE)))
    }

    /// Spectrum of the heave: frequency, Hz, and density, m²/Hz, up to five over the mean period and half of the rate of the
    /// rows, from windowed pieces of twenty mean periods that overlap by half (Welch 1967). Its variance sums to that of the heave
    /// as far as the motion is slower than that.
    #[must_use]
    pub fn spectrum(&self, mean_period_s: f64) -> Vec<[f64; 2]> {
        let (times_s, heave) = (self.times_s(), self.coordinate(HEAVE));
        let piece_s = (PIECE_PERIODS * mean_period_s).min(self.duration_s());
        let frequencies = (PIECE_PERIODS * HIGHEST_PER_MEAN) as u32;
        let highest_hz = 0.5 / self.step_s();
        let mut spectrum: Vec<[f64; 2]> = (1..=frequencies)
            .map(|k| [f64::from(k) / piece_s, 0.0])
            .filter(|[frequency_hz, _]| *frequency_hz <= highest_hz)
            .collect();
        let mut pieces = 0.0;
        let mut from_s = 0.0;
        while from_s + piece_s <= self.duration_s() * (1.0 + 1e-9) {
            let first = times_s.partition_point(|t| *t < from_s);
            let last = times_s.partition_point(|t| *t <= from_s + piece_s);
            let rows: Vec<[f64; 2]> = (first.max(1)..last)
                .map(|i| {
                    let share = (times_s[i] - from_s) / piece_s;
                    let window = 0.5 * (1.0 - (TAU * share).cos());
                    [
                        times_s[i],
                        window * heave[i] * (times_s[i] - times_s[i - 1]),
                    ]
                })
                .collect();
            for [frequency_hz, density] in &mut spectrum {
                let (mut cosine, mut sine) = (0.0, 0.0);
                for [t, weighted] in &rows {
                    let (sin, cos) = (TAU * *frequency_hz * t).sin_cos();
                    cosine += weighted * cos;
                    sine += weighted * sin;
                }
                // Two sides; the window passes 3/8 of the power.
                *density += 2.0 * (cosine * cosine + sine * sine) / (0.375 * piece_s);
            }
            pieces += 1.0;
            from_s += 0.5 * piece_s;
        }
        for [_, density] in &mut spectrum {
            *density /= pieces;
        }
        spectrum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Stream};

    /// A swell of 0.5 m amplitude and 8 s at 10 Hz, with noise.
    fn swell(noise_m: f64) -> MotionSeries {
        let mut random = Stream::new(7, 0, Purpose::Deck);
        let times_s: Vec<f64> = (0..4000).map(|i| 0.1 * f64::from(i)).collect();
        let heave = times_s.iter().map(|t| {
            // The sum of twelve uniform numbers has a variance of 1.
            let normal: f64 = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
            0.5 * (TAU * t / 8.0).sin() + noise_m * normal
        });
        let values = heave.map(|z| [0.0, 0.0, z, 0.0, 0.0]).collect();
        MotionSeries::of(times_s, values)
    }

    #[test]
    fn analytic_character_of_a_swell() {
        let found = swell(0.0).character();
        let omega = TAU / 8.0;
        // Fifty whole periods; the spline errs by (ωh)⁴/12 of the amplitude, 3e-6, and at its ends by more.
        assert!((found.significant_height_m - 4.0 * 0.5 / 2_f64.sqrt()).abs() < 1e-3);
        assert!((found.mean_period_s.unwrap() - 8.0).abs() < 1e-3);
        // Frequencies are a 160th of a hertz apart.
        assert!((found.peak_frequency_hz.unwrap() - 0.125).abs() < 1e-6);
        let variance: f64 = swell(0.0)
            .spectrum(8.0)
            .iter()
            .map(|[_, s]| s / 160.0)
            .sum();
        // The half amplitude squared, twice; windows of a sine leak less than a percent.
        assert!((variance / 0.125 - 1.0).abs() < 0.02, "{variance}");
        assert!((found.peak_velocity_mps - 0.5 * omega).abs() < 1e-3);
        assert!((found.peak_acceleration_mps2 - 0.5 * omega * omega).abs() < 2e-3);
        assert_eq!((found.rows, found.step_s), (4000, found.step_s));
        assert!(found.noise_sd_m < 1e-5);
        let text = found.to_string();
        assert!(
            text.contains(
                "significant height 1.414 m, mean period 8.00 s, spectral peak at 0.125 Hz"
            ),
            "{text}"
        );
    }

    #[test]
    fn analytic_a_spectrum_has_no_mirror_images() {
        // The swell once in 2 s, for 20 s: beyond 0.25 Hz its spectrum is repeated backwards, as high as its peak at 0.375 Hz.
        let swell = swell(0.0);
        let [times_s, heave] = [swell.times_s().to_vec(), swell.coordinate(HEAVE)];
        let rows = (0..200).step_by(20);
        let values = rows.clone().map(|i| [0.0, 0.0, heave[i], 0.0, 0.0]);
        let seldom = MotionSeries::of(rows.clone().map(|i| times_s[i]).collect(), values.collect());
        let spectrum = seldom.spectrum(8.0);
        assert!(!spectrum.is_empty() && spectrum.iter().all(|[hz, _]| *hz <= 0.25));
        // Frequencies are an eighteenth of a hertz apart.
        assert!((peak_hz(&spectrum).unwrap() - 0.125).abs() < 1.0 / 18.0);
    }

    #[test]
    fn analytic_noise_makes_accelerations_and_the_cutoff_takes_them() {
        let noisy = swell(0.02);
        let found = noisy.character();
        // The median of 4000 correlated differences is known to 3 %; three times that.
        assert!((found.noise_sd_m / 0.02 - 1.0).abs() < 0.1, "{found:?}");
        // A spline through noise of 0.02 m at 10 Hz: several m/s², where the sea has 0.31.
        assert!(found.peak_acceleration_mps2 > 5.0, "{found:?}");
        let cutoff_hz = noisy.cutoff_of_noise_hz().unwrap();
        let smooth = noisy.smoothed(cutoff_hz).character();
        // The search lets pass a residual of noise only, so that a part of it stays.
        assert!(cutoff_hz > 0.25 && cutoff_hz < 4.0, "{cutoff_hz}");
        assert!(
            smooth.peak_acceleration_mps2 < 0.5 * found.peak_acceleration_mps2,
            "{smooth:?}"
        );
        // What is taken away has the root mean square of the noise at most, 0.02 m of a swell of 0.354 m.
        assert!(
            (smooth.significant_height_m / (4.0 * 0.5 / 2_f64.sqrt()) - 1.0).abs() < 0.02 / 0.354
        );
    }

    #[test]
    fn regress_rounding_is_noise() {
        // Steps of 10 cm: most rows repeat the one before, so the median difference is 0.
        let mut values = swell(0.0).values().to_vec();
        values
            .iter_mut()
            .for_each(|v| v[HEAVE] = (v[HEAVE] / 0.1).round() * 0.1);
        let rounded = MotionSeries::of(swell(0.0).times_s().to_vec(), values);
        let sd_m = 0.1 / 12_f64.sqrt();
        assert!((rounded.noise().sd_m / sd_m - 1.0).abs() < 1e-9);
        let smooth = rounded.smoothed(rounded.cutoff_of_noise_hz().unwrap());
        // The swell has 0.31 m/s², a spline through steps of 10 cm in 0.1 s has more than 10 m/s².
        assert!(rounded.peak_acceleration_mps2() > 10.0);
        assert!(
            smooth.peak_acceleration_mps2() < 0.6,
            "{}",
            smooth.peak_acceleration_mps2()
        );
    }
}
