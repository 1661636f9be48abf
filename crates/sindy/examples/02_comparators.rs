//! How far ahead do DMDc, EDMDc and a sparse model predict? Fitted to one noisy trajectory, asked about
//! that trajectory without noise and about one from another start.
//!
//! The sparse model's threshold is set by hand (0.1 in the coefficients' own units). It decides the outcome: with 0.05 on
//! scaled columns false terms stay, and on Lotka–Volterra the sparse model is then no better than EDMDc.
//!
//! `cargo run --release -p sindy --example 02_comparators`
#![allow(clippy::print_stdout)]

use sindy::koopman::{Dmdc, Edmdc, Lifting, Rank};
use sindy::model::{Inputs, Model, Run, RunOutcome, Simulation, Time};
use sindy::problems::{self, Problem, Record};
use sindy::sr3::Scaling;
use sindy::{Gram, Samples, SavitzkyGolay, SindyError, Solver, Stlsq};

/// Steps ahead.
const HORIZON: usize = 200;

type Predictor<'a> = (&'a str, Box<dyn Fn(&[f64]) -> Result<Run, SindyError>>);

fn predictors(problem: &Problem) -> Result<Vec<Predictor<'static>>, SindyError> {
    let record = &problem.noisy(1.0, 7)?[0]; // 1 % noise, seed 7
    let filter = SavitzkyGolay::new(25, 4)?;
    let (mut columns, mut slopes) = (Vec::new(), Vec::new());
    for x in &record.states {
        let smooth = filter.apply(&record.time, x)?;
        columns.push(smooth.value);
        slopes.push(smooth.derivative);
    }
    let mut data = Samples::new(&["x", "y", "x_dot", "y_dot"]);
    data.push_group([columns, slopes].concat())?;

    let (states, library) = (["x", "y"], problem.library()?);
    let linear = Dmdc::new(Rank::Full, 0.0)?.fit(&data, &states, &[], problem.step)?;
    let lifted =
        Edmdc::new(library.clone(), Rank::Full, 0.0)?.fit(&data, &states, &[], problem.step)?;
    let mut coefficients = Vec::new();
    for target in ["x_dot", "y_dot"] {
        let gram = Gram::total(&Gram::accumulate(&library, target, &data)?);
        // The threshold is in the units of the coefficients.
        let fit = Stlsq::new(0.1, 0.0)?.scaling(Scaling::None).fit(&gram)?;
        coefficients.push(fit.coefficients.as_slice().to_vec());
    }
    let sparse = Model::from_library(Time::Continuous, &states, &[], &library, &coefficients)?;
    println!("{}, as found:\n{sparse:.3}", problem.name);

    let time = record.time[..=HORIZON].to_vec();
    let how = Simulation::fixed(problem.step);
    let again = lifted.clone();
    Ok(vec![
        ("DMDc", Box::new(move |x| linear.simulate(x, HORIZON, &[]))),
        (
            "EDMDc, lifted once",
            Box::new(move |x| again.simulate(x, HORIZON, &[], Lifting::Once)),
        ),
        (
            "EDMDc, every step",
            Box::new(move |x| lifted.simulate(x, HORIZON, &[], Lifting::EveryStep)),
        ),
        (
            "SINDy (STLSQ)",
            Box::new(move |x| sparse.simulate(x, &time, &Inputs::none(), &how)),
        ),
    ])
}

/// Root mean square error in percent of the states' root mean square, and how many runs blew up.
fn error(record: &Record, predict: &Predictor<'_>) -> Result<(f64, usize), SindyError> {
    let (mut wrong, mut size, mut blown) = (0.0, 0.0, 0);
    for from in (0..record.time.len() - HORIZON).step_by(100) {
        let start: Vec<f64> = record.states.iter().map(|x| x[from]).collect();
        let run = (predict.1)(&start)?;
        if run.outcome != RunOutcome::Finished {
            blown += 1;
            continue;
        }
        for (found, truth) in run.states.iter().zip(&record.states) {
            for (f, t) in found.iter().zip(&truth[from..]) {
                wrong += (f - t).powi(2);
                size += t * t;
            }
        }
    }
    Ok((100.0 * (wrong / size).sqrt(), blown))
}

fn main() -> Result<(), SindyError> {
    for (problem, start) in [
        (problems::van_der_pol(), [2.5, 2.0]),
        (problems::lotka_volterra(), [1.4, 0.9]),
    ] {
        let predictors = predictors(&problem)?;
        let mut other = problem.clone();
        other.trajectories[0].start = start.to_vec();
        let (same, other) = (problem.clean()?, other.clean()?);
        println!("error over {HORIZON} steps of {}", problem.step);
        println!("{:<20} {:>14} {:>14}", "", "same orbit", "other start");
        for predictor in &predictors {
            print!("{:<20}", predictor.0);
            for record in [&same[0], &other[0]] {
                let (percent, blown) = error(record, predictor)?;
                let note = if blown > 0 {
                    format!(" ({blown} blew up)")
                } else {
                    String::new()
                };
                print!(" {percent:>12.4} %{note}");
            }
            println!();
        }
        println!();
    }
    Ok(())
}
