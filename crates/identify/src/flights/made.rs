//! A made flight for tests.

use super::drift::Drift;
use super::model::Segment;

/// Hover up and down over the ground for 8 s at 100 Hz, with a force of height and time.
pub(super) fn up_and_down(flight: usize, force: impl Fn(f64, f64) -> f64) -> Segment {
    let rows = 800;
    let time_s: Vec<f64> = (0..800).map(|i| 0.01 * f64::from(i)).collect();
    let pace = 3.0 + 0.7 * flight as f64;
    let height: Vec<f64> = time_s
        .iter()
        .map(|t| 1.2 - 0.7 * (pace * t).cos())
        .collect();
    let both = height.iter().zip(&time_s);
    Segment {
        flight,
        run: 0,
        throttle: vec![1.0; rows],
        logged_throttle: Vec::new(),
        range_m: height.clone(),
        climb_mps: vec![0.0; rows],
        drift: Drift::Unknown,
        on_s: Some(0.0),
        force: both.map(|(h, t)| force(*h, *t)).collect(),
        height,
        accelerometer: true,
        climb_measured_mps: Vec::new(),
        tilt_rad: Vec::new(),
        rows: (0..rows).collect(),
        bias_sd: 0.1,
        time_s,
    }
}
