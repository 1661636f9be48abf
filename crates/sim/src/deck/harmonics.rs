//! Motions that are sums of sines over five coordinates.

use super::rigid::DeckCoordinates;

/// One frequency: `cosine cos(ω t) + sine sin(ω t)` in each coordinate (surge,
/// sway, heave in m; roll, pitch in rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Angular frequency ω, rad/s.
    pub angular_frequency: f64,
    /// Factors of cos(ω t).
    pub cosine: [f64; 5],
    /// Factors of sin(ω t).
    pub sine: [f64; 5],
}

/// Sum of the harmonics at a time, with its first two derivatives.
#[must_use]
pub(crate) fn at(harmonics: &[Harmonic], time_s: f64) -> DeckCoordinates {
    let mut sum = DeckCoordinates::default();
    for harmonic in harmonics {
        let w = harmonic.angular_frequency;
        let (sin, cos) = (w * time_s).sin_cos();
        for axis in 0..5 {
            let (c, s) = (harmonic.cosine[axis], harmonic.sine[axis]);
            let value = c * cos + s * sin;
            sum.value[axis] += value;
            sum.rate[axis] += w * (s * cos - c * sin);
            sum.acceleration[axis] -= w * w * value;
        }
    }
    sum
}
