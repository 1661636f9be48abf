//! Climb rates from heights, climb rates and accelerations together: all are measurements of one motion.
//!
//! Climb damping and the wake's lag are confounded near the ground, so a bias of one is a bias of the other. Two
//! things bias a coefficient of the climb rate:
//!
//! - noise in it, which pulls the coefficient to zero (errors in variables; W. A. Fuller, "Measurement Error Models",
//!   1987). So all measurements count, each with its own noise;
//! - smoothing over what comes after. A disturbance accelerates the vehicle, and a climb rate that holds some of that
//!   acceleration is correlated with the very force that is to be explained. So a Kalman filter looks back only.

use nalgebra::{Matrix3, Vector3};

/// Rows between what a climb rate is made of and its own.
/// One lets noise of the very force that is to be explained into the climb rate; more make it older than need be.
const BEHIND: usize = 2;
/// Vertical acceleration where none was measured, standard deviation (m/s²).
/// Half a gravity covers what multirotors do without an accelerometer that shows it.
const UNKNOWN_MPS2: f64 = 5.0;
/// What accelerometers miss of the vertical motion: a walk of the climb rate (m/s/√s) and of their own error (m/s²/√s).
/// Vibration and rounding; with it, a climb rate of 0.02 m/s noise is known to 0.005 m/s (Riccati).
const ROUGH: f64 = 0.02;
/// A bias that walks by 0.16 m/s² in ten seconds, as cheap accelerometers do while they warm up.
const WANDER: f64 = 0.05;
/// The climb rate (m/s) at every row with a climb rate or, without those, a height; NaN elsewhere. `measured` are height
/// and climb rate, one of which may be empty.
///
/// Kalman filter of height, climb rate and the accelerometer's error. A row's climb rate comes from what was measured
/// up to [`BEHIND`] rows before it.
pub(super) fn climb(time: &[f64], measured: [&[f64]; 2], acceleration: &[f64]) -> Vec<f64> {
    let variances = measured.map(|m| noise(m).powi(2));
    let of_acceleration = noise(acceleration).powi(2);
    let mut mean = Vector3::zeros();
    let mut sd = Matrix3::from_diagonal(&Vector3::new(1e4, 1e2, 0.25));
    let mut past: [(f64, f64, f64); BEHIND] = [(f64::NAN, f64::NAN, 0.0); BEHIND];
    let mut out = Vec::with_capacity(time.len());
    for i in 0..time.len() {
        if i > 0 {
            let dt = time[i] - time[i - 1];
            let (a, spread) = match acceleration[i - 1] {
                a if a.is_finite() => (a, of_acceleration),
                _ => (0.0, UNKNOWN_MPS2.powi(2)),
            };
            let step = Matrix3::new(1.0, dt, 0.5 * dt * dt, 0.0, 1.0, dt, 0.0, 0.0, 1.0);
            mean = step * mean + a * Vector3::new(0.5 * dt * dt, dt, 0.0);
            sd = step * sd * step.transpose();
            sd[(1, 1)] += spread * dt * dt + ROUGH.powi(2) * dt;
            sd[(2, 2)] += WANDER.powi(2) * dt;
        }
        for (k, (values, variance)) in measured.iter().zip(variances).enumerate() {
            let Some(value) = values.get(i).filter(|v| v.is_finite()) else {
                continue;
            };
            let gain = sd.column(k) / (sd[(k, k)] + variance);
            mean += gain * (value - mean[k]);
            sd -= gain * sd.row(k).into_owned();
            sd = 0.5 * (sd + sd.transpose());
        }
        let known = measured
            .iter()
            .rfind(|m| !m.is_empty())
            .is_some_and(|m| m[i].is_finite());
        let (then, speed, a) = past[i % BEHIND];
        let ahead = speed + a * (time[i] - then);
        out.push(match known {
            true if ahead.is_finite() => ahead,
            true => mean.y,
            false => f64::NAN,
        });
        let a = acceleration[i] + mean.z;
        past[i % BEHIND] = (time[i], mean.y, if a.is_finite() { a } else { 0.0 });
    }
    out
}

/// Standard deviation of the noise of a channel, by its third differences (which a motion that is smooth over four rows
/// leaves at 20 times the noise's variance); a channel without noise is as good as its last digit.
fn noise(values: &[f64]) -> f64 {
    let third = values
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2));
    let (n, sum) = third
        .filter(|d| d.is_finite())
        .fold((0.0, 0.0), |(n, sum), d| (n + 1.0, sum + d));
    (sum / f64::max(n, 1.0) / 20.0).sqrt().max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution as _, StandardNormal};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng as _;

    fn time() -> Vec<f64> {
        (0..2000).map(|i| 0.004 * f64::from(i)).collect()
    }

    /// A motion of 0.1 m/s at 8 rad/s with noise of 0.02 m/s and 0.15 m/s², and an accelerometer that is 0.2 m/s² off.
    fn noisy() -> (Vec<f64>, [Vec<f64>; 3]) {
        let mut random = Pcg64::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let time = time();
        let measured = time
            .iter()
            .map(|t| {
                [
                    0.1 * (8.0 * t).sin(),
                    0.1 * (8.0 * t).sin() + 0.02 * normal(),
                    0.8 * (8.0 * t).cos() + 0.2 + 0.15 * normal(),
                ]
            })
            .collect::<Vec<_>>();
        let column = |k: usize| measured.iter().map(|m| m[k]).collect();
        (time, [column(0), column(1), column(2)])
    }

    #[test]
    fn analytic_accelerations_take_the_noise_off_a_climb_rate() {
        let (time, [truth, measured, up]) = noisy();
        let found = climb(&time, [&[], &measured], &up);
        let error = |v: &[f64]| -> f64 {
            let settled = v.iter().zip(&truth).skip(500);
            (settled.map(|(v, t)| (v - t).powi(2)).sum::<f64>() / 1500.0).sqrt()
        };
        // Riccati: noise of 0.02 m/s with a walk of 0.021 m/s a root second leaves √(0.02 × 0.021 × √0.004) = 0.005.
        assert!(error(&found) < 0.008, "{}", error(&found));
        assert!(error(&measured) > 0.018);
    }

    #[test]
    fn prop_a_climb_rate_knows_nothing_of_what_comes_after() {
        let (time, [_, measured, up]) = noisy();
        let whole = climb(&time, [&[], &measured], &up);
        let mut later = up.clone();
        later[999] += 3.0;
        let moved = climb(&time, [&[], &measured], &later);
        // The noise of the whole record is estimated with a single value more: one in 2000, a hundredth of its weight.
        let apart = |i: usize| (moved[i] - whole[i]).abs();
        assert!((0..1000).all(|i| apart(i) < 2e-3), "{}", apart(1000));
        assert!(apart(1002) > 5e-3, "{}", apart(1002));
    }
}
