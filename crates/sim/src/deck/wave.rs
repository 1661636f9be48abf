//! Spectra of a long-crested sea, and the waves that make one realisation.
//!
//! With `u = ω/ω_p`, the one-sided spectra of the surface's elevation are
//!
//! ```text
//! S_PM(ω) = (5/16) (H_s²/ω_p) u⁻⁵ exp(-5/4 u⁻⁴)
//! S_J(ω)  = C S_PM(ω) γ^exp(-(u - 1)²/(2 σ²)),   σ = 0.07 (u ≤ 1), 0.09 (u > 1)
//! ```
//!
//! (Pierson & Moskowitz 1964 in the form of Bretschneider; Hasselmann et al.
//! 1973.) C is computed so that `H_s = 4 √m0` holds for JONSWAP as well.
//! Moments are integrated over y in `1 - y⁴ = exp(-5/4 u⁻⁴)`, the share of the
//! Pierson–Moskowitz energy below u, which has neither a long tail nor a peak.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// Highest frequency of the waves of a realisation, in peak frequencies. Above
/// it lie 0.1 % of the energy of a Pierson–Moskowitz sea.
pub const HIGHEST_RATIO: f64 = 6.0;
/// Intervals of the numerical integrals.
const INTERVALS: usize = 4_000;

/// Shape and size of a sea.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum WaveSpectrum {
    /// A fully developed sea.
    PiersonMoskowitz {
        /// Significant wave height H_s = 4 √m0, m.
        significant_height_m: f64,
        /// Period of the spectrum's peak T_p, s.
        peak_period_s: f64,
    },
    /// A growing sea, limited in fetch.
    Jonswap {
        /// Significant wave height H_s = 4 √m0, m.
        significant_height_m: f64,
        /// Period of the spectrum's peak T_p, s.
        peak_period_s: f64,
        /// Peakedness γ in [1, 7]; 3.3, the mean of the experiment, where it is not given.
        #[serde(default = "mean_peakedness")]
        peakedness: f64,
    },
}

impl Default for WaveSpectrum {
    /// JONSWAP, 0.5 m, 5 s, γ = 3.3.
    fn default() -> Self {
        Self::Jonswap {
            significant_height_m: 0.5,
            peak_period_s: 5.0,
            peakedness: mean_peakedness(),
        }
    }
}

/// Acceleration of gravity by which waves are long or short, m/s².
const GRAVITY_MPS2: f64 = 9.806_65;

impl WaveSpectrum {
    /// Significant height over the length of the waves at the peak, `2π H_s / (g T_p²)`. Seas have at most about 1/15
    /// (DNV-RP-C205, T_p up to 8 s): steeper waves break.
    #[must_use]
    pub fn steepness(&self) -> f64 {
        let (Self::PiersonMoskowitz {
            significant_height_m,
            peak_period_s,
        }
        | Self::Jonswap {
            significant_height_m,
            peak_period_s,
            ..
        }) = *self;
        TAU * significant_height_m / (GRAVITY_MPS2 * peak_period_s * peak_period_s)
    }
}

/// The mean of the JONSWAP experiment.
fn mean_peakedness() -> f64 {
    3.3
}

/// One wave: elevation `a cos(ω t - k·x + φ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Amplitude a, m.
    pub amplitude_m: f64,
    /// Angular frequency ω, rad/s.
    pub angular_frequency: f64,
    /// Phase φ, rad.
    pub phase_rad: f64,
}

/// A spectrum with its constants computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    variance_m2: f64,
    peak: f64,
    peakedness: f64,
    norm: f64,
}

/// u = ω/ω_p below which the share 1 - y⁴ of the energy of S_PM lies.
fn ratio_at(y: f64) -> f64 {
    (-1.25 / (-(y * y * y * y)).ln_1p()).sqrt().sqrt()
}

/// Inverse of [`ratio_at`].
fn share_at(u: f64) -> f64 {
    let u2 = u * u;
    (-(-1.25 / (u2 * u2)).exp_m1()).sqrt().sqrt()
}

impl Spectrum {
    /// Checks the settings and computes the constants.
    ///
    /// # Errors
    /// Height and period must be positive, γ in [1, 7].
    pub fn new(settings: &WaveSpectrum) -> Result<Self, SimError> {
        let (height, period, peakedness) = match *settings {
            WaveSpectrum::PiersonMoskowitz {
                significant_height_m,
                peak_period_s,
            } => (significant_height_m, peak_period_s, 1.0),
            WaveSpectrum::Jonswap {
                significant_height_m,
                peak_period_s,
                peakedness,
            } => (significant_height_m, peak_period_s, peakedness),
        };
        check::positive("significant_height_m", height)?;
        check::positive("peak_period_s", period)?;
        check::within("peakedness", peakedness, 1.0, 7.0)?;
        let mut spectrum = Self {
            variance_m2: height * height / 16.0,
            peak: TAU / period,
            peakedness,
            norm: 1.0,
        };
        spectrum.norm = 1.0 / spectrum.integral(0, 0.0, 1.0);
        Ok(spectrum)
    }

    /// γ^exp(…), by which JONSWAP exceeds S_PM before normalising.
    fn enhancement(&self, u: f64) -> f64 {
        let width = if u <= 1.0 { 0.07 } else { 0.09 };
        let e = (u - 1.0) / width;
        self.peakedness.powf((-0.5 * e * e).exp())
    }

    /// `4 y³ u^n γ^…`, the integrand over y.
    fn integrand(&self, n: i32, y: f64) -> f64 {
        let u = ratio_at(y);
        4.0 * y * y * y * u.powi(n) * self.norm * self.enhancement(u)
    }

    /// Its integral over y from `low` to `high`, by midpoints; the peak, where
    /// the width σ jumps, ends an interval.
    fn integral(&self, n: i32, low: f64, high: f64) -> f64 {
        let peak = share_at(1.0).clamp(low, high);
        let part = |a: f64, b: f64| {
            let h = (b - a) / INTERVALS as f64;
            (0..INTERVALS)
                .map(|i| h * self.integrand(n, a + h * (i as f64 + 0.5)))
                .sum::<f64>()
        };
        part(low, peak) + part(peak, high)
    }

    /// Spectral density S(ω), m² s.
    #[must_use]
    pub fn density(&self, angular_frequency: f64) -> f64 {
        if angular_frequency <= 0.0 {
            return 0.0;
        }
        let u = angular_frequency / self.peak;
        let pm = 5.0 * self.variance_m2 / self.peak * u.powi(-5) * (-1.25 * u.powi(-4)).exp();
        pm * self.norm * self.enhancement(u)
    }

    /// Moment `m_n = ∫ ωⁿ S dω` for n in 0..=3 (m4 has no limit), m² (rad/s)ⁿ.
    #[must_use]
    pub fn moment(&self, n: u8) -> f64 {
        let n = i32::from(n.min(3));
        self.variance_m2 * self.peak.powi(n) * self.integral(n, 0.0, 1.0)
    }

    /// One realisation: `count` waves of equal amplitude √(2 m0/count), each at
    /// a frequency drawn within its own `count`-th of the energy and with a
    /// random phase. The variance is m0 whatever is drawn; frequencies are not
    /// multiples of each other, so that the sea does not repeat.
    #[must_use]
    pub fn waves(&self, count: usize, stream: &mut Stream) -> Vec<Wave> {
        let low = share_at(HIGHEST_RATIO);
        let h = (1.0 - low) / INTERVALS as f64;
        let amplitude_m = (2.0 * self.variance_m2 / count as f64).sqrt();
        // Energy from the highest frequency (y = low) downwards.
        let mut below = vec![0.0; INTERVALS + 1];
        for i in 0..INTERVALS {
            below[i + 1] = below[i] + self.integrand(0, low + h * (i as f64 + 0.5));
        }
        let total = below[INTERVALS];
        let mut interval = 0;
        (0..count)
            .map(|i| {
                let wanted = (i as f64 + stream.uniform()) / count as f64 * total;
                while interval + 1 < INTERVALS && below[interval + 1] < wanted {
                    interval += 1;
                }
                let share = (wanted - below[interval]) / (below[interval + 1] - below[interval]);
                let u = ratio_at(low + h * (interval as f64 + share));
                Wave {
                    amplitude_m,
                    angular_frequency: self.peak * u,
                    phase_rad: TAU * stream.uniform(),
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    const PM: WaveSpectrum = WaveSpectrum::PiersonMoskowitz {
        significant_height_m: 2.0,
        peak_period_s: 8.0,
    };

    fn spectra() -> [Spectrum; 2] {
        let jonswap = WaveSpectrum::Jonswap {
            significant_height_m: 2.0,
            peak_period_s: 8.0,
            peakedness: 3.3,
        };
        [PM, jonswap].map(|s| Spectrum::new(&s).expect("valid settings"))
    }

    #[test]
    fn analytic_moments_of_pierson_moskowitz() {
        let [pm, _] = spectra();
        let b = 1.25 * pm.peak.powi(4);
        // With S = A ω⁻⁵ exp(-B ω⁻⁴) and m0 = A/(4B): m1 = m0 B^¼ Γ(¾), m2 = m0 √(π B).
        let gamma_three_quarters = 1.225_416_702_465_177_7;
        // Midpoints of a smooth integrand at 8000 intervals: relative 1e-7.
        assert!((4.0 * pm.moment(0).sqrt() - 2.0).abs() < 1e-7);
        let m1 = 0.25 * b.powf(0.25) * gamma_three_quarters;
        assert!((pm.moment(1) / m1 - 1.0).abs() < 1e-6);
        let m2 = 0.25 * (std::f64::consts::PI * b).sqrt();
        assert!((pm.moment(2) / m2 - 1.0).abs() < 1e-6);
        // Mean zero-crossing period, known as 0.710 T_p to three digits.
        let crossing_s = TAU * (pm.moment(0) / pm.moment(2)).sqrt();
        assert!((crossing_s / 8.0 - 0.710).abs() < 5.1e-4);
    }

    #[test]
    fn analytic_density_integrates_to_its_moments() {
        for spectrum in spectra() {
            // A plain sum over ω, against the integral over y.
            let h = 1e-3;
            let mut sums = [0.0; 3];
            for i in 0..40_000 {
                let w = h * (f64::from(i) + 0.5);
                for (n, sum) in sums.iter_mut().enumerate() {
                    *sum += h * w.powi(n as i32) * spectrum.density(w);
                }
            }
            assert!((4.0 * sums[0].sqrt() - 2.0).abs() < 1e-5);
            for n in 0..3_u8 {
                let tail = 5.0 * 0.25 * spectrum.norm * spectrum.peak.powi(4)
                    / (f64::from(4 - n) * 40.0_f64.powi(4 - i32::from(n)));
                // The tail beyond 40 rad/s is ω⁻⁵ to a relative (ω_p/40)⁴.
                let sum = sums[usize::from(n)] + tail;
                assert!((sum / spectrum.moment(n) - 1.0).abs() < 1e-5, "{n}");
            }
        }
    }

    #[test]
    fn analytic_jonswap_is_narrower_and_gamma_one_is_pierson_moskowitz() {
        let [pm, jonswap] = spectra();
        // DNV-RP-C205: T_z/T_p = 0.6673 + 0.05037 γ - 0.006230 γ² + 0.0003341 γ³, a fit to 1 %.
        let crossing_s = TAU * (jonswap.moment(0) / jonswap.moment(2)).sqrt();
        let fit = 0.6673 + 0.05037 * 3.3 - 0.006_230 * 3.3 * 3.3 + 0.000_334_1 * 35.937;
        assert!((crossing_s / 8.0 - fit).abs() < 0.01, "{crossing_s} {fit}");
        // DNV-RP-C205: the norm is close to 1 - 0.287 ln γ.
        assert!((jonswap.norm - (1.0 - 0.287 * 3.3_f64.ln())).abs() < 0.01);
        let flat = WaveSpectrum::Jonswap {
            significant_height_m: 2.0,
            peak_period_s: 8.0,
            peakedness: 1.0,
        };
        let flat = Spectrum::new(&flat).expect("valid settings");
        assert_eq!(flat.density(0.9), pm.density(0.9));
    }

    #[test]
    fn analytic_waves_carry_the_energy_where_the_spectrum_has_it() {
        for spectrum in spectra() {
            let mut stream = Stream::new(1, 2, Purpose::Deck);
            let waves = spectrum.waves(400, &mut stream);
            let moment = |n: i32| -> f64 {
                let energy = |w: &Wave| 0.5 * w.amplitude_m.powi(2) * w.angular_frequency.powi(n);
                waves.iter().map(energy).sum()
            };
            // The variance is m0 by construction: rounding only.
            assert!((4.0 * moment(0).sqrt() - 2.0).abs() < 1e-12);
            // Each frequency is random within 1/400 of the energy. Frequencies above 6 ω_p, which are cut off,
            // hold (to first order) 0.6 % of m1 and 4 % of m2.
            assert!((moment(1) / spectrum.moment(1) - 1.0).abs() < 0.01);
            let ratio = moment(2) / spectrum.moment(2);
            assert!(ratio < 1.0 && ratio > 0.93, "{ratio}");
        }
    }

    #[test]
    fn prop_realisations_follow_their_seed() {
        let [pm, _] = spectra();
        let draw = |seed| pm.waves(20, &mut Stream::new(seed, 0, Purpose::Deck));
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }

    #[test]
    fn prop_bad_settings_name_key_and_number() {
        let bad = WaveSpectrum::PiersonMoskowitz {
            significant_height_m: 0.5,
            peak_period_s: 0.0,
        };
        let message = Spectrum::new(&bad).expect_err("no period").to_string();
        assert!(message.contains("peak_period_s") && message.contains("found 0"));
    }
}
