//! How far ahead do DMDc, EDMDc and a sparse model predict? Fitted to one noisy trajectory, asked about
//! that trajectory without noise and about one from another start.
//!
//! `cargo run --release -p sindy --example 02_comparators [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::koopman::{Dmdc, Edmdc, Lifting, Rank};
use sindy::model::{Inputs, Run, RunOutcome, Simulation};
use sindy::problems::{self, Problem, Record};
use sindy::{Dataset, Identify, Samples, SavitzkyGolay, SindyError};
use touchdown_report::{Color, Figure, Panel, Series};

/// Steps ahead.
const HORIZON: usize = 200;

type Predictor = (&'static str, Box<dyn Fn(&[f64]) -> Result<Run, SindyError>>);

fn predictors(problem: &Problem) -> Result<Vec<Predictor>, SindyError> {
    let record = &problem.noisy(1.0, 7)?[0]; // 1 % noise, seed 7
    // The linear ones see smoothed states; the automatic call smooths by itself.
    let filter = SavitzkyGolay::new(25, 4)?;
    let smooth = (record.states.iter()).map(|x| Ok(filter.apply(&record.time, x)?.value));
    let mut samples = Samples::new(&["x", "y"]);
    samples.push_group(smooth.collect::<Result<_, SindyError>>()?)?;
    let (states, library) = (["x", "y"], problem.library()?);
    let linear = Dmdc::new(Rank::Full, 0.0)?.fit(&samples, &states, &[], problem.step)?;
    let edmdc = Edmdc::new(library.clone(), Rank::Full, 0.0)?;
    let lifted = edmdc.fit(&samples, &states, &[], problem.step)?;

    let mut data = Dataset::new(&states, &[])?;
    data.push("a run", record.time.clone(), record.states.clone(), None)?;
    let sparse = Identify::new(library).run(&data, &mut |_| ())?.model;
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
            "sparse",
            Box::new(move |x| sparse.simulate(x, &time, &Inputs::none(), &how)),
        ),
    ])
}

/// Root mean square error in percent of the states' root mean square, and how many runs blew up.
fn error(record: &Record, predict: &Predictor) -> Result<(f64, usize), SindyError> {
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

fn main() -> Result<(), Box<dyn Error>> {
    let mut picture =
        Figure::new("02_comparators", "From a start that was not in the data").size(900, 760);
    for (problem, start) in [
        (problems::van_der_pol(), [2.5, 2.0]),
        (problems::lotka_volterra(), [1.4, 0.9]),
    ] {
        let predictors = predictors(&problem)?;
        let mut other = problem.clone();
        other.trajectories[0].start = start.to_vec();
        let (same, other) = (problem.clean()?, other.clean()?);
        let time = &other[0].time[..=HORIZON];
        let truth = &other[0].states[0][..=HORIZON];
        let (low, high) = truth
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let mut panel = Panel::new("time", "x")
            .title(problem.name)
            .y_range(1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low)
            .series(
                Series::line("truth", time, truth)
                    .color(Color::GREY)
                    .width(4.0),
            );
        println!("error over {HORIZON} steps of {}", problem.step);
        println!("{:<20} {:>14} {:>14}", "", "same orbit", "other start");
        for predictor in &predictors {
            print!("{:<20}", predictor.0);
            for record in [&same[0], &other[0]] {
                let (percent, blown) = error(record, predictor)?;
                let note = ["", " (some blew up)"][usize::from(blown > 0)];
                print!(" {percent:>12.4} %{note}");
            }
            println!();
            let run = (predictor.1)(&start)?;
            panel = panel.series(Series::dashed(predictor.0, &run.time, &run.states[0]));
        }
        println!();
        picture = picture.panel(panel);
    }
    figure::save(&picture)
}
