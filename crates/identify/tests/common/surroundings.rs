//! What is around the vertical vehicle: a ground that heaves, and satellites that tell its climb rate.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;

use super::{GRAVITY_MPS2, Vehicle, normal, uniform};

/// Heave of the ground: three sines about a period, of a generator of its own.
pub(super) struct Ground {
    /// Greatest speed (m/s), angular frequency (rad/s) and phase.
    tones: [[f64; 3]; 3],
}

impl Ground {
    pub(super) fn draw(v: &Vehicle, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed ^ 0x4752_4f55_4e44);
        let amplitude = v.ground_mps * (2.0f64 / 3.0).sqrt();
        Self {
            tones: [0.75, 1.0, 1.3].map(|share| {
                let period_s = share * v.ground_period_s * uniform(&mut random, 0.9, 1.1);
                let rate = std::f64::consts::TAU / period_s;
                [
                    amplitude,
                    rate,
                    uniform(&mut random, 0.0, std::f64::consts::TAU),
                ]
            }),
        }
    }

    pub(super) fn speed_mps(&self, t: f64) -> f64 {
        let of = |[amplitude, rate, phase]: [f64; 3]| amplitude * (rate * t + phase).sin();
        self.tones.map(of).iter().sum()
    }
}

/// A complementary filter of an accelerometer and satellites' velocity, 0.05 m/s of noise at 10 Hz.
pub(super) struct Velocity {
    climb_mps: f64,
    random: Pcg64,
}

impl Velocity {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            climb_mps: 0.0,
            random: Pcg64::seed_from_u64(seed ^ 0x5645_4c4f_4349),
        }
    }

    pub(super) fn step(&mut self, k: usize, true_mps: f64, specific: f64, dt: f64) -> f64 {
        self.climb_mps += dt * (specific - GRAVITY_MPS2);
        if k.is_multiple_of(100) {
            let seen = true_mps + 0.05 * normal(&mut self.random);
            self.climb_mps += 0.1 * (seen - self.climb_mps);
        }
        self.climb_mps
    }
}
