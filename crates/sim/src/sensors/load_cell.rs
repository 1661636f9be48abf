//! The load cell of the force rig.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::random::Stream;

/// The load cell under the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LoadCellSettings {
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// White noise, standard deviation, N.
    pub noise_sd_n: f64,
    /// Resolution, N (0.1 gram-force by default; 0 for none).
    pub quantum_n: f64,
    /// Range: readings are limited to ± this force, N.
    pub range_n: f64,
    /// Latency of every sample, s.
    pub latency_s: f64,
    /// Scale of the additional half-normal latency, s.
    pub jitter_s: f64,
    /// Share of lost samples, each of which is a gap in the record.
    pub loss_share: f64,
}

impl Default for LoadCellSettings {
    fn default() -> Self {
        Self {
            rate_hz: 100.0,
            noise_sd_n: 0.03,
            quantum_n: 9.806_65e-4,
            range_n: 196.0,
            latency_s: 0.02,
            jitter_s: 0.005,
            loss_share: 0.0,
        }
    }
}

impl LoadCellSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// The rate lies in 1..1000 Hz, the range is positive, ages are 0..1 s and
    /// the loss share is below 1.
    pub fn validate(&self) -> Result<(), SimError> {
        check::within("rate_hz", self.rate_hz, 1.0, 1.0 / crate::STEP_S)?;
        check::not_negative("noise_sd_n", self.noise_sd_n)?;
        check::not_negative("quantum_n", self.quantum_n)?;
        check::positive("range_n", self.range_n)?;
        check::within("latency_s", self.latency_s, 0.0, 1.0)?;
        check::within("jitter_s", self.jitter_s, 0.0, 1.0)?;
        check::within("loss_share", self.loss_share, 0.0, 0.99)
    }

    /// Age of the next sample, s.
    pub(crate) fn age_s(&self, stream: &mut Stream) -> f64 {
        self.latency_s + self.jitter_s * stream.normal().abs()
    }

    /// Reading of a force, or a gap (NaN) if the sample is lost.
    pub(crate) fn read(&self, force_n: f64, stream: &mut Stream) -> f64 {
        let noisy = force_n + self.noise_sd_n * stream.normal();
        let lost = stream.uniform() < self.loss_share;
        let held = noisy.clamp(-self.range_n, self.range_n);
        if lost {
            f64::NAN
        } else if self.quantum_n > 0.0 {
            (held / self.quantum_n).round() * self.quantum_n
        } else {
            held
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    #[test]
    fn analytic_load_cell_noise_quantum_range_and_losses() {
        let mut stream = Stream::new(1, 1, Purpose::Sensor);
        let cell = LoadCellSettings {
            loss_share: 0.1,
            ..LoadCellSettings::default()
        };
        let values: Vec<f64> = (0..20_000).map(|_| cell.read(10.0, &mut stream)).collect();
        let read: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
        // Binomial: 2000 ± 42; five standard deviations.
        assert!((values.len() - read.len()).abs_diff(2000) < 210);
        let mean = read.iter().sum::<f64>() / read.len() as f64;
        let sd = (read.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / read.len() as f64).sqrt();
        // Standard error of the mean 0.03/√18000 = 2.2e-4, of the sd 1.6e-4.
        assert!((mean - 10.0).abs() < 1.1e-3 && (sd - 0.03).abs() < 8e-4);
        for value in read.iter().take(100) {
            let quanta = value / cell.quantum_n;
            // Rounding of a quotient of about 1e4.
            assert!((quanta - quanta.round()).abs() < 1e-9);
        }
        // A quantum of the range may be cut by rounding to whole quanta.
        assert!((cell.read(500.0, &mut Stream::new(9, 1, Purpose::Sensor)) - 196.0).abs() < 1e-3);
    }

    #[test]
    fn analytic_age_is_latency_and_half_normal_jitter() {
        let mut stream = Stream::new(1, 2, Purpose::Sensor);
        let cell = LoadCellSettings::default();
        let ages: Vec<f64> = (0..20_000).map(|_| cell.age_s(&mut stream)).collect();
        let mean = ages.iter().sum::<f64>() / ages.len() as f64;
        // Mean of a half-normal: scale √(2/π) = 3.99 ms; error 3 ms/√20000, 5 of them.
        assert!((mean - 0.02 - 0.003_989).abs() < 1.1e-4, "{mean}");
        assert!(ages.iter().all(|&age| age >= 0.02));
    }
}
