//! Synthetic logs of a thrust stand, for tests.

use touchdown_trial::Trial;

/// A log at 100 Hz. The root of thrust follows `root(s, t)` of throttle and time with a lag of 0.06 s, and `measured(T, t)` is what the
/// load cell shows of it, with noise of up to 0.02 N.
pub(super) fn log(
    rows: u32,
    throttle: impl Fn(f64) -> f64,
    root: impl Fn(f64, f64) -> f64,
    measured: impl Fn(f64, f64) -> f64,
) -> Trial {
    let (mut time, mut throttles, mut thrust) = (Vec::new(), Vec::new(), Vec::new());
    let mut x = 2.0;
    for i in 0..rows {
        let t = 0.01 * f64::from(i);
        let s = throttle(t);
        x += (root(s, t) - x) * (1.0 - (-0.01_f64 / 0.06).exp());
        // Squares modulo a prime repeat with no step of the throttle.
        let noise_n = 0.02 * (2.4 * f64::from(i * i % 1009)).sin();
        time.push(t);
        throttles.push(s);
        thrust.push(measured(x * x + noise_n, t));
    }
    let trial = Trial::new("t", time).unwrap();
    let trial = trial.with_channel("throttle", throttles).unwrap();
    trial.with_channel("thrust_n", thrust).unwrap()
}

/// Steps of a second between eleven throttles from 0.25 to 0.85.
pub(super) fn steps(t: f64) -> f64 {
    0.25 + 0.06 * f64::from((7 * (t + 1e-9) as u32) % 11)
}
