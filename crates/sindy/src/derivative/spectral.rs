//! Spectral derivative by the fast Fourier transform, on a uniform grid.
//!
//! ```text
//! Y_k = Σ_i y_i e^(-2πj k i/N),   ẏ = IFFT( jω_k Y_k  for |k| ≤ m, 0 beyond ),   ω_k = 2π k / (N Δt)
//! ```
//!
//! *Periodic*: the samples cover whole periods, the next sample would be the first again. *Reflected*:
//! for other signals; the line through the first and the last sample is taken off and the rest
//! continued point-symmetrically beyond both ends, which leaves value and slope continuous there. The end
//! samples then pass unsmoothed, and the slope within a few `1/cutoff` of the ends carries their noise.
//!
//! The cut-off is none, a frequency, or the number of harmonics `m` that minimises the generalised
//! cross-validation score `N RSS(m) / (N - p_m)²`, `p_m` the number of fitted coefficients.
//!
//! Source: L. N. Trefethen, "Spectral Methods in MATLAB" (SIAM 2000), chapter 3.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use crate::data::grid;
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;

/// What lies beyond the ends of the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The record again.
    Periodic,
    /// Its point reflection about the end.
    Reflected,
}

/// Which frequencies pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// All.
    None,
    /// Those up to this number of cycles per unit of time.
    Frequency(f64),
    /// As many as generalised cross-validation finds.
    CrossValidated,
}

/// Settings of a spectral derivative, checked when built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectral {
    ends: Ends,
    cutoff: Cutoff,
}

impl Spectral {
    /// A derivative with the given `ends` and `cutoff`.
    ///
    /// # Errors
    /// A cut-off frequency that is not positive and finite.
    pub fn new(ends: Ends, cutoff: Cutoff) -> Result<Self, SindyError> {
        match cutoff {
            Cutoff::Frequency(f) if !(f > 0.0) || !f.is_finite() => {
                Err(SindyError::setting("cutoff", "positive and finite", f))
            }
            _ => Ok(Self { ends, cutoff }),
        }
    }

    /// What lies beyond the ends of the record.
    #[must_use]
    pub fn ends(&self) -> Ends {
        self.ends
    }

    /// Which frequencies pass.
    #[must_use]
    pub fn cutoff(&self) -> Cutoff {
        self.cutoff
    }

    /// Smooths `y` sampled at `time` and differentiates it.
    ///
    /// # Errors
    /// Fewer than 4 samples, lengths that differ, non-finite values, times that do not increase or that are
    /// not uniform to a millionth of the period.
    pub fn apply(&self, time: &[f64], y: &[f64]) -> Result<Smoothed, SindyError> {
        grid::check(time, y, 4)?;
        let n = y.len();
        let dt = grid::uniform_period(time).ok_or_else(|| {
            let steps = || (1..n).map(|i| time[i] - time[i - 1]);
            let shortest = steps().fold(f64::INFINITY, f64::min);
            let longest = steps().fold(0.0, f64::max);
            SindyError::setting(
                "time",
                "a uniform grid for the spectral derivative",
                format!("steps from {shortest} to {longest}"),
            )
        })?;
        let (start, slope, mut signal) = match self.ends {
            Ends::Periodic => (0.0, 0.0, y.to_vec()),
            Ends::Reflected => {
                let (start, slope) = (y[0], (y[n - 1] - y[0]) / (n - 1) as f64);
                let bent: Vec<f64> = (0..n).map(|i| y[i] - start - slope * i as f64).collect();
                let mirrored = (1..n - 1).rev().map(|i| -bent[i]);
                let signal = bent.iter().copied().chain(mirrored).collect();
                (start, slope, signal)
            }
        };
        let length = signal.len();
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (
            planner.plan_fft_forward(length),
            planner.plan_fft_inverse(length),
        );
        let mut spectrum = forward.make_output_vec();
        let lost = |_| SindyError::Singular {
            what: "Fourier transform",
        };
        forward.process(&mut signal, &mut spectrum).map_err(lost)?;
        let highest = match self.cutoff {
            Cutoff::None => length / 2,
            // A millionth of a harmonic of tolerance, for a cut-off exactly on one.
            Cutoff::Frequency(f) => (f * dt * length as f64 + 1e-6) as usize,
            Cutoff::CrossValidated => self.harmonics(&spectrum, length),
        };
        let turn = 2.0 * std::f64::consts::PI / length as f64;
        let mut slopes = spectrum.clone();
        for (k, (value, slope)) in spectrum.iter_mut().zip(&mut slopes).enumerate() {
            let keep = if k <= highest {
                1.0 / length as f64
            } else {
                0.0
            };
            *value *= keep;
            // The derivative of the highest cosine is zero at the samples.
            *slope *= match 2 * k == length {
                true => Complex64::ZERO,
                false => Complex64::new(0.0, keep * turn * k as f64),
            };
        }
        // Rounding leaves an imaginary part where a real signal has none.
        for end in [&mut spectrum, &mut slopes] {
            end[0].im = 0.0;
            if length.is_multiple_of(2) {
                end[length / 2].im = 0.0;
            }
        }
        let mut value = inverse.make_output_vec();
        let mut derivative = inverse.make_output_vec();
        inverse.process(&mut spectrum, &mut value).map_err(lost)?;
        inverse
            .process(&mut slopes, &mut derivative)
            .map_err(lost)?;
        value.truncate(n);
        derivative.truncate(n);
        for i in 0..n {
            value[i] += start + slope * i as f64;
            derivative[i] = (derivative[i] + slope) / dt;
        }
        Ok(Smoothed { value, derivative })
    }

    /// The number of harmonics with the least cross-validation score.
    fn harmonics(&self, spectrum: &[Complex64], length: usize) -> usize {
        // A reflected record of n samples has 2 (n - 1) points, one coefficient a harmonic and two for the line.
        let (samples, each, fixed) = match self.ends {
            Ends::Periodic => (length as f64, 2.0, 1.0),
            Ends::Reflected => (length as f64 / 2.0 + 1.0, 1.0, 2.0),
        };
        let mut beyond = 0.0;
        let mut best = (spectrum.len() - 1, f64::INFINITY);
        for k in (1..spectrum.len()).rev() {
            let freedom = samples - each * k as f64 - fixed;
            // Below a tenth of the samples left over the score means little.
            if freedom >= 0.1 * samples {
                let score = beyond / (freedom * freedom);
                if score < best.1 {
                    best = (k, score);
                }
            }
            beyond += spectrum[k].norm_sqr();
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivative::tests::signals::gauss;

    fn rms(a: &[f64], b: &[f64]) -> f64 {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    }

    #[test]
    fn analytic_periodic_signals_are_exact() {
        for n in [64, 81] {
            let dt = 2.0 * std::f64::consts::PI / n as f64;
            let t: Vec<f64> = (0..n).map(|i| dt * i as f64).collect();
            let y: Vec<f64> = t.iter().map(|t| t.sin().exp()).collect();
            let d: Vec<f64> = t.iter().map(|t| t.cos() * t.sin().exp()).collect();
            let out = Spectral::new(Ends::Periodic, Cutoff::None)
                .unwrap()
                .apply(&t, &y)
                .unwrap();
            // The spectrum of exp(sin) is below rounding at 32 harmonics, which multiply rounding by 32.
            assert!(rms(&out.value, &y) < 1e-14 && rms(&out.derivative, &d) < 1e-13);
        }
    }

    #[test]
    fn analytic_cut_off_takes_the_upper_tone() {
        let t: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        let tone = |f: f64| -> Vec<f64> {
            t.iter()
                .map(|t| (2.0 * std::f64::consts::PI * f * t).sin())
                .collect()
        };
        let y: Vec<f64> = tone(2.0)
            .iter()
            .zip(tone(20.0))
            .map(|(a, b)| a + b)
            .collect();
        let s = Spectral::new(Ends::Periodic, Cutoff::Frequency(2.0)).unwrap();
        // Rounding.
        assert!(rms(&s.apply(&t, &y).unwrap().value, &tone(2.0)) < 1e-14);
    }

    #[test]
    fn prop_cross_validated_cut_off_on_noise() {
        let n = 2000;
        let t: Vec<f64> = (0..n).map(|i| 0.01 * i as f64).collect();
        let y: Vec<f64> = t
            .iter()
            .zip(gauss(7, n))
            .map(|(t, e)| (1.3 * t).sin() + 0.3 * t + 0.1 * e)
            .collect();
        let d: Vec<f64> = t.iter().map(|t| 1.3 * (1.3 * t).cos() + 0.3).collect();
        let s = Spectral::new(Ends::Reflected, Cutoff::CrossValidated).unwrap();
        let out = s.apply(&t, &y).unwrap();
        let inner = 200..n - 200;
        // Differences would err by 7. Some 20 harmonics pass: the noise in the slope is about
        // 0.1 √(2·20/2000) of the value times 2 per unit of time.
        assert!(rms(&out.derivative[inner.clone()], &d[inner]) < 0.1);
    }

    #[test]
    fn prop_bad_input_is_named() {
        assert!(Spectral::new(Ends::Periodic, Cutoff::Frequency(-1.0)).is_err());
        let s = Spectral::new(Ends::Reflected, Cutoff::None).unwrap();
        assert!(matches!(
            s.apply(&[0.0, 1.0, 2.0, 4.0], &[0.0; 4]),
            Err(SindyError::Setting { key: "time", .. })
        ));
        assert!(matches!(
            s.apply(&[0.0, 1.0], &[0.0; 2]),
            Err(SindyError::TooShort { .. })
        ));
        let out = s
            .apply(&[0.0, 1.0, 2.0, 3.0], &[1.0, 3.0, 5.0, 7.0])
            .unwrap();
        assert!(out.derivative.iter().all(|d| (d - 2.0).abs() < 1e-14));
    }
}
