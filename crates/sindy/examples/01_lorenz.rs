//! The Lorenz system from noisy samples, by the automatic call.
//!
//! `cargo run --release -p sindy --example 01_lorenz [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::model::{Inputs, Simulation};
use sindy::{Dataset, Identify, Library, problems};
use touchdown_report::{Color, Figure, Panel, Series};

fn main() -> Result<(), Box<dyn Error>> {
    let problem = problems::lorenz();
    let run = problem.noisy(5.0, 42)?.remove(0); // 5 % noise, seed 42
    let mut data = Dataset::new(&["x", "y", "z"], &[])?;
    data.push("a run", run.time.clone(), run.states.clone(), None)?;

    let library = Library::polynomial(&["x", "y", "z"], 3)?;
    let found = Identify::new(library).run(&data, &mut |_| ())?;
    println!("found\n{:.4}\ntruth\n{:.4}", found.model, problem.model()?);
    println!("{}\n", found.choice.reason);
    for (state, terms) in found.model.states().iter().zip(found.model.equations()) {
        for term in terms {
            let (error, sure) = (term.std_error.unwrap_or(f64::NAN), term.inclusion);
            let name = term.expression.to_string();
            print!("{state}'  {name:<4} {:>9.4} ± {error:.4}", term.coefficient);
            println!("  inclusion {:.3}", sure.unwrap_or(f64::NAN));
        }
    }

    // Both models run freely from the true start: how long do they stay together?
    let time: Vec<f64> = (0..2500).map(|k| 0.008 * f64::from(k)).collect();
    let start = &problem.trajectories[0].start;
    let how = Simulation::adaptive();
    let truth = (problem.model()?).simulate(start, &time, &Inputs::none(), &how)?;
    let model = (found.model).simulate(start, &time, &Inputs::none(), &how)?;
    let apart = (truth.states[0].iter().zip(&model.states[0]))
        .position(|(a, b)| (a - b).abs() > 5.0)
        .map_or(time[time.len() - 1], |k| time[k]);
    println!("\nfrom the true start, x stays within 5 of the truth for {apart:.1} units of time\n");

    let grey = |series: Series| series.color(Color::GREY);
    let picture = Figure::new("01_lorenz", "Lorenz from samples with 5 % noise")
        .size(900, 780)
        .panel(
            Panel::new("x", "z")
                .height_weight(1.5)
                .series(grey(
                    Series::points("measured", &run.states[0], &run.states[2]).width(0.8),
                ))
                .series(
                    Series::line("found, free run", &model.states[0], &model.states[2]).width(1.0),
                ),
        )
        .panel(
            Panel::new("time", "x")
                .series(grey(
                    Series::line("truth", &time, &truth.states[0]).width(2.5),
                ))
                .series(Series::dashed("found, free run", &time, &model.states[0]))
                .series(Series::vertical(
                    "end of the measurements",
                    run.time[run.time.len() - 1],
                )),
        );
    figure::save(&picture)
}
