//! Turbulent forces on the vertical vehicle and on four rotors.

use crate::random::Stream;

/// Ornstein–Uhlenbeck process `n' = -n/τ + sd √(2/τ) w`, discretised exactly
/// for a standard deviation that is constant over a step.
#[derive(Clone, Debug)]
pub struct Turbulence {
    stream: Stream,
    decay: f64,
    gain: f64,
    value_n: f64,
}

impl Turbulence {
    /// A process with the correlation time τ and steps of `step_s`. It starts in its
    /// stationary distribution with the standard deviation `sd_n`.
    #[must_use]
    pub fn new(mut stream: Stream, correlation_s: f64, step_s: f64, sd_n: f64) -> Self {
        let decay = (-step_s / correlation_s).exp();
        let value_n = sd_n * stream.normal();
        Self {
            stream,
            decay,
            gain: (1.0 - decay * decay).sqrt(),
            value_n,
        }
    }

    /// The present force, N.
    #[must_use]
    pub fn value_n(&self) -> f64 {
        self.value_n
    }

    /// One step at the standard deviation `sd_n`; returns the new force, N.
    #[inline]
    pub fn step(&mut self, sd_n: f64) -> f64 {
        self.value_n = self.decay * self.value_n + self.gain * sd_n * self.stream.normal();
        self.value_n
    }
}

/// Correlation of the turbulent forces on two rotors, an assumption: eddies are as large as
/// the vehicle, so that half of the variance is common. The variance of the vertical force
/// does not depend on it. A larger value reduces the roll and pitch torques.
pub const TURBULENCE_CORRELATION: f64 = 0.5;

/// Turbulent forces on four rotors: the process of [`Turbulence`] for each,
/// driven by noise that is partly common.
#[derive(Clone, Debug)]
pub struct RotorTurbulence {
    stream: Stream,
    decay: f64,
    gain: f64,
    values_n: [f64; 4],
}

impl RotorTurbulence {
    /// Stationary processes with the correlation time τ and steps of `step_s`.
    #[must_use]
    pub fn new(mut stream: Stream, correlation_s: f64, step_s: f64, sd_n: [f64; 4]) -> Self {
        let noise = Self::noise(&mut stream);
        let (decay, gain) = Self::decay_and_gain(correlation_s, step_s);
        Self {
            stream,
            decay,
            gain,
            values_n: std::array::from_fn(|i| sd_n[i] * noise[i]),
        }
    }

    /// Factors of a step: of the previous force, and of the noise per standard deviation.
    pub(crate) fn decay_and_gain(correlation_s: f64, step_s: f64) -> (f64, f64) {
        let decay = (-step_s / correlation_s).exp();
        (decay, (1.0 - decay * decay).sqrt())
    }

    /// The noise of the next step, for callers that integrate the forces themselves.
    pub(crate) fn draw(&mut self) -> [f64; 4] {
        Self::noise(&mut self.stream)
    }

    /// Four normal numbers, correlated.
    #[inline]
    fn noise(stream: &mut Stream) -> [f64; 4] {
        let common = TURBULENCE_CORRELATION.sqrt() * stream.normal();
        let own = (1.0 - TURBULENCE_CORRELATION).sqrt();
        std::array::from_fn(|_| common + own * stream.normal())
    }

    /// The present forces, N.
    #[must_use]
    pub fn values_n(&self) -> [f64; 4] {
        self.values_n
    }

    /// One step at the standard deviations `sd_n`; returns the new forces, N.
    #[inline]
    pub fn step(&mut self, sd_n: [f64; 4]) -> [f64; 4] {
        let noise = Self::noise(&mut self.stream);
        for i in 0..4 {
            self.values_n[i] = self.decay * self.values_n[i] + self.gain * sd_n[i] * noise[i];
        }
        self.values_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    #[test]
    fn analytic_turbulence_has_its_variance_and_correlation() {
        let stream = Stream::new(3, 0, Purpose::Turbulence);
        let mut process = Turbulence::new(stream, 0.15, 0.001, 0.5);
        let values: Vec<f64> = (0..2_000_000).map(|_| process.step(0.5)).collect();
        let mean_of = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (values.len() - lag) as f64
        };
        // 2000 s hold about 6700 independent samples (2τ each): the relative
        // standard error of a variance is √(2/6700) = 1.7 %; 4 of them.
        assert!((mean_of(0) / 0.25 - 1.0).abs() < 0.07, "{}", mean_of(0));
        let expected = (-1.0_f64).exp();
        assert!((mean_of(150) / mean_of(0) - expected).abs() < 0.07);
    }
}
