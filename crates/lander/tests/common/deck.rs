//! Known motions of a deck, and how well they are predicted.
#![allow(dead_code, reason = "each user takes its own part")]

use touchdown_flight::Real;
use touchdown_lander::estimate::deck::{DeckEstimator, DeckEstimatorState, Observed};

use super::noise::Noise;

/// Time between readings, s.
pub const DT: f64 = 0.01;

/// A sum of sines: amplitude, angular frequency, phase.
pub struct Sines(pub Vec<[f64; 3]>);

impl Sines {
    /// Displacement, velocity, acceleration.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &[a, w, phase] in &self.0 {
            let (sin, cos) = (w * t + phase).sin_cos();
            sum[0] += a * sin;
            sum[1] += a * w * cos;
            sum[2] -= a * w * w * sin;
        }
        sum
    }

    /// JONSWAP with the peak period, the significant height and γ = 3.3 (Hasselmann
    /// et al. 1973), 80 frequencies with random phases.
    pub fn jonswap(height_m: f64, period_s: f64, seed: u64) -> Self {
        let peak = std::f64::consts::TAU / period_s;
        let mut noise = Noise::new(seed);
        let n = 80;
        let (low, high) = (0.5 * peak, 3.0 * peak);
        let dw = (high - low) / f64::from(n);
        let mut all: Vec<[f64; 3]> = (0..n)
            .map(|k| {
                let w = low + (f64::from(k) + noise.uniform()) * dw;
                let width = if w < peak { 0.07 } else { 0.09 };
                let bump = (-(w / peak - 1.0).powi(2) / (2.0 * width * width)).exp();
                let density = w.powi(-5) * (-1.25 * (peak / w).powi(4)).exp() * 3.3_f64.powf(bump);
                [
                    (2.0 * density * dw).sqrt(),
                    w,
                    std::f64::consts::TAU * noise.uniform(),
                ]
            })
            .collect();
        // Significant height: four standard deviations.
        let variance: f64 = all.iter().map(|[a, ..]| 0.5 * a * a).sum();
        let scale = 0.25 * height_m / variance.sqrt();
        for sine in &mut all {
            sine[0] *= scale;
        }
        Self(all)
    }
}

/// The paper's deck: 0.05 m at 0.5 Hz.
pub fn paper_deck(phase: f64) -> Sines {
    Sines(vec![[0.05, std::f64::consts::PI, phase]])
}

/// Predictions of displacement, velocity and acceleration against truth.
#[derive(Default)]
pub struct Score {
    pub count: f64,
    pub error2: [f64; 3],
    pub truth2: [f64; 3],
    pub inside: [f64; 3],
}

impl Score {
    /// Root mean square of the errors over that of the motion.
    pub fn relative(&self) -> [f64; 3] {
        std::array::from_fn(|k| (self.error2[k] / self.truth2[k]).sqrt())
    }

    /// Root mean square of the errors.
    pub fn rms(&self) -> [f64; 3] {
        self.error2.map(|e| (e / self.count).sqrt())
    }

    /// Share of the truth within 1.96 standard deviations.
    pub fn coverage(&self) -> [f64; 3] {
        self.inside.map(|n| n / self.count)
    }
}

/// Feeds noisy readings (displacement with a constant of 0.7 m) until a time and
/// scores predictions from a time on.
pub fn run<R: Real>(
    estimator: &DeckEstimator<R>,
    deck: &Sines,
    seed: u64,
    span_s: [f64; 2],
    horizon_s: f64,
    score: &mut Score,
) -> DeckEstimatorState<R> {
    let mut state = estimator.initial();
    let mut noise = Noise::new(seed);
    for step in 0..(span_s[1] / DT) as u32 {
        let t = f64::from(step) * DT;
        let truth = deck.at(t - estimator.delay_s.to_f64());
        let y = match estimator.observed {
            Observed::Displacement => truth[0] + 0.7,
            Observed::Velocity => truth[1],
        };
        let y = y + estimator.measurement_sd.to_f64() * noise.normal();
        estimator.step(&mut state, Some(R::from_f64(y)), R::from_f64(DT));
        if t < span_s[0] {
            continue;
        }
        let p = estimator.predict(&state, R::from_f64(horizon_s));
        let then = deck.at(t + horizon_s);
        let mean = [p.displacement_m, p.velocity_mps, p.acceleration_mps2];
        let sd = [
            p.displacement_sd_m,
            p.velocity_sd_mps,
            p.acceleration_sd_mps2,
        ];
        score.count += 1.0;
        for k in 0..3 {
            let error = mean[k].to_f64() - then[k];
            score.error2[k] += error * error;
            score.truth2[k] += then[k] * then[k];
            score.inside[k] += f64::from(error.abs() < 1.96 * sd[k].to_f64());
        }
    }
    state
}
