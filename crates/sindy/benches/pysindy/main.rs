//! One case of the bench against PySINDy on our side: `pysindy CASE DIRECTORY REPEATS` prints one JSON object. `run.sh`
//! beside this file makes the data, runs both sides and prints the table.
//!
//! Seconds are CPU time (user and system) of this process, the smallest of the repeats; memory is the growth of the
//! resident peak over what the data hold, in the first of them.

#![allow(clippy::print_stdout, missing_docs)]

#[path = "../memory/mod.rs"]
mod memory;
mod npy;

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use memory::{megabytes, reset_peak};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};
use sindy::choose::cross_validate_scaled;
use sindy::derivative::{FiniteDifference, Rates};
use sindy::model::{Inputs, Integrator, Model, RunOutcome, Simulation, Time};
use sindy::solve::sr3::Scaling;
use sindy::{Ensemble, Fit, Gram, Library, Samples, SavitzkyGolay, SindyError, Solver, Sr3, Stlsq};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const LORENZ: [&str; 3] = ["x", "y", "z"];
const LORENZ_RATES: [&str; 3] = ["x_dot", "y_dot", "z_dot"];
const LORENZ_STEP: f64 = 0.002;
const GROUND: [&str; 5] = ["f", "s", "z", "v_p", "v_q"];
const GROUND_TERMS: [&str; 11] = [
    "1", "f", "s", "z", "v_p", "v_q", "s^2", "v_p*v_q", "z^2", "v_p^2", "v_q^2",
];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, case, folder, repeats] = arguments.as_slice() else {
        // `cargo bench` without the script's arguments.
        println!("run.sh beside this file runs the bench against PySINDy");
        return Ok(());
    };
    let (folder, repeats) = (Path::new(folder), repeats.parse()?);
    let stlsq = || Ok(Stlsq::new(0.1, 0.05)?.scaling(Scaling::None));
    // PySINDy's defaults.
    let sr3 = || Ok(Sr3::new(0.005, 1.0)?.scaling(Scaling::None));
    let out = match case.as_str() {
        "lorenz_stlsq" => lorenz(folder, stlsq, repeats)?,
        "lorenz_sr3" => lorenz(folder, sr3, repeats)?,
        "ground_small" | "ground_large" => {
            ground(&folder.join(format!("{case}.npy")), sr3, repeats)?
        }
        "grid" => grid(folder, repeats)?,
        "bagging" => bagging(folder, repeats)?,
        "simulate" => simulate(repeats)?,
        "smooth" => smooth(folder, repeats)?,
        "product" => product(folder, repeats)?,
        "threads" => threads(folder, repeats)?,
        other => return Err(format!("unknown case `{other}`").into()),
    };
    println!("{out}");
    Ok(())
}

/// Seconds, extra peak memory in MB, and what the last repeat returned.
fn measure<T>(
    repeats: usize,
    mut work: impl FnMut() -> std::result::Result<T, SindyError>,
) -> Result<(Value, T)> {
    let before = megabytes("VmRSS")?;
    reset_peak()?;
    let (mut seconds, mut peak, mut last) = (f64::INFINITY, None, None);
    for _ in 0..repeats.max(1) {
        let start = cpu_seconds();
        last = Some(work()?);
        seconds = seconds.min(cpu_seconds() - start);
        if peak.is_none() {
            peak = Some(megabytes("VmHWM")? - before);
        }
    }
    let last = last.ok_or("no repeat")?;
    Ok((json!({ "seconds": seconds, "extra_mb": peak }), last))
}

fn cpu_seconds() -> f64 {
    seconds_of(ClockId::ProcessCPUTime)
}

fn seconds_of(clock: ClockId) -> f64 {
    let now = clock_gettime(clock);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

fn with(mut out: Value, more: Value) -> Value {
    if let (Value::Object(out), Value::Object(more)) = (&mut out, more) {
        out.extend(more);
    }
    out
}

fn coefficients(fits: &[Fit]) -> Value {
    let rows: Vec<&[f64]> = fits.iter().map(|f| f.coefficients.as_slice()).collect();
    json!({ "coefficients": rows })
}

fn degree_5() -> std::result::Result<Library, SindyError> {
    Library::polynomial(&LORENZ, 5)
}

fn lorenz_samples(folder: &Path, rows: usize) -> Result<Samples> {
    let mut groups = npy::columns(&folder.join("lorenz.npy"), rows)?;
    let mut samples = Samples::new(&LORENZ);
    samples.push_group(groups.swap_remove(0))?;
    Ok(samples)
}

fn differences(samples: &Samples) -> std::result::Result<Rates<'_>, SindyError> {
    Rates::uniform(samples, &LORENZ, FiniteDifference::new(2)?, LORENZ_STEP)
}

/// From states to three sparse equations.
fn lorenz_fit(samples: &Samples, solver: &dyn Solver) -> std::result::Result<Vec<Fit>, SindyError> {
    let library = degree_5()?;
    let rates = differences(samples)?;
    let grams = Gram::accumulate_targets(&library, &LORENZ_RATES, &rates)?;
    grams.iter().map(|g| solver.fit(&g[0])).collect()
}

fn lorenz<S: Solver>(
    folder: &Path,
    solver: impl Fn() -> std::result::Result<S, SindyError>,
    repeats: usize,
) -> Result<Value> {
    let samples = lorenz_samples(folder, usize::MAX)?;
    let (out, fits) = measure(repeats, || lorenz_fit(&samples, &solver()?))?;
    Ok(with(out, coefficients(&fits)))
}

fn ground_samples(path: &Path) -> Result<Samples> {
    let mut samples = Samples::new(&GROUND);
    for group in npy::columns(path, usize::MAX)? {
        samples.push_group(group)?;
    }
    Ok(samples)
}

fn ground_grams(samples: &Samples) -> std::result::Result<Vec<Gram>, SindyError> {
    let library = Library::parse(&GROUND_TERMS)?;
    let rates = Rates::uniform(samples, &["f"], FiniteDifference::new(2)?, 0.01)?;
    Gram::accumulate(&library, "f_dot", &rates)
}

fn ground(
    path: &Path,
    solver: impl Fn() -> std::result::Result<Sr3, SindyError>,
    repeats: usize,
) -> Result<Value> {
    let samples = ground_samples(path)?;
    let (out, solution) = measure(repeats, || {
        Ok(solver()?.solve(&Gram::total(&ground_grams(&samples)?)))
    })?;
    Ok(with(
        out,
        json!({ "coefficients": [solution.sparse.as_slice()] }),
    ))
}

/// 20 thresholds by 10 relaxations, five folds, and the pass over the data.
fn grid(folder: &Path, repeats: usize) -> Result<Value> {
    let samples = ground_samples(&folder.join("ground_small.npy"))?;
    let grid = sindy::choose::Grid {
        thresholds: (0..20).map(|k| 0.01 * 1.5_f64.powi(k)).collect(),
        nus: (0..10)
            .map(|k| 10_f64.powf(-2.0 + 0.5 * f64::from(k)))
            .collect(),
    };
    let (out, choice) = measure(repeats, || {
        cross_validate_scaled(&ground_grams(&samples)?, &grid, Scaling::None)
    })?;
    let table: Vec<f64> = choice.table.iter().map(|p| p.held_out_rmse).collect();
    Ok(with(
        out,
        json!({ "table": table, "reason": choice.reason }),
    ))
}

/// 100 replicates of the rows, with replacement.
fn bagging(folder: &Path, repeats: usize) -> Result<Value> {
    let samples = lorenz_samples(folder, 100_000)?;
    let (out, found) = measure(repeats, || {
        let solver = Stlsq::new(0.1, 0.05)?.scaling(Scaling::None);
        let library = degree_5()?;
        let rates = differences(&samples)?;
        Ensemble::new(100, 1)?.run_rows(&library, &LORENZ_RATES, &rates, &solver)
    })?;
    let medians: Vec<&[f64]> = found.iter().map(|f| f.median.as_slice()).collect();
    Ok(with(out, json!({ "coefficients": medians })))
}

/// 30 time units at 100 Hz, to the tolerances that PySINDy has by default.
fn simulate(repeats: usize) -> Result<Value> {
    let library = degree_5()?;
    let truth = [
        [("x", -10.0), ("y", 10.0)].as_slice(),
        &[("x", 28.0), ("y", -1.0), ("x*z", -1.0)],
        &[("z", -8.0 / 3.0), ("x*y", 1.0)],
    ];
    let coefficients: Vec<Vec<f64>> = truth
        .iter()
        .map(|equation| {
            let value = |name: &String| equation.iter().find(|(term, _)| term == name);
            let of = |name| value(name).map_or(0.0, |(_, c)| *c);
            library.names().iter().map(of).collect()
        })
        .collect();
    let model = Model::from_library(Time::Continuous, &LORENZ, &[], &library, &coefficients)?;
    let time: Vec<f64> = (0..=3000).map(|k| 0.01 * f64::from(k)).collect();
    let how = Simulation::new(Integrator::DormandPrince {
        relative: 1e-12,
        absolute: 1e-12,
    });
    let (out, run) = measure(repeats, || {
        model.simulate(&[-8.0, 7.0, 27.0], &time, &Inputs::none(), &how)
    })?;
    if run.outcome != RunOutcome::Finished {
        return Err(format!("{:?}", run.outcome).into());
    }
    let states: Vec<[f64; 3]> = (0..=3000)
        .step_by(100)
        .map(|k| [0, 1, 2].map(|j: usize| run.states[j][k]))
        .collect();
    let more = json!({ "states": states, "evaluations": run.evaluations });
    Ok(with(out, more))
}

fn smooth(folder: &Path, repeats: usize) -> Result<Value> {
    let y = npy::columns(&folder.join("signal.npy"), usize::MAX)?
        .swap_remove(0)
        .swap_remove(0);
    let time: Vec<f64> = (0..y.len()).map(|i| 0.001 * i as f64).collect();
    let (out, smoothed) = measure(repeats, || SavitzkyGolay::new(11, 3)?.apply(&time, &y))?;
    let inner = 100..y.len() - 100;
    let squares: f64 = inner
        .clone()
        .map(|i| (smoothed.derivative[i] - time[i].cos()).powi(2))
        .sum();
    let rms = (squares / inner.len() as f64).sqrt();
    Ok(with(out, json!({ "slope_rms_error": rms })))
}

/// Derivatives, library and Gram matrix, without a solver.
fn product(folder: &Path, repeats: usize) -> Result<Value> {
    let samples = lorenz_samples(folder, usize::MAX)?;
    let (out, grams) = measure(repeats, || {
        Gram::accumulate_targets(&degree_5()?, &LORENZ_RATES, &differences(&samples)?)
    })?;
    Ok(with(out, json!({ "rows": grams[0][0].rows })))
}

/// A whole fit by one and by two threads, in turns: wall time, CPU time of the thread that has most of it (what the
/// wall time is on idle cores, but for waiting), and whether the results have the same bits.
fn threads(folder: &Path, repeats: usize) -> Result<Value> {
    let samples = lorenz_samples(folder, usize::MAX)?;
    let solver = Stlsq::new(0.1, 0.05)?.scaling(Scaling::None);
    let pools = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build());
    let [one, two] = pools;
    let pools = [one?, two?];
    let mut seconds = [f64::INFINITY; 2];
    let mut busiest = [f64::INFINITY; 2];
    let mut fits = [None, None];
    for _ in 0..repeats {
        for (k, pool) in pools.iter().enumerate() {
            let clocks = || pool.broadcast(|_| seconds_of(ClockId::ThreadCPUTime));
            let before = clocks();
            let start = Instant::now();
            fits[k] = Some(pool.install(|| lorenz_fit(&samples, &solver))?);
            seconds[k] = seconds[k].min(start.elapsed().as_secs_f64());
            let spent = clocks().into_iter().zip(before).map(|(b, a)| b - a);
            busiest[k] = busiest[k].min(spent.fold(0.0, f64::max));
        }
    }
    Ok(json!({ "seconds": seconds, "busiest": busiest, "identical": fits[0] == fits[1] }))
}
