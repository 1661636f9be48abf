//! How much of a measured heave is noise, and how much of that short waves may be.

use std::f64::consts::TAU;

use super::character::{HEAVE, median};
use super::series::MotionSeries;
use super::slow::LONGEST_PERIOD_S;

/// Standard deviations to the median of absolute values of a normal distribution.
const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// What fourth differences see of seas with n rows in a mean period, over their standard deviation and times n². JONSWAP
/// spectra of peakedness 1 to 7 up to 3 and 6 peak frequencies have 10 to 12.5 with 3 to 5 rows, 6 to 11 with 8, 2 to 7 with 16.
const OF_SEAS: f64 = 12.0;
/// Halvings of the interval in which the noise is searched: to a thousandth of it.
const HALVINGS: usize = 10;

/// The noise of a measured heave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesNoise {
    /// Standard deviation of the noise, m: of what waves that are sampled so do not explain, or of rounding.
    pub sd_m: f64,
    /// The same if the shortest waves, as far as white noise looks like them, are noise too, m.
    pub greatest_sd_m: f64,
    /// Rows in a mean period, noise included; absent with fewer than two periods.
    pub rows_per_period: Option<f64>,
}

impl MotionSeries {
    /// The noise of the heave. White noise of variance N adds N to the mean square of the fourth differences (over their gain, 70)
    /// and makes neighbours less alike. A sea of variance S and n rows in a mean period adds (12/n²)² S, because the density of
    /// wind waves decreases as f⁻⁵, and neighbours correlate by cos(2π/n). N is the least that solves both for the variance and the
    /// mean period of the heave: where the rows are far apart, waves look like noise, and count as waves.
    #[must_use]
    pub fn noise(&self) -> SeriesNoise {
        let heave = self.coordinate(HEAVE);
        let white_m = white_sd_m(&heave);
        let (waves, _) = self.without_slow_heave(LONGEST_PERIOD_S);
        let rows_per_period = waves.mean_period_s().map(|s| s / self.step_s());
        let variance = (waves.significant_height_m() / 4.0).powi(2);
        let beyond_waves_m = rows_per_period.map_or(white_m, |rows| {
            beyond_waves(white_m * white_m, variance, rows).sqrt()
        });
        let rounding_m = rounding_sd_m(&heave);
        SeriesNoise {
            sd_m: beyond_waves_m.max(rounding_m),
            greatest_sd_m: white_m.max(rounding_m),
            rows_per_period,
        }
    }
}

/// Standard deviation of white noise with the median fourth difference of the heave, m.
fn white_sd_m(heave: &[f64]) -> f64 {
    // The fourth difference of white noise has 1 + 16 + 36 + 16 + 1 times its variance.
    let fourth = heave.windows(5);
    let fourth = fourth.map(|z| (z[0] - 4.0 * z[1] + 6.0 * z[2] - 4.0 * z[3] + z[4]).abs());
    median(fourth.collect()) / (MEDIAN_OF_NORMAL * 70_f64.sqrt())
}

/// Standard deviation of rounding to the smallest step, m; 0 where most rows differ from the one before. The median difference
/// of rounded heights may be 0. Rounding errs evenly within one step.
fn rounding_sd_m(heave: &[f64]) -> f64 {
    let steps: Vec<f64> = heave.windows(2).map(|z| (z[1] - z[0]).abs()).collect();
    let moving = steps.iter().filter(|step| **step > 0.0);
    let is_rounded = 2 * moving.clone().count() < steps.len();
    let step_m = moving.fold(f64::INFINITY, |least, step| step.min(least));
    if is_rounded && step_m.is_finite() {
        step_m / 12_f64.sqrt()
    } else {
        0.0
    }
}

/// The variance of the noise in a heave of the given variance and rows per mean period, whose fourth differences are those of
/// white noise of variance `white`.
fn beyond_waves(white: f64, variance: f64, rows_per_period: f64) -> f64 {
    // Noise shortens the mean period: that of the waves alone is longer.
    let seen = |noise: f64| {
        let correlation = variance * (TAU / rows_per_period).cos() / (variance - noise);
        let rows = TAU / correlation.clamp(-1.0, 1.0).acos();
        noise + (OF_SEAS / (rows * rows)).powi(2) * (variance - noise)
    };
    if seen(0.0) >= white {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, white.min(variance));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if seen(middle) < white {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::wave::{Spectrum, WaveSpectrum};
    use crate::random::{Purpose, Stream};

    /// A JONSWAP sea with noise: 2000 rows.
    fn sea(height_m: f64, rate_hz: f64, noise_m: f64, seed: u64) -> MotionSeries {
        let mut random = Stream::new(seed, 0, Purpose::Deck);
        let spectrum = Spectrum::new(&WaveSpectrum::Jonswap {
            significant_height_m: height_m,
            peak_period_s: 5.0,
            peakedness: 3.3,
        });
        let waves = spectrum.unwrap().waves(1000, &mut random);
        let times_s: Vec<f64> = (0..2000).map(|i| f64::from(i) / rate_hz).collect();
        let heave = times_s.iter().map(|t| {
            let of_wave = |w: &crate::deck::wave::Wave| {
                w.amplitude_m * (w.angular_frequency * t + w.phase_rad).cos()
            };
            // The sum of twelve uniform numbers has a variance of 1.
            let normal: f64 = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
            waves.iter().map(of_wave).sum::<f64>() + noise_m * normal
        });
        let values = heave.map(|z| [0.0, 0.0, z, 0.0, 0.0]).collect();
        MotionSeries::of(times_s, values)
    }

    #[test]
    fn analytic_waves_whose_rows_are_far_apart_are_no_noise() {
        // 2.3 to 8 rows in the mean period of 3.9 s. A median of white noise would be 1.5 to 0.16 of the waves.
        for (rate_hz, seed) in [(0.6, 1), (0.8, 2), (1.0, 3), (1.28, 4), (2.0, 5)] {
            let series = sea(0.5, rate_hz, 0.0, seed);
            let noise = series.noise();
            assert!(
                noise.sd_m < 0.1 * noise.greatest_sd_m,
                "{rate_hz} {noise:?}"
            );
            assert!(noise.greatest_sd_m > 0.1 * 0.125, "{rate_hz} {noise:?}");
        }
    }

    #[test]
    fn analytic_noise_is_found_beside_waves_and_above_them() {
        // Beside waves of 0.125 m: 39 and 16 rows in a mean period. Noise of 0.1 m: three times the waves, at 10 and 2 Hz.
        for (height_m, rate_hz, noise_m) in [
            (0.5, 10.0, 0.01),
            (0.5, 4.0, 0.02),
            (0.13, 10.0, 0.1),
            (0.13, 2.0, 0.1),
            (1e-6, 5.0, 0.1),
        ] {
            for seed in 0..4 {
                let noise = sea(height_m, rate_hz, noise_m, seed).noise();
                // The median of 2000 correlated differences is known to 4 %, three times that; waves may be taken for a third of
                // the variance of the noise, a fifth of its standard deviation.
                assert!(
                    (0.8..1.12).contains(&(noise.sd_m / noise_m)),
                    "{height_m} {rate_hz} {noise:?}"
                );
            }
        }
    }
}
