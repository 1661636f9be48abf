//! Nanoseconds per sample of the differentiators, and Savitzky–Golay beside the plain loop.
//!
//! `cargo bench -p sindy --bench derivative`. Medians of 7 runs in one thread, wall time.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use sindy::SavitzkyGolay;
use sindy::derivative::{
    Cutoff, Differentiator, Ends, FiniteDifference, KalmanSmoother, Motion, SavgolSearch,
    SmoothingSpline, Spectral, choose_savgol,
};

const LONG: usize = 3_000_000;
const SHORT: usize = 200_000;

fn main() -> Result<(), sindy::SindyError> {
    let time: Vec<f64> = (0..LONG).map(|i| 0.001 * i as f64).collect();
    let noise = |i: usize| ((i as f64).powi(2) * 0.37).sin();
    let y: Vec<f64> = (0..LONG).map(|i| time[i].sin() + 0.05 * noise(i)).collect();
    let uneven: Vec<f64> = (0..LONG)
        .map(|i| time[i] + 2e-4 * (i as f64).sin())
        .collect();

    for (window, degree) in [(11, 3), (31, 4), (101, 4)] {
        let filter = SavitzkyGolay::new(window, degree)?;
        let ours = per_sample(LONG, || black_box(filter.apply(&time, &y)).is_ok());
        let mut out = filter.apply(&time, &y)?;
        let again = per_sample(LONG, || {
            black_box(filter.apply_into(&time, &y, &mut out)).is_ok()
        });
        let weights = central(window, degree);
        let plain = per_sample(LONG, || {
            black_box(plain_loop(&weights, &y));
            true
        });
        println!(
            "Savitzky-Golay {window:3} x {degree}, {LONG}: {ours:6.2} ns, columns used again {again:6.2} ns, plain loop {plain:6.2} ns (its columns fresh)"
        );
    }
    let methods: [(&str, Differentiator); 7] = [
        (
            "finite differences, order 4",
            FiniteDifference::new(4)?.into(),
        ),
        ("Savitzky-Golay 31 x 4", SavitzkyGolay::new(31, 4)?.into()),
        ("smoothing spline", SmoothingSpline::new(1e-6)?.into()),
        (
            "smoothing spline, cross-validated",
            SmoothingSpline::cross_validated().into(),
        ),
        (
            "Kalman",
            KalmanSmoother::new(Motion::ConstantAcceleration, 1e6)?.into(),
        ),
        (
            "Kalman, maximum likelihood",
            KalmanSmoother::maximum_likelihood(Motion::ConstantAcceleration).into(),
        ),
        (
            "spectral",
            Spectral::new(Ends::Reflected, Cutoff::CrossValidated)?.into(),
        ),
    ];
    for (name, method) in methods {
        let run = |time: &[f64]| {
            per_sample(SHORT, || {
                black_box(method.apply(&time[..SHORT], &y[..SHORT])).is_ok()
            })
        };
        print!("{name}, {SHORT}: uniform {:.1} ns", run(&time));
        match method {
            Differentiator::Spectral(_) => println!(),
            _ => println!(", non-uniform {:.1} ns", run(&uneven)),
        }
    }
    for n in [5000, LONG] {
        let search = SavgolSearch::default();
        let series = [(&time[..n], &y[..n])];
        let cost = per_sample(n, || black_box(choose_savgol(&series, &search)).is_ok());
        println!("window chosen, {n}: {:.1} ms", cost * n as f64 * 1e-6);
    }
    Ok(())
}

/// Median time of `work` per sample, in ns.
fn per_sample(samples: usize, mut work: impl FnMut() -> bool) -> f64 {
    let mut times: Vec<f64> = (0..7)
        .map(|_| {
            let start = Instant::now();
            assert!(work());
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[3] * 1e9 / samples as f64
}

/// The filter's weights at its centre, from unit impulses.
fn central(window: usize, degree: usize) -> [Vec<f64>; 2] {
    let filter = SavitzkyGolay::new(window, degree).expect("a valid filter");
    let time: Vec<f64> = (0..window).map(|i| 0.001 * i as f64).collect();
    let mut weights = [Vec::new(), Vec::new()];
    for k in 0..window {
        let mut impulse = vec![0.0; window];
        impulse[k] = 1.0;
        let out = filter.apply(&time, &impulse).expect("a whole window");
        weights[0].push(out.value[window / 2]);
        weights[1].push(out.derivative[window / 2]);
    }
    weights
}

/// A dot product per sample for the value and one for the slope.
fn plain_loop(weights: &[Vec<f64>; 2], y: &[f64]) -> [Vec<f64>; 2] {
    let w = weights[0].len();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut out = [vec![0.0; y.len()], vec![0.0; y.len()]];
    for (i, part) in y.windows(w).enumerate() {
        out[0][i + w / 2] = dot(&weights[0], part);
        out[1][i + w / 2] = dot(&weights[1], part);
    }
    out
}
