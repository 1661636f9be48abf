//! The fit, each part beside a reference in the same run: `cargo bench -p sindy`.
//!
//! Prints the median time of ours and of the reference, and their ratio.

#![allow(clippy::print_stdout, missing_docs)]

use std::hint::black_box;
use std::time::Instant;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use sindy::sr3::{Path, Scaling};
use sindy::{Gram, Library, Samples, Sr3};

const ROWS: usize = 100_000;
const TERMS: [&str; 11] = [
    "1", "f", "s", "z", "v_p", "v_q", "s^2", "v_p*v_q", "z^2", "v_p^2", "v_q^2",
];

fn main() {
    let samples = data();
    let library = Library::parse(&TERMS).unwrap();
    compare(
        "library and Gram matrix, 11 terms, 100 000 rows, against a stored library (nalgebra)",
        || {
            black_box(Gram::accumulate(&library, "y", &samples).unwrap());
        },
        || {
            black_box(stored(&samples));
        },
    );
    let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
    // A threshold of 0.05, and ν where SR3 comes near to refitted least squares: 1/300 of the Gram diagonal.
    let nu = 1e-7;
    let sr3 = Sr3::new(0.05 * 0.05 / (2.0 * nu), nu)
        .unwrap()
        .scaling(Scaling::None);
    compare(
        "SR3 on that Gram matrix, fixed point, against the alternating iteration to convergence",
        || {
            black_box(sr3.solve(&gram));
        },
        || {
            black_box(sr3.path(Path::Relaxation, 1_000_000).solve(&gram));
        },
    );
}

fn data() -> Samples {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
    let mut samples = Samples::new(&["f", "s", "z", "v_p", "v_q", "y"]);
    let mut columns: Vec<Vec<f64>> = (0..5)
        .map(|_| (0..ROWS).map(|_| rng.random_range(-1.0..1.0)).collect())
        .collect();
    let y = (0..ROWS)
        .map(|i| 0.8 - 0.1 * columns[0][i] + columns[3][i] - 2.5 * columns[2][i].powi(2))
        .map(|v: f64| v + rng.random_range(-0.1..0.1))
        .collect();
    columns.push(y);
    samples.push_group(columns).unwrap();
    samples
}

/// The textbook way: build Θ, then multiply.
fn stored(samples: &Samples) -> (DMatrix<f64>, DVector<f64>) {
    let [f, s, z, p, q, y] = samples.group(0) else {
        unreachable!("six columns")
    };
    let theta = DMatrix::from_fn(ROWS, 11, |i, j| match j {
        0 => 1.0,
        1 => f[i],
        2 => s[i],
        3 => z[i],
        4 => p[i],
        5 => q[i],
        6 => s[i] * s[i],
        7 => p[i] * q[i],
        8 => z[i] * z[i],
        9 => p[i] * p[i],
        _ => q[i] * q[i],
    });
    (
        theta.tr_mul(&theta),
        theta.tr_mul(&DVector::from_column_slice(y)),
    )
}

fn compare(name: &str, mut ours: impl FnMut(), mut reference: impl FnMut()) {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for _ in 0..15 {
        a.push(seconds(&mut ours));
        b.push(seconds(&mut reference));
    }
    let median = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    let (a, b) = (median(&mut a), median(&mut b));
    println!(
        "{name}\n  ours {:.3} ms, reference {:.3} ms, ratio {:.1}",
        1e3 * a,
        1e3 * b,
        b / a
    );
}

fn seconds(work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
