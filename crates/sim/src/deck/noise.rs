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
/// Orders of the differences that tell noise from the tail of a sea.
const ORDERS: [usize; 2] = [4, 8];
/// Variance that fourth differences see of the tail of a sea, over that of eighth differences; of white noise, 1. The
/// density of wind waves decreases as f⁻⁵: 1.5 with 4 rows in their mean period, 1.75 with 10 and more, greater where the sea
/// ends below half of the rate of the rows.
const TAIL: f64 = 1.5;
/// What that ratio of white noise may exceed 1 by chance, times √rows: twice its standard deviation, as found with 120 to 2400 rows.
const BY_CHANCE: f64 = 3.0;
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
    /// The noise of the heave: the least that two equations allow. Differences of the order d, over the root of the sum of their
    /// squared weights, have the variance N of white noise for every d, and more of waves.
    ///
    /// Of one sea of variance S with n rows in a mean period, fourth differences have up to (12/n²)² S, and neighbours correlate
    /// by cos(2π/n) without noise, by less with it. N solves both for the variance and the mean period of the heave: where the
    /// rows are far apart, waves look like noise, and count as waves.
    ///
    /// Of the tail of any sea (wind waves on a swell), fourth differences have at least 1.5 times the variance of eighth
    /// differences. Less than what white noise has by chance counts as noise.
    #[must_use]
    pub fn noise(&self) -> SeriesNoise {
        let heave = self.coordinate(HEAVE);
        let (waves, _) = self.without_slow_heave(LONGEST_PERIOD_S);
        let rows_per_period = waves.mean_period_s().map(|s| s / self.step_s());
        let variance = (waves.significant_height_m() / 4.0).powi(2);
        if variance == 0.0 {
            // What differences of such a heave see is rounding of its slow part, or nothing.
            return SeriesNoise {
                sd_m: 0.0,
                greatest_sd_m: 0.0,
                rows_per_period,
            };
        }
        let [fourth, eighth] = ORDERS.map(|order| self.variance_of_differences(&heave, order));
        let beside_one_sea =
            rows_per_period.map_or(fourth, |rows| beyond_waves(fourth, variance, rows));
        let beside_a_tail = beside_a_tail(fourth, eighth, self.rows());
        let rounding_m = rounding_sd_m(&heave);
        SeriesNoise {
            sd_m: beside_one_sea.min(beside_a_tail).sqrt().max(rounding_m),
            greatest_sd_m: fourth.sqrt().max(rounding_m),
            rows_per_period,
        }
    }

    /// Variance of white noise with the median difference of the given order of the heave, m². The weights of a difference are
    /// those that are 0 for each polynomial of a lower degree at the times of the rows, so that uneven times are no noise.
    fn variance_of_differences(&self, heave: &[f64], order: usize) -> f64 {
        let (times_s, step_s) = (self.times_s(), self.step_s());
        let differences = times_s.windows(order + 1).zip(heave.windows(order + 1));
        let sizes = differences.map(|(t, z)| {
            let (mut sum, mut squares) = (0.0, 0.0);
            for (at_s, height) in t.iter().zip(z) {
                let places = t.iter().map(|other| (at_s - other) / step_s);
                let weight = 1.0 / places.filter(|place| *place != 0.0).product::<f64>();
                sum += weight * height;
                squares += weight * weight;
            }
            (sum / squares.sqrt()).abs()
        });
        (median(sizes.collect()) / MEDIAN_OF_NORMAL).powi(2)
    }
}

/// The variance of the noise beside the tail of a sea, of the variances of fourth and eighth differences.
fn beside_a_tail(fourth: f64, eighth: f64, rows: usize) -> f64 {
    let by_chance = 1.0 + BY_CHANCE / (rows as f64).sqrt();
    let ratio = fourth / (eighth * by_chance);
    // Without eighth differences nothing is known of a tail.
    if !(ratio > 1.0 && eighth > 0.0) {
        return fourth;
    }
    fourth * (TAIL / ratio - 1.0).max(0.0) / (TAIL - 1.0)
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

    /// JONSWAP seas (significant height, m, and peak period, s) with noise: 2000 rows at times that are off by up to the given
    /// share of a row.
    fn recorded(
        seas: &[[f64; 2]],
        [rate_hz, off]: [f64; 2],
        noise_m: f64,
        seed: u64,
    ) -> MotionSeries {
        let mut random = Stream::new(seed, 0, Purpose::Deck);
        let mut waves = Vec::new();
        for [significant_height_m, peak_period_s] in seas {
            let spectrum = Spectrum::new(&WaveSpectrum::Jonswap {
                significant_height_m: *significant_height_m,
                peak_period_s: *peak_period_s,
                peakedness: 3.3,
            });
            waves.extend(spectrum.unwrap().waves(1000, &mut random));
        }
        let mut times_s = Vec::new();
        let heave = (0..2000).map(|i| {
            let t = (f64::from(i) + off * (2.0 * random.uniform() - 1.0)) / rate_hz;
            times_s.push(t);
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
            let series = recorded(&[[0.5, 5.0]], [rate_hz, 0.0], 0.0, seed);
            let noise = series.noise();
            assert!(
                noise.sd_m < 0.1 * noise.greatest_sd_m,
                "{rate_hz} {noise:?}"
            );
            assert!(noise.greatest_sd_m > 0.1 * 0.125, "{rate_hz} {noise:?}");
        }
    }

    #[test]
    fn analytic_a_wind_sea_on_a_swell_is_no_noise() {
        // 4 to 10 rows in the mean period of the wind sea, 20 and more in that of both, so that one sea of this height would have
        // less in its differences.
        for (wind_sea, rate_hz, seed) in [
            ([0.3, 2.5], 2.5, 1),
            ([0.3, 2.5], 4.0, 2),
            ([0.15, 2.0], 4.0, 3),
            ([0.15, 2.0], 6.0, 4),
        ] {
            let noise = recorded(&[[1.0, 10.0], wind_sea], [rate_hz, 0.0], 0.0, seed).noise();
            // The ratio of the variances is known to a tenth, twice that by how much it counts.
            assert!(
                noise.sd_m < 0.45 * noise.greatest_sd_m,
                "{wind_sea:?} {rate_hz} {noise:?}"
            );
        }
    }

    #[test]
    fn analytic_noise_of_a_short_recording_is_no_wind_sea() {
        // Ten seconds, two waves: by chance, eighth differences of white noise are smaller than fourth differences.
        for seed in 0..40 {
            let whole = recorded(&[[0.4, 5.0]], [10.0, 0.0], 0.01, seed);
            let rows = 0..100;
            let values = whole.values()[rows.clone()].to_vec();
            let noise = MotionSeries::of(whole.times_s()[rows].to_vec(), values).noise();
            // The median of 96 correlated differences is known to 15 %, two and a half times that.
            assert!(noise.sd_m > 0.6 * 0.01, "{seed} {noise:?}");
        }
    }

    #[test]
    fn analytic_uneven_times_are_no_noise() {
        // Differences that take the rows for even see noise of 0.008 m at 4 Hz.
        for (rate_hz, noise_m) in [(4.0, 0.0), (10.0, 0.0), (10.0, 0.01)] {
            for seed in 0..4 {
                let noise = recorded(&[[0.5, 5.0]], [rate_hz, 0.45], noise_m, seed).noise();
                // As in the test of noise beside waves.
                let (least, most) = (0.8 * noise_m, 1.12 * noise_m + 0.0005);
                assert!(
                    (least..=most).contains(&noise.sd_m),
                    "{rate_hz} {noise_m} {noise:?}"
                );
            }
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
                let noise = recorded(&[[height_m, 5.0]], [rate_hz, 0.0], noise_m, seed).noise();
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
