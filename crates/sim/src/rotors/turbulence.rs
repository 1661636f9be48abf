//! Turbulent forces on four rotors.

use crate::noise::Stream;

/// Correlation of the turbulent forces on two rotors (an assumption).
pub const TURBULENCE_CORRELATION: f64 = 0.5;

/// Turbulent forces on four rotors: the process of [`Turbulence`] for each,
/// driven by noise that is partly common.
///
/// [`Turbulence`]: crate::noise::Turbulence
#[derive(Clone, Debug)]
pub struct RotorTurbulence {
    stream: Stream,
    decay: f64,
    gain: f64,
    values_n: [f64; 4],
}

impl RotorTurbulence {
    /// Stationary processes of the correlation time τ, stepped by `step_s`.
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

    /// What is left of a force after a step, and what noise of a standard deviation of 1 adds.
    pub(crate) fn decay_and_gain(correlation_s: f64, step_s: f64) -> (f64, f64) {
        let decay = (-step_s / correlation_s).exp();
        (decay, (1.0 - decay * decay).sqrt())
    }

    /// The noise of the next step, for one who takes the forces on himself.
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

    /// The forces now, N.
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
