//! A system with an input: the Duffing oscillator under one force, predicted under another.
//!
//! `cargo run --release -p sindy --example 03_controls [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::model::{Inputs, Interpolation, Limits, RunOutcome, Search, Simulation};
use sindy::{Dataset, Identify, Library, problems};
use touchdown_report::{Color, Figure, Panel, Series};

fn main() -> Result<(), Box<dyn Error>> {
    // Measured under u = 0.5 cos 1.2 t, with 5 % noise on both states.
    let problem = problems::duffing();
    let mut data = Dataset::new(&["x", "v"], &["u"])?;
    for run in problem.noisy(5.0, 1)? {
        data.push("cosine", run.time, [run.states, run.inputs].concat(), None)?;
    }
    // Cubic in the states; the force may act directly, squared, or through the states.
    let library = Library::specification("poly(3, x, v) + u + u^2 + u*x + u*v", &["x", "v", "u"])?;
    let found = Identify::new(library).run(&data, &mut |_| ())?;
    println!("found\n{:.3}\ntruth\n{:.3}", found.model, problem.model()?);
    println!("{}\n", found.choice.reason);

    // Without force: where does it rest?
    let rest = Search::new(&[(-2.0, 2.0), (-2.0, 2.0)]).input(&[0.0]);
    for point in rest.run(&found.model)?.equilibria {
        println!(
            "rests at x = {:>6.3}: {:?}",
            point.state[0], point.stability
        );
    }

    // A force that it has not seen, as samples: steps of changing sign and size.
    let time: Vec<f64> = (0..1500).map(|k| 0.02 * f64::from(k)).collect();
    let force: Vec<f64> = (time.iter())
        .map(|t| [0.6, -0.3, 0.0, 0.8, -0.7, 0.2][(t / 5.0) as usize])
        .collect();
    let inputs = Inputs::sampled(&time, &[&force], Interpolation::ZeroOrderHold)?;
    let limits = Limits::default().blow_up_above(100.0);
    let how = Simulation::adaptive().limits(limits);
    let truth = (problem.model()?).simulate(&[1.0, 0.0], &time, &inputs, &how)?;
    let model = (found.model).simulate(&[1.0, 0.0], &time, &inputs, &how)?;
    assert_eq!(model.outcome, RunOutcome::Finished);
    let worst = (model.states[0].iter().zip(&truth.states[0]))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("\nunder the new force, x differs from the truth by at most {worst:.3}\n");

    let picture = Figure::new(
        "03_controls",
        "Duffing oscillator under a force that it has not seen",
    )
    .share_x()
    .panel(
        Panel::new("time", "force u")
            .height_weight(0.6)
            .y_range(-1.0, 1.0)
            .series(Series::steps("", &time, &force).color(Color::GREY)),
    )
    .panel(
        Panel::new("time", "x")
            .series(
                Series::line("truth", &time, &truth.states[0])
                    .color(Color::GREY)
                    .width(3.0),
            )
            .series(Series::dashed("found, free run", &time, &model.states[0])),
    );
    figure::save(&picture)
}
