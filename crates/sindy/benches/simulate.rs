//! Simulation of fitted models: `cargo bench -p sindy --bench simulate`.
//!
//! 30 time units of the Lorenz system, 3000 rows at 100 Hz, as a model of degree 5: once with the 7 terms
//! that are true, once with all 3 × 56 coefficients present (the others zero, so that the
//! trajectory is the same and nothing is saved). Prints the median time of a run and of one right-hand side.

#![allow(clippy::print_stdout, missing_docs)]

use std::hint::black_box;
use std::time::Instant;

use sindy::model::{Inputs, Model, RunOutcome, Simulation, Term};
use sindy::{SindyError, problems};

const REPEATS: usize = 21;

fn main() -> Result<(), SindyError> {
    let sparse = problems::lorenz().model()?;
    let dense = every_term_of_degree_5(&sparse)?;
    let time: Vec<f64> = (0..3000).map(|k| 0.01 * f64::from(k)).collect();
    let start = [-8.0, 7.0, 27.0];
    let none = Inputs::none();
    for (name, model) in [("7 terms", &sparse), ("168 terms", &dense)] {
        for (method, how) in [
            ("Runge-Kutta 4, step 0.01 ", Simulation::fixed(0.01)),
            ("Dormand-Prince, rel. 1e-3", loose()),
            ("Dormand-Prince, rel. 1e-8", Simulation::adaptive()),
        ] {
            let mut seconds = Vec::with_capacity(REPEATS);
            let mut evaluations = 0;
            for _ in 0..REPEATS {
                let begin = Instant::now();
                let run = black_box(model.simulate(&start, &time, &none, &how)?);
                seconds.push(begin.elapsed().as_secs_f64());
                assert_eq!(run.outcome, RunOutcome::Finished);
                evaluations = run.evaluations;
            }
            seconds.sort_by(f64::total_cmp);
            let median = seconds[REPEATS / 2];
            println!(
                "{name:>9}, {method}: {:7.3} ms, {evaluations:6} right-hand sides of {:5.0} ns",
                1e3 * median,
                1e9 * median / evaluations as f64
            );
        }
    }
    Ok(())
}

/// The tolerances that SciPy's `solve_ivp` has by default.
fn loose() -> Simulation {
    Simulation::new(sindy::model::Integrator::DormandPrince {
        relative: 1e-3,
        absolute: 1e-6,
    })
}

fn every_term_of_degree_5(model: &Model) -> Result<Model, SindyError> {
    let mut texts = Vec::new();
    for degree in 0..=5_u32 {
        for a in (0..=degree).rev() {
            for b in (0..=degree - a).rev() {
                texts.push(sindy_expr::Expr::monomial(&[
                    ("x", a),
                    ("y", b),
                    ("z", degree - a - b),
                ]));
            }
        }
    }
    let equations = model.equations().iter().map(|known| {
        let coefficient = |e: &sindy_expr::Expr| {
            known
                .iter()
                .find(|t| t.expression == *e)
                .map_or(0.0, |t| t.coefficient)
        };
        texts
            .iter()
            .map(|e| Term::new(e.clone(), coefficient(e)))
            .collect()
    });
    Model::new(model.time(), model.states(), &[], equations.collect())
}
