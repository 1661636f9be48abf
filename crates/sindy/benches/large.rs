//! Large problems, end to end: `cargo bench -p sindy --bench large [-- library | rows]`.
//!
//! `library`: ten states of Lorenz '96, 286 candidates each, 2000 rows with 0.1 % of noise. `rows`: Lorenz, 10⁶ rows with 1 % of
//! noise, 20 candidates; beside it the same rows in one pass, with the widths of the intervals of both. The memory is the most
//! that the process holds meanwhile, beside the data (on Linux); that of one pass stands in the README of `sindy-cli`.

#![allow(clippy::print_stdout, missing_docs)]

mod memory;

use std::time::Instant;

use memory::{megabytes, reset_peak};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use sindy::identify::stream::Columns;
use sindy::{Dataset, Identification, Identify, Library, Samples};

fn main() {
    let only: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |name: &str| {
        let named = only.iter().any(|a| a == "library" || a == "rows");
        !named || only.iter().any(|a| a == name)
    };
    if wanted("library") {
        library();
    }
    if wanted("rows") {
        rows();
    }
}

fn library() {
    let slope = |x: &[f64]| -> Vec<f64> {
        let n = x.len();
        (0..n)
            .map(|i| (x[(i + 1) % n] - x[(i + n - 2) % n]) * x[(i + n - 1) % n] - x[i] + 8.0)
            .collect()
    };
    let start: Vec<f64> = (0..10)
        .map(|i| 8.0 + 0.01 * f64::from(u8::from(i == 0)))
        .collect();
    let (time, columns) = record(&slope, start, (2000, 0.01), 1e-3);
    let names: Vec<String> = (0..10).map(|i| format!("x{i}")).collect();
    let mut data = Dataset::new(&names, &[]).unwrap();
    data.push("run", time, columns, None).unwrap();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let identify = Identify::new(Library::polynomial(&names, 3).unwrap());
    let (found, seconds, memory) = measured(|| identify.run(&data, &mut |_| ()).unwrap());
    let terms: Vec<usize> = found.equations.iter().map(|e| e.intervals.len()).collect();
    println!(
        "10 states, 286 candidates each, 2000 rows: {seconds:.1} s{memory}; terms of each equation {terms:?}, 4 of the truth"
    );
}

fn rows() {
    let slope = |s: &[f64]| {
        let [x, y, z] = [s[0], s[1], s[2]];
        vec![10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z]
    };
    let (time, columns) = record(&slope, vec![-8.0, 7.0, 27.0], (1_000_000, 0.01), 0.01);
    let names = ["x", "y", "z"];
    let mut data = Dataset::new(&names, &[]).unwrap();
    data.push("run", time.clone(), columns.clone(), None)
        .unwrap();
    let identify = Identify::new(Library::polynomial(&names, 3).unwrap());
    let (all, seconds, memory) = measured(|| identify.run(&data, &mut |_| ()).unwrap());
    let mut samples = Samples::new(&["t", "x", "y", "z"]);
    let table = std::iter::once(time).chain(columns).collect();
    samples.push_group(table).unwrap();
    let columns = Columns::new::<&str>("t", &names, &[]).unwrap();
    let pass = || {
        identify
            .run_stream(&samples, &columns, &mut |_| ())
            .unwrap()
    };
    let (streamed, pass_seconds, _) = measured(pass);
    println!(
        "3 states, 20 candidates each, 10⁶ rows: {seconds:.1} s{memory}, in one pass {pass_seconds:.1} s"
    );
    for (name, (all, streamed)) in names.iter().zip(widths(&all).iter().zip(widths(&streamed))) {
        println!("  {name}' intervals {all:.6?}, of one pass {streamed:.6?}");
    }
}

/// Rows of a trajectory, and its columns with noise that is a share of each one's scatter.
fn record(
    slope: &dyn Fn(&[f64]) -> Vec<f64>,
    mut state: Vec<f64>,
    (rows, period): (usize, f64),
    noise: f64,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    const SUBSTEPS: usize = 4;
    // The start is left behind.
    const BEFORE: usize = 1000;
    let h = period / SUBSTEPS as f64;
    let mut columns = vec![Vec::with_capacity(rows); state.len()];
    for row in 0..rows + BEFORE {
        if row >= BEFORE {
            columns.iter_mut().zip(&state).for_each(|(c, v)| c.push(*v));
        }
        for _ in 0..SUBSTEPS {
            let along = |d: &[f64], h: f64| -> Vec<f64> {
                state.iter().zip(d).map(|(x, d)| x + h * d).collect()
            };
            let a = slope(&state);
            let b = slope(&along(&a, h / 2.0));
            let c = slope(&along(&b, h / 2.0));
            let d = slope(&along(&c, h));
            for (i, x) in state.iter_mut().enumerate() {
                *x += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
            }
        }
    }
    let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
    for column in &mut columns {
        let mean = column.iter().sum::<f64>() / rows as f64;
        let square = column.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        let sigma = noise * (square / rows as f64).sqrt();
        for value in column {
            let normal: f64 = StandardNormal.sample(&mut rng);
            *value += sigma * normal;
        }
    }
    let time = (0..rows).map(|k| period * k as f64).collect();
    (time, columns)
}

/// What `run` returns, its seconds, and a text of the memory that it takes at most.
fn measured<T>(run: impl FnOnce() -> T) -> (T, f64, String) {
    let before = megabytes("VmRSS").and_then(|before| reset_peak().map(|()| before));
    let start = Instant::now();
    let out = run();
    let seconds = start.elapsed().as_secs_f64();
    let memory = match (before, megabytes("VmHWM")) {
        (Ok(before), Ok(peak)) => format!(", {:.0} MB", peak - before),
        _ => String::new(),
    };
    (out, seconds, memory)
}

/// Half widths of the intervals of each equation's terms.
fn widths(found: &Identification) -> Vec<Vec<f64>> {
    let half = |[a, b]: [f64; 2]| (b - a) / 2.0;
    let of =
        |e: &sindy::identify::Equation| e.intervals.iter().flatten().copied().map(half).collect();
    found.equations.iter().map(of).collect()
}
