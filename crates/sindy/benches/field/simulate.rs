//! True trajectories of a system, by Runge–Kutta of order 4; driven by noise, by Heun's method; driven by noise whose size depends
//! on the state, by the method of Euler and Maruyama.

use rand::RngExt;
use rand_pcg::Pcg64;
use sindy::SindyError;
use sindy::model::{Evaluator, Inputs, Model, Term, Time};

use crate::corruption::{Corruption, normal};
use crate::systems::{Clock, Equations, System, Task};

/// Rows of one trajectory.
pub(crate) struct Rows {
    pub(crate) time: Vec<f64>,
    /// One column for each state.
    pub(crate) states: Vec<Vec<f64>>,
    /// One column for each input.
    pub(crate) inputs: Vec<Vec<f64>>,
}

/// The true model.
pub(crate) fn truth(system: &System) -> Result<Model, SindyError> {
    model(system, system.truth)
}

/// The squared diffusions as equations of the states, where a system has them.
pub(crate) fn diffusions(system: &System) -> Result<Option<Model>, SindyError> {
    match system.task {
        Task::Diffusion(squares) | Task::Disturbed(squares) => model(system, squares).map(Some),
        _ => Ok(None),
    }
}

fn model(system: &System, equations: Equations) -> Result<Model, SindyError> {
    let equation = |terms: &&[(&str, f64)]| terms.iter().map(|(t, c)| Term::parse(t, *c)).collect();
    let time = match system.clock {
        Clock::Map => Time::Discrete { period: 1.0 },
        _ => Time::Continuous,
    };
    let equations = equations.iter().map(equation).collect::<Result<_, _>>()?;
    Model::new(time, system.states, system.inputs, equations)
}

/// The standard deviation of each state over all trajectories.
pub(crate) fn scatter(all: &[Rows]) -> Vec<f64> {
    let sd = |i: usize| {
        let values = || all.iter().flat_map(|r| r.states[i].iter());
        let n = values().count() as f64;
        let mean = values().sum::<f64>() / n;
        (values().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
    };
    (0..all[0].states.len()).map(sd).collect()
}

/// The times of the rows.
fn times(system: &System, corruption: Corruption, rng: &mut Pcg64) -> Vec<f64> {
    let n = system.rows;
    match system.clock {
        Clock::Map => (0..n).map(|k| k as f64).collect(),
        Clock::Logarithmic(from, to) => {
            let part = |k: usize| (k - 1) as f64 / (n - 2) as f64;
            let at = |k: usize| {
                if k == 0 {
                    0.0
                } else {
                    from * (to / from).powf(part(k))
                }
            };
            (0..n).map(at).collect()
        }
        Clock::Every(step) => {
            let mut off = || match corruption {
                Corruption::Irregular(_) => rng.random_range(-0.4..0.4),
                _ => 0.0,
            };
            (0..n).map(|k| (k as f64 + off()) * step).collect()
        }
    }
}

/// All trajectories, driven by noise of standard deviation `drive` for each state in one unit of time.
pub(crate) fn simulate(
    system: &System,
    corruption: Corruption,
    drive: &[f64],
    rng: &mut Pcg64,
) -> Result<Vec<Rows>, SindyError> {
    let model = truth(system)?;
    let squares = diffusions(system)?;
    let mut all = Vec::new();
    for (start, formulas) in system.runs {
        let time = times(system, corruption, rng);
        let inputs = Inputs::formulas(formulas)?;
        let mut eval = model.evaluator();
        let mut squares = squares.as_ref().map(Model::evaluator);
        let mut states = vec![Vec::with_capacity(time.len()); start.len()];
        let mut columns = vec![Vec::with_capacity(time.len()); formulas.len()];
        let mut x = start.to_vec();
        for (k, &t) in time.iter().enumerate() {
            for (column, value) in states.iter_mut().zip(&x) {
                column.push(*value);
            }
            for (column, value) in columns.iter_mut().zip(inputs.at(t)?) {
                column.push(value);
            }
            let Some(next) = time.get(k + 1) else { break };
            if let Some(squares) = &mut squares {
                diffuse(system.substeps, (&mut eval, squares), &mut x, next - t, rng);
                continue;
            }
            match system.clock {
                Clock::Map => {
                    let before = x.clone();
                    eval.eval(&before, &inputs.at(t)?, &mut x);
                    for (x, sd) in x.iter_mut().zip(drive) {
                        *x += sd * normal(rng);
                    }
                }
                _ => advance(system, (&mut eval, &inputs), &mut x, (t, *next), drive, rng)?,
            }
        }
        all.push(Rows {
            time,
            states,
            inputs: columns,
        });
    }
    Ok(all)
}

/// So long in so many steps of Euler and Maruyama, with the evaluators of drift and squared diffusion.
fn diffuse(
    steps: usize,
    (drift, squares): (&mut Evaluator<'_>, &mut Evaluator<'_>),
    x: &mut [f64],
    duration: f64,
    rng: &mut Pcg64,
) {
    let h = duration / steps as f64;
    let (mut f, mut q) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    for _ in 0..steps {
        drift.eval(x, &[], &mut f);
        squares.eval(x, &[], &mut q);
        for (x, (f, q)) in x.iter_mut().zip(f.iter().zip(&q)) {
            *x += f * h + (q * h).sqrt() * normal(rng);
        }
    }
}

/// From one time to the next in so many steps.
fn advance(
    system: &System,
    (eval, inputs): (&mut Evaluator<'_>, &Inputs),
    x: &mut [f64],
    (from, to): (f64, f64),
    drive: &[f64],
    rng: &mut Pcg64,
) -> Result<(), SindyError> {
    let substeps = system
        .substeps
        .max(((to - from) / system.longest).ceil() as usize);
    let h = (to - from) / substeps as f64;
    let n = x.len();
    for k in 0..substeps {
        let t = |part: f64| {
            if system.held {
                from
            } else {
                from + (k as f64 + part) * h
            }
        };
        let u = [inputs.at(t(0.0))?, inputs.at(t(0.5))?, inputs.at(t(1.0))?];
        let mut slope = |at: &[f64], u: &[f64]| {
            let mut out = vec![0.0; n];
            eval.eval(at, u, &mut out);
            out
        };
        let shifted = |x: &[f64], by: &[f64], h: f64| -> Vec<f64> {
            x.iter().zip(by).map(|(x, d)| x + h * d).collect()
        };
        let k1 = slope(x, &u[0]);
        if drive.iter().any(|d| *d > 0.0) {
            let kick: Vec<f64> = drive.iter().map(|d| d * h.sqrt() * normal(rng)).collect();
            let trial: Vec<f64> = (0..n).map(|i| x[i] + h * k1[i] + kick[i]).collect();
            let k2 = slope(&trial, &u[2]);
            for i in 0..n {
                x[i] += 0.5 * h * (k1[i] + k2[i]) + kick[i];
            }
            continue;
        }
        let k2 = slope(&shifted(x, &k1, 0.5 * h), &u[1]);
        let k3 = slope(&shifted(x, &k2, 0.5 * h), &u[1]);
        let k4 = slope(&shifted(x, &k3, h), &u[2]);
        for i in 0..n {
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    Ok(())
}
