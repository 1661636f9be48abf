//! Random streams from explicit seeds.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// What a random stream is for. Streams of one trial do not touch each other:
/// switching one source of noise off leaves the draws of the others alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Turbulence in the air.
    Turbulence,
    /// Sensors.
    Sensor,
    /// Spread of vehicles and starts.
    Spread,
    /// Phases of signals.
    Signal,
    /// Waves and windows of a deck's motion.
    Deck,
    /// Gusts.
    Wind,
    /// The camera.
    Camera,
    /// The inertial unit.
    Imu,
    /// The range finder.
    Range,
    /// Satellite navigation.
    Gnss,
    /// The barometer.
    Barometer,
    /// Errors of attitude and rates.
    Attitude,
    /// What is logged beside what the landing computer hears.
    Log,
    /// The deck's broadcast.
    Beacon,
}

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014): mixes all bits.
fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Index of a named trial (FNV-1a), so that a trial's noise does not depend on
/// the other trials of its set.
#[must_use]
pub fn index_of_name(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// The stream of a seed, a trial and a purpose.
#[derive(Clone, Debug)]
pub struct Stream {
    generator: Pcg64,
}

impl Stream {
    /// A stream; equal arguments give equal numbers.
    #[must_use]
    pub fn new(seed: u64, index: u64, purpose: Purpose) -> Self {
        let key = mix(mix(mix(seed) ^ index) ^ purpose as u64);
        let word = |salt: u64| u128::from(mix(key ^ salt));
        Self {
            generator: Pcg64::new(word(1) << 64 | word(2), word(3) << 64 | word(4)),
        }
    }

    /// A number of the normal distribution N(0, 1).
    #[inline]
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.generator)
    }

    /// A number uniform in [0, 1).
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        // The upper 53 bits fill the mantissa.
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_streams_differ_by_seed_index_and_purpose() {
        let first = |seed, index, purpose| Stream::new(seed, index, purpose).uniform();
        let a = first(1, 2, Purpose::Sensor);
        assert_eq!(a, first(1, 2, Purpose::Sensor));
        for other in [
            first(2, 2, Purpose::Sensor),
            first(1, 3, Purpose::Sensor),
            first(2, 1, Purpose::Sensor),
            first(1, 2, Purpose::Turbulence),
        ] {
            assert_ne!(a, other);
        }
    }

    #[test]
    fn analytic_neighbouring_streams_are_not_correlated() {
        let draw = |index| {
            let mut stream = Stream::new(1, index, Purpose::Sensor);
            (0..10_000).map(|_| stream.normal()).collect::<Vec<_>>()
        };
        let (a, b) = (draw(0), draw(1));
        let product: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        // The mean product has a standard deviation of 1/√10000; 4 of them.
        assert!((product / 1e4).abs() < 0.04, "{product}");
        let mean: f64 = a.iter().sum::<f64>() / 1e4;
        assert!(mean.abs() < 0.04, "{mean}");
    }
}
