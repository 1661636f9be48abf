//! How sure is it? Intervals of coefficients and bands of runs, by a bootstrap over blocks of rows.
//!
//! `cargo run --release -p sindy --example 08_uncertainty [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::derivative::{SavgolSearch, choose_savgol};
use sindy::model::{Inputs, Simulation, Time};
use sindy::solve::exact::BestBy;
use sindy::statistics::gram::Accumulate;
use sindy::uncertainty::{Band, Bootstrap, models};
use sindy::{BestSubset, Criterion, Samples, Solver, problems};
use touchdown_report::{Color, Figure, Panel, Series};

fn main() -> Result<(), Box<dyn Error>> {
    let problem = problems::lotka_volterra();
    let run = problem.noisy(10.0, 4)?.remove(0);
    let (mut columns, mut slopes) = (Vec::new(), Vec::new());
    for x in &run.states {
        let filter = choose_savgol(&[(&run.time, x)], &SavgolSearch::default())?;
        let smooth = filter.filter.apply(&run.time, x)?;
        columns.push(smooth.value);
        slopes.push(smooth.derivative);
    }
    let mut samples = Samples::new(&["x", "y", "x_dot", "y_dot"]);
    samples.push_group([columns, slopes].concat())?;

    // Every replicate chooses its terms again: inclusion is the share of replicates that keep a term.
    let library = problem.library()?;
    let solver = BestBy {
        search: BestSubset::new().max_size(4),
        criterion: Criterion::Bic,
    };
    let equations =
        ["x_dot", "y_dot"].map(|t| (Accumulate::new(&library, t), &solver as &dyn Solver));
    let found = Bootstrap::new(400, 1)?.run(&equations, &samples)?;
    println!(
        "{} blocks of {} rows\n",
        found[0].blocks, found[0].block_rows
    );
    let truth = problem.coefficients();
    for (i, (state, one)) in problem.states.iter().zip(&found).enumerate() {
        for (j, name) in library.names().iter().enumerate() {
            let e = &one.ensemble;
            if e.inclusion[j] > 0.1 {
                print!(
                    "{state}'  {name:<6} {:>7.4}, 95 %: ",
                    one.fit.coefficients[j]
                );
                print!(
                    "{:>7.4} to {:>7.4}, truth {:>7.4}",
                    e.lower[j], e.upper[j], truth[i][j]
                );
                println!(", kept by {:.0} %", 100.0 * e.inclusion[j]);
            }
        }
    }

    // Each replicate is a model; each model runs from the same start.
    let pairs = [(&library, &found[0]), (&library, &found[1])];
    let members = models(Time::Continuous, &problem.states, &[], &pairs)?;
    let time: Vec<f64> = (0..3000).map(|k| 0.01 * f64::from(k)).collect();
    let start = &problem.trajectories[0].start;
    let how = Simulation::adaptive();
    let band = Band::of_runs(&members, 0.95, |m| {
        m.simulate(start, &time, &Inputs::none(), &how)
    })?;
    let true_run = (problem.model()?).simulate(start, &time, &Inputs::none(), &how)?;
    let until = band.middle[0].len();
    println!(
        "\n{} of {} models run to the end",
        band.finished(),
        members.len()
    );
    let inside = (0..until)
        .filter(|&k| (band.lower[0][k]..=band.upper[0][k]).contains(&true_run.states[0][k]))
        .count();
    println!(
        "the true x lies inside its band for {:.0} % of the time\n",
        100.0 * inside as f64 / until as f64
    );

    let mut picture = Figure::new(
        "08_uncertainty",
        "Lotka–Volterra, 10 % noise: 95 % bands of free runs",
    )
    .share_x();
    for (i, state) in problem.states.iter().enumerate() {
        let band_of = |name| Series::band(name, &time[..until], &band.lower[i], &band.upper[i]);
        let shown = time.partition_point(|t| *t < 30.0).min(run.time.len());
        picture = picture.panel(
            Panel::new("time", *state)
                .series(band_of("95 % of the models").color(Color::Cycle(0)))
                .series(
                    Series::line("their median", &time[..until], &band.middle[i])
                        .color(Color::Cycle(0)),
                )
                .series(Series::dashed("truth", &time, &true_run.states[i]).color(Color::BLACK))
                .series(
                    Series::points("measured", &run.time[..shown], &run.states[i][..shown])
                        .width(0.5)
                        .color(Color::GREY),
                ),
        );
    }
    figure::save(&picture)
}
