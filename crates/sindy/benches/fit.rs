//! The fit, each part beside a reference in the same run: `cargo bench -p sindy`.
//!
//! Prints the median time of ours and of the reference, and their ratio.

#![allow(clippy::print_stdout, missing_docs)]

use std::hint::black_box;
use std::time::Instant;

use nalgebra::{DMatrix, DMatrixView, DVector};
use rand::{RngExt, SeedableRng};
use sindy::solve::sr3::{Path, Scaling};
use sindy::{Gram, Library, Samples, Sr3};

const ROWS: usize = 100_000;
const TERMS: [&str; 11] = [
    "1", "f", "s", "z", "v_p", "v_q", "s^2", "v_p*v_q", "z^2", "v_p^2", "v_q^2",
];

fn main() {
    lorenz();
    let samples = data();
    let library = Library::parse(&TERMS).unwrap();
    compare(
        15,
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
        15,
        "SR3 on that Gram matrix, fixed point, against the alternating iteration to convergence",
        || {
            black_box(sr3.solve(&gram));
        },
        || {
            black_box(sr3.path(Path::Relaxation, 1_000_000).solve(&gram));
        },
    );
}

/// 56 terms, 10^6 rows: the library evaluated and multiplied in one pass that stores no Θ, against the
/// product of a Θ that is already there.
fn lorenz() {
    const ROWS: usize = 1_000_000;
    let mut state = [-8.0, 7.0, 27.0];
    let mut columns = vec![Vec::new(); 4];
    let slope = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let moved = |s: [f64; 3], d: [f64; 3], dt: f64| [0, 1, 2].map(|i| s[i] + dt * d[i]);
    for _ in 0..ROWS {
        let rate = slope(state);
        for (column, value) in columns.iter_mut().zip(state.iter().chain(&rate[..1])) {
            column.push(*value);
        }
        state = moved(state, slope(moved(state, rate, 0.001)), 0.002);
    }
    let mut terms = Vec::new();
    for degree in 0..=5 {
        for i in (0..=degree).rev() {
            for j in (0..=degree - i).rev() {
                let powers = [("x", i), ("y", j), ("z", degree - i - j)];
                let factors: Vec<String> = powers
                    .iter()
                    .filter(|(_, n)| *n > 0)
                    .map(|(name, n)| format!("{name}^{n}"))
                    .collect();
                terms.push(factors.join("*"));
            }
        }
    }
    terms[0] = "1".into();
    let library = Library::parse(&terms).unwrap();
    let mut theta = vec![0.0; ROWS * terms.len()];
    let names = ["x", "y", "z"].map(String::from);
    let inputs: Vec<&[f64]> = columns[..3].iter().map(Vec::as_slice).collect();
    library
        .compile(&names)
        .unwrap()
        .eval_block(&inputs, &mut theta, &mut Default::default());
    let mut samples = Samples::new(&["x", "y", "z", "x_dot"]);
    samples.push_group(columns).unwrap();
    let p = terms.len();
    // nalgebra multiplies a transposed view of Θ by its blocked kernel; `tr_mul` would be slower.
    let left = DMatrixView::from_slice_with_strides(&theta, p, ROWS, ROWS, 1);
    let right = DMatrixView::from_slice(&theta, ROWS, p);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        compare(
            5,
            &format!(
                "library and Gram matrix, {p} terms, 10^6 rows, {threads} thread(s), against the product alone (nalgebra)"
            ),
            || {
                pool.install(|| {
                    black_box(Gram::accumulate(&library, "x_dot", &samples).unwrap());
                });
            },
            || {
                black_box(left * right);
            },
        );
    }
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

fn compare(runs: usize, name: &str, mut ours: impl FnMut(), mut reference: impl FnMut()) {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for _ in 0..runs {
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
