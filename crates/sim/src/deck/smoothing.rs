//! A measured motion without what is faster than a cutoff.

use std::f64::consts::{LN_2, TAU};

use super::character::HEAVE;
use super::series::MotionSeries;
use super::spline::natural_cubic;

/// ω²σ²/2 at the cutoff: there (1 + x) exp(−x), what remains of a sine, is √½.
const HALF_POWER: f64 = 1.078_3;
/// Half width of the kernel, in its standard deviations: beyond it a parabola has 7e-6 of its weights. Beyond 4 they are 5e-4.
const REACH: f64 = 5.0;
/// Share of the weighted squares of u or u² that must be left beside the polynomials of lower degree, where rounding errs by
/// 1e-16: rows that are almost one place show no curvature.
const LEAST_SHARE: f64 = 1e-9;
/// What noise costs beyond its expectation, times √rows: by chance, noise of a short recording looks like waves. Of 100 rows it counts
/// 1.4 times, a usual factor (Kim & Gu 2004).
const CAUTION: f64 = 4.0;
/// Cutoffs that are tried in an octave: a fifth apart. The error is flat at its least.
const PER_OCTAVE: f64 = 4.0;

/// Mean square of the acceleration that white noise leaves behind a cutoff f, over N Δt f⁵, of variance N and rows Δt apart: the integral
/// of 2 ω⁴ ((1 + x) exp(−x))² over all frequencies.
const NOISE_ACCELERATION: f64 = 1_725.0;

impl MotionSeries {
    /// The series without what is faster than a cutoff: each row becomes the value, at its time, of the parabola with the
    /// least squares through its neighbours, weighted by a Gaussian (local quadratic regression; Fan & Gijbels 1996, ch. 3).
    /// Of a sine, (1 + x) exp(−x) with x = ω²σ²/2 remains: half of the power at the cutoff f, which is σ = 1.469/(2π f), and
    /// all but 0.1 % of the amplitude at a fifth of it; no phase is shifted. Beside a gap and at the ends, where the
    /// neighbours are on one side, a parabola errs by the third derivative only. A mean of them errs by the first.
    #[must_use]
    pub fn smoothed(&self, cutoff_hz: f64) -> Self {
        self.by_parabolas(cutoff_hz).0
    }

    fn by_parabolas(&self, cutoff_hz: f64) -> (Self, f64) {
        self.filtered((2.0 * HALF_POWER).sqrt() / (TAU * cutoff_hz), of_parabola)
    }

    /// The same of means in place of parabolas, with σ = √(ln 2)/(2π f): half of the power at the cutoff, and 1.4 % less of the
    /// amplitude at a fifth of it. At the ends it lets half as much of faster motion through as parabolas do.
    pub(super) fn averaged(&self, cutoff_hz: f64) -> Self {
        self.filtered(LN_2.sqrt() / (TAU * cutoff_hz), of_mean).0
    }

    /// Each row as the weighted sum of its neighbours, and the mean weight of a row in its own sum. `weigh` has the times of the
    /// neighbours, the row's, and the Gaussian's σ.
    fn filtered(&self, sigma_s: f64, weigh: fn(&[f64], f64, f64, &mut Vec<f64>)) -> (Self, f64) {
        let times_s = self.times_s();
        let (mut from, mut to) = (0, 0);
        let mut weights = Vec::new();
        let mut own = 0.0;
        let smooth = |row: usize| {
            let at_s = times_s[row];
            while times_s[from] < at_s - REACH * sigma_s {
                from += 1;
            }
            while to < times_s.len() && times_s[to] <= at_s + REACH * sigma_s {
                to += 1;
            }
            weigh(&times_s[from..to], at_s, sigma_s, &mut weights);
            own += weights[row - from];
            let mut sum = [0.0; 5];
            for (weight, value) in weights.iter().zip(&self.values()[from..to]) {
                (0..5).for_each(|axis| sum[axis] += weight * value[axis]);
            }
            sum
        };
        let values = (0..self.rows()).map(smooth).collect();
        (self.with_values(values), own / self.rows() as f64)
    }

    /// The cutoff (Hz) with the least expected square error of the smoothed heave. The error is the noise that stays and the waves that
    /// are lost. For white noise of variance N its expected square is, up to a constant, R + 2 N w (Mallows 1973): R is the mean
    /// square of what the cutoff takes away, w the mean weight of a row in its own smoothed value. N is raised a little, the more the fewer rows. Absent
    /// where there is no noise.
    #[must_use]
    pub fn cutoff_of_noise_hz(&self) -> Option<f64> {
        let noise = self.noise().sd_m.powi(2);
        let caution = 1.0 + CAUTION / (self.rows() as f64).sqrt();
        let lowest_hz = 10.0 / self.duration_s();
        let mut at_hz = 0.5 / self.step_s();
        let mut best = None;
        while noise > 0.0 && at_hz > lowest_hz {
            let (smooth, own) = self.by_parabolas(at_hz);
            let pairs = self.values().iter().zip(smooth.values());
            let squares: f64 = pairs.map(|(a, b)| (a[HEAVE] - b[HEAVE]).powi(2)).sum();
            let taken = squares / self.rows() as f64;
            let error = taken + 2.0 * caution * noise * own;
            let least = best.map_or(f64::INFINITY, |(_, least)| least);
            if error < least {
                best = Some((at_hz, error));
            }
            // A lower cutoff takes more.
            if taken > least {
                break;
            }
            at_hz *= (-1.0 / PER_OCTAVE).exp2();
        }
        best.map(|(hz, _)| hz)
    }

    /// Share of the mean square acceleration of the smoothed heave that is lost when the cutoff is halved. White noise of the given
    /// standard deviation that is left does not count, nor do the ends. Where the share is large, the acceleration still grows with the
    /// cutoff, so that faster waves are lost. Absent with fewer than ten rows away from the ends.
    #[must_use]
    pub fn acceleration_near_cutoff(&self, cutoff_hz: f64, noise_sd_m: f64) -> Option<f64> {
        let noise = noise_sd_m.powi(2) * self.step_s() * NOISE_ACCELERATION;
        let (first_s, last_s) = (self.times_s()[0], self.times_s()[self.rows() - 1]);
        let inner_s = first_s + 1.0 / cutoff_hz..last_s - 1.0 / cutoff_hz;
        let square = |hz: f64| {
            let heave = self.smoothed(hz).coordinate(HEAVE);
            let second = natural_cubic(self.times_s(), &heave);
            let rows = self.times_s().iter().zip(second);
            let inner: Vec<f64> = rows
                .filter(|(time_s, _)| inner_s.contains(time_s))
                .map(|(_, second)| second * second)
                .collect();
            let mean = inner.iter().sum::<f64>() / inner.len() as f64;
            (inner.len() >= 10).then(|| (mean - noise * hz.powi(5)).max(0.0))
        };
        let [whole, half] = [square(cutoff_hz)?, square(0.5 * cutoff_hz)?];
        (whole > 0.0).then(|| (1.0 - half / whole).max(0.0))
    }
}

/// The weights of a mean.
fn of_mean(times_s: &[f64], at_s: f64, sigma_s: f64, weights: &mut Vec<f64>) {
    weights.clear();
    let places = times_s.iter().map(|t| (t - at_s) / sigma_s);
    weights.extend(places.map(|u| (-0.5 * u * u).exp()));
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
}

/// The weights with which values at the given times make the value of their parabola at one of them: Σ pₖ(t) pₖ(0) / |pₖ|² of
/// the polynomials p of degree 0 to 2 that are orthogonal under the Gaussian. A polynomial that the rows do not determine, as
/// with fewer than three, is left out.
fn of_parabola(times_s: &[f64], at_s: f64, sigma_s: f64, weights: &mut Vec<f64>) {
    of_mean(times_s, at_s, sigma_s, weights);
    let places = times_s.iter().map(|t| (t - at_s) / sigma_s);
    // Of the powers 0 to 4; the first is 1.
    let mut moment = [0.0; 5];
    for (u, weight) in places.clone().zip(&*weights) {
        let mut power = *weight;
        for m in &mut moment {
            *m += power;
            power *= u;
        }
    }
    let inverse = |left: f64, of: f64| {
        if left > LEAST_SHARE * of {
            1.0 / left
        } else {
            0.0
        }
    };
    // p₁ = u − c, p₂ = u² − d − e p₁.
    let c = moment[1];
    let first = moment[2] - c * moment[1];
    let by_first = inverse(first, moment[2]);
    let d = moment[2];
    let along = moment[3] - c * moment[2];
    let e = along * by_first;
    let second = moment[4] - d * d - e * along;
    let by_second = inverse(second, moment[4]);
    let (first_here, second_here) = (-c * by_first, (e * c - d) * by_second);
    for (u, weight) in places.zip(weights) {
        let p1 = u - c;
        let p2 = u * u - d - e * p1;
        *weight *= 1.0 + p1 * first_here + p2 * second_here;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck::wave::{Spectrum, Wave, WaveSpectrum};
    use crate::random::{Purpose, Stream};

    /// Rows every 0.1 s for 400 s, where each is followed by a gap of the given length with a probability of 2 %.
    fn times_with_gaps(gap_s: f64) -> Vec<f64> {
        let mut random = Stream::new(5, 0, Purpose::Deck);
        let mut times_s = vec![0.0];
        while times_s[times_s.len() - 1] < 400.0 {
            let step_s = if random.uniform() < 0.02 { gap_s } else { 0.1 };
            times_s.push(times_s[times_s.len() - 1] + step_s);
        }
        times_s
    }

    fn heave_of(times_s: &[f64], heave: impl FnMut(&f64) -> f64) -> MotionSeries {
        let heave = times_s.iter().map(heave);
        let values = heave.map(|z| [0.0, 0.0, z, 0.0, 0.0]).collect();
        MotionSeries::of(times_s.to_vec(), values)
    }

    #[test]
    fn analytic_power_is_halved_at_the_cutoff() {
        let times_s: Vec<f64> = (0..4000).map(|i| 0.1 * f64::from(i)).collect();
        let swell = heave_of(&times_s, |t| 0.5 * (TAU * t / 8.0).sin());
        // What remains far from the ends, at the cutoff and at a fifth of it.
        let x: f64 = HALF_POWER / 25.0;
        for (cutoff_hz, remains) in [(0.125, 0.5_f64.sqrt()), (0.625, (1.0 + x) * (-x).exp())] {
            let smooth = swell.smoothed(cutoff_hz);
            let most = smooth.values()[1000..3000]
                .iter()
                .map(|v| v[HEAVE])
                .fold(0.0, f64::max);
            // Rows lie 1/80 of a period apart, so the greatest is within 8e-4 of the peak; the kernel is cut at 5 σ.
            assert!((most / 0.5 - remains).abs() < 2e-3, "{cutoff_hz} {most}");
        }
    }

    #[test]
    fn analytic_parabolas_stay_beside_gaps_and_at_the_ends() {
        let times_s = times_with_gaps(2.0);
        let parabola = heave_of(&times_s, |t| 0.3 - 0.02 * t + 1e-4 * t * t);
        // Kernels of 0.03 rows to all rows: alone, with one neighbour, and all.
        for cutoff_hz in [100.0, 2.0, 0.3, 0.01, 1e-4] {
            let smooth = parabola.smoothed(cutoff_hz);
            for (a, b) in parabola.values().iter().zip(smooth.values()) {
                // The heave is 8.3 m at most; the least share of the squares costs half of the digits.
                assert!((a[HEAVE] - b[HEAVE]).abs() < 1e-7, "{cutoff_hz}");
            }
        }
    }

    #[test]
    fn analytic_noise_with_gaps_leaves_the_acceleration_of_the_waves() {
        // Two seas, of 0.61 m/s² together, with noise of 1 cm. A gap may be a quarter of the shorter waves; their spline over it is
        // off by a twentieth.
        for gap_s in [0.1, 0.5, 1.0] {
            let mut random = Stream::new(11, 0, Purpose::Deck);
            let series = heave_of(&times_with_gaps(gap_s), |t| {
                let normal: f64 = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
                0.3 * (TAU * t / 6.0).sin() + 0.1 * (TAU * t / 3.7).sin() + 0.01 * normal
            });
            let smooth = series.smoothed(series.cutoff_of_noise_hz().unwrap());
            let peak_mps2 = smooth.peak_acceleration_mps2();
            // Below 0.55 m/s² a tenth of the waves would be smoothed away. Noise of 1 cm at both sides of the gap of 1 s bends the spline by up to 0.5 m/s². Means of the neighbours make
            // 4 m/s² of the gaps of 0.5 s.
            assert!((0.55..1.2).contains(&peak_mps2), "{gap_s} s: {peak_mps2}");
        }
    }

    /// JONSWAP seas (significant height, m, and peak period, s), without noise and with it.
    fn noisy_seas(seas: &[[f64; 2]], rate_hz: f64, noise_m: f64) -> (MotionSeries, MotionSeries) {
        let mut random = Stream::new(7, 0, Purpose::Deck);
        let mut waves = Vec::new();
        for &[significant_height_m, peak_period_s] in seas {
            let spectrum = Spectrum::new(&WaveSpectrum::Jonswap {
                significant_height_m,
                peak_period_s,
                peakedness: 3.3,
            });
            waves.extend(spectrum.unwrap().waves(400, &mut random));
        }
        let times_s: Vec<f64> = (0..(rate_hz * 400.0) as u32)
            .map(|i| f64::from(i) / rate_hz)
            .collect();
        let seas = heave_of(&times_s, |t| {
            let wave = |wave: &Wave| {
                wave.amplitude_m * (wave.angular_frequency * t + wave.phase_rad).cos()
            };
            waves.iter().map(wave).sum()
        });
        let mut values = seas.values().to_vec();
        for value in &mut values {
            let normal: f64 = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
            value[HEAVE] += noise_m * normal;
        }
        let noisy = seas.with_values(values);
        (seas, noisy)
    }

    #[test]
    fn analytic_acceleration_that_noise_hides_is_noticed() {
        let seas: [&[[f64; 2]]; 8] = [
            &[[1.0, 6.0]],
            &[[0.5, 5.0]],
            &[[2.0, 9.0]],
            &[[4.0, 12.0]],
            &[[1.0, 12.0], [0.3, 4.0]],
            &[[1.0, 12.0], [0.15, 3.0]],
            &[[2.0, 10.0], [0.5, 4.0]],
            &[[0.3, 3.0]],
        ];
        for seas in seas {
            for rate_hz in [8.0, 20.0] {
                for noise_m in [0.003, 0.01, 0.03, 0.08] {
                    let (seas_alone, series) = noisy_seas(seas, rate_hz, noise_m);
                    let cutoff_hz = series.cutoff_of_noise_hz().unwrap();
                    let near = (1.0 / cutoff_hz * rate_hz) as usize;
                    let root = |series: &MotionSeries| {
                        let second = natural_cubic(series.times_s(), &series.coordinate(HEAVE));
                        let inner = &second[near..second.len() - near];
                        inner.iter().map(|a| a * a).sum::<f64>().sqrt()
                    };
                    let lost = 1.0 - root(&seas_alone.smoothed(cutoff_hz)) / root(&seas_alone);
                    let noise_sd_m = series.noise().sd_m;
                    let share = series.acceleration_near_cutoff(cutoff_hz, noise_sd_m);
                    let share = share.unwrap();
                    // 13 shares are above 0.6, where 21 to 57 % are lost; below are up to 22 %. The bounds stand beside these.
                    let case = format!("{seas:?} {rate_hz} Hz {noise_m} m: {share:.2}, {lost:.2}");
                    assert!(share < 0.6 || lost > 0.2, "{case}");
                    assert!(share > 0.6 || lost < 0.25, "{case}");
                }
            }
        }
    }

    #[test]
    fn analytic_the_cutoff_of_noise_has_almost_the_least_error() {
        // A swell and a wind sea of 0.35 and 0.04 m (standard deviations); the noise is below, at, and above the wind sea.
        let times_s: Vec<f64> = (0..3000).map(|i| 0.1 * f64::from(i)).collect();
        let waves = heave_of(&times_s, |t| {
            0.5 * (TAU * t / 9.0).sin()
                + 0.04 * (TAU * t / 2.3).sin()
                + 0.04 * (TAU * t / 1.9).cos()
        });
        for noise_m in [0.005, 0.04, 0.2] {
            let mut random = Stream::new(3, 0, Purpose::Deck);
            let mut values = waves.values().to_vec();
            for value in &mut values {
                let normal: f64 = (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
                value[HEAVE] += noise_m * normal;
            }
            let noisy = waves.with_values(values);
            let error_m = |cutoff_hz: f64| {
                let smooth = noisy.smoothed(cutoff_hz);
                let pairs = waves.values().iter().zip(smooth.values());
                let squares: f64 = pairs.map(|(a, b)| (a[HEAVE] - b[HEAVE]).powi(2)).sum();
                (squares / 3000.0).sqrt()
            };
            let least_m = (0..40)
                .map(|i| error_m(5.0 * 0.9_f64.powi(i)))
                .fold(f64::INFINITY, f64::min);
            let chosen_m = error_m(noisy.cutoff_of_noise_hz().unwrap());
            // Cutoffs that are tried are a fifth apart; the noise is estimated to 5 %. The lowest cutoff that takes no more than the
            // noise errs by 1.19, 1.13 and 1.01 times the least.
            assert!(
                chosen_m < 1.05 * least_m,
                "{noise_m}: {chosen_m}, {least_m}"
            );
        }
    }
}
