//! Ten million rows in one pass: blocks come from an iterator, are differentiated, added up and forgotten.
//!
//! More rows do not help for ever: the error levels off at 1.1e-3, and at 1.7e-4 with `NOISE` set to zero. That
//! is bias, of noise that passes through the terms and of the filter.
//!
//! `cargo run --release -p sindy --example 07_streaming [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use sindy::solve::sr3::Scaling;
use sindy::{Gram, OwnedBlock, SavitzkyGolay, SindyError, Solver, Stlsq, Stream, problems};
use touchdown_report::{Color, Figure, Panel, Series};

/// Blocks, and rows in each.
const BLOCKS: usize = 2000;
const ROWS: usize = 5000;
/// Time from one row to the next.
const STEP: f64 = 0.002;
/// Standard deviation of the noise.
const NOISE: f64 = 0.2;

fn slope([x, y, z]: [f64; 3]) -> [f64; 3] {
    [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z]
}

/// One step of the classical Runge–Kutta method.
fn step(s: [f64; 3]) -> [f64; 3] {
    let ahead = |k: [f64; 3], h: f64| [s[0] + h * k[0], s[1] + h * k[1], s[2] + h * k[2]];
    let a = slope(s);
    let b = slope(ahead(a, 0.5 * STEP));
    let c = slope(ahead(b, 0.5 * STEP));
    let d = slope(ahead(c, STEP));
    [0, 1, 2].map(|i| s[i] + STEP / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}

/// The measurements as they come in: here simulated, elsewhere read from a file.
fn blocks() -> impl Iterator<Item = Result<OwnedBlock, SindyError>> {
    let mut random = rand_pcg::Pcg64::seed_from_u64(1);
    let mut state = [-8.0, 7.0, 27.0];
    let time: Vec<f64> = (0..ROWS).map(|k| k as f64 * STEP).collect();
    (0..BLOCKS).map(move |group| {
        let mut measured = [0, 1, 2].map(|_| Vec::with_capacity(ROWS));
        for _ in 0..ROWS {
            for (column, value) in measured.iter_mut().zip(state) {
                let noise: f64 = StandardNormal.sample(&mut random);
                column.push(value + NOISE * noise);
            }
            state = step(state);
        }
        // Each block is smoothed by itself; its ends, where windows are one-sided, are left out.
        let filter = SavitzkyGolay::new(25, 4)?;
        let (mut columns, mut slopes) = (Vec::new(), Vec::new());
        for x in &measured {
            let smooth = filter.apply(&time, x)?;
            columns.push(smooth.value[12..ROWS - 12].to_vec());
            slopes.push(smooth.derivative[12..ROWS - 12].to_vec());
        }
        Ok(OwnedBlock {
            group,
            columns: [columns, slopes].concat(),
        })
    })
}

/// The relative error of all coefficients.
fn error(truth: &[Vec<f64>], found: &[Vec<f64>]) -> f64 {
    let pairs = || truth.iter().flatten().zip(found.iter().flatten());
    let wrong: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
    let size: f64 = pairs().map(|(a, _)| a * a).sum();
    (wrong / size).sqrt()
}

fn main() -> Result<(), Box<dyn Error>> {
    let problem = problems::lorenz();
    let (library, truth) = (problem.library()?, problem.coefficients());
    let targets = ["x_dot", "y_dot", "z_dot"];
    let source = Stream::new(
        &["x", "y", "z", "x_dot", "y_dot", "z_dot"],
        BLOCKS,
        blocks(),
    );
    // One pass: statistics of all three equations, one set for each block.
    let parts = Gram::accumulate_targets(&library, &targets, &source)?;

    let solver = Stlsq::new(0.1, 0.0)?.scaling(Scaling::None);
    let mut sums = [0, 1, 2].map(|_| Gram::zeros(library.len()));
    let (mut rows, mut errors) = (Vec::new(), Vec::new());
    for k in 0..BLOCKS {
        let mut found = Vec::new();
        for (sum, parts) in sums.iter_mut().zip(&parts) {
            sum.merge(&parts[k]);
            found.push(solver.fit(sum)?.coefficients.as_slice().to_vec());
        }
        rows.push(sums[0].rows as f64);
        errors.push(error(&truth, &found));
        if [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000].contains(&(k + 1)) {
            println!("{:>10} rows: error {:.2e}", sums[0].rows, errors[k]);
        }
    }
    let megabytes = (rows[BLOCKS - 1] * 6.0 * 8.0) / 1e6;
    println!(
        "\n{megabytes:.0} MB of columns went through; one block of {:.1} MB was held\n",
        ROWS as f64 * 48e-6
    );

    let picture = Figure::new("07_streaming", "Lorenz: the error as blocks are added").panel(
        Panel::new("rows so far", "relative error of the coefficients")
            .log_x()
            .log_y()
            .series(Series::line("found", &rows, &errors).color(Color::Cycle(0))),
    );
    figure::save(&picture)
}
