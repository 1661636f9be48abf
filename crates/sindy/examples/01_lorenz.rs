//! The Lorenz system from noisy samples: data, derivatives, library, fit, print.
//!
//! `cargo run --release -p sindy --example 01_lorenz`
#![allow(clippy::print_stdout)]

use sindy::derivative::{SavgolSearch, choose_savgol};
use sindy::model::{Model, Time};
use sindy::sr3::Scaling;
use sindy::{Gram, Samples, Solver, Stlsq, problems};

fn main() -> Result<(), sindy::SindyError> {
    let problem = problems::lorenz();
    let data = &problem.noisy(1.0, 42)?[0]; // 1 % noise, seed 42
    let series: Vec<(&[f64], &[f64])> = (data.states.iter())
        .map(|x| (data.time.as_slice(), x.as_slice()))
        .collect();
    let mut columns = Vec::new();
    let mut slopes = Vec::new();
    for one in series {
        let choice = choose_savgol(&[one], &SavgolSearch::default())?;
        println!("{choice}");
        let smooth = choice.filter.apply(one.0, one.1)?;
        columns.push(smooth.value);
        slopes.push(smooth.derivative);
    }
    let mut samples = Samples::new(&["x", "y", "z", "x_dot", "y_dot", "z_dot"]);
    samples.push_group([columns, slopes].concat())?;

    let library = problem.library()?;
    let mut coefficients = Vec::new();
    for target in ["x_dot", "y_dot", "z_dot"] {
        let gram = Gram::total(&Gram::accumulate(&library, target, &samples)?);
        // The threshold is in the units of the coefficients.
        let fit = Stlsq::new(0.1, 0.0)?.scaling(Scaling::None).fit(&gram)?;
        coefficients.push(fit.coefficients.as_slice().to_vec());
    }
    let states = ["x", "y", "z"];
    let model = Model::from_library(Time::Continuous, &states, &[], &library, &coefficients)?;
    println!("\nfound\n{model:.4}\ntruth\n{:.4}", problem.model()?);
    Ok(())
}
