//! More and more noise: what is found, what it was chosen from, and how wrong it is.
//!
//! `cargo run --release -p sindy --example 04_noise_and_choosing [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::identify::{Equation, Identification};
use sindy::problems::{self, Problem};
use sindy::{Dataset, Identify};
use touchdown_report::{Color, Figure, Panel, Series};

/// Runs with noise of their own at each level.
const SEEDS: u64 = 3;

fn identify(problem: &Problem, percent: f64, seed: u64) -> Result<Identification, Box<dyn Error>> {
    let mut data = Dataset::new(&problem.states, &problem.inputs)?;
    for run in problem.noisy(percent, seed)? {
        data.push("a run", run.time, run.states, None)?;
    }
    Ok(Identify::new(problem.library()?).run(&data, &mut |_| ())?)
}

/// Relative error of all coefficients, and whether the terms are the true ones.
fn score(problem: &Problem, found: &Identification) -> (f64, bool) {
    let (mut wrong, mut size, mut exact) = (0.0, 0.0, true);
    for (truth, equation) in problem.truth.iter().zip(found.model.equations()) {
        for name in &problem.terms {
            let a = truth.iter().find(|(t, _)| t == name).map_or(0.0, |t| t.1);
            let kept = equation.iter().find(|t| t.expression.to_string() == *name);
            let b = kept.map_or(0.0, |t| t.coefficient);
            exact &= (a != 0.0) == (b != 0.0);
            wrong += (a - b).powi(2);
            size += a * a;
        }
    }
    ((wrong / size).sqrt(), exact)
}

/// The front of terms against error, the choice as a large point.
fn front(mut panel: Panel, equation: &Equation, color: usize) -> Panel {
    let terms: Vec<f64> = (equation.front.iter())
        .map(|p| p.terms.len() as f64)
        .collect();
    let errors: Vec<f64> = equation.front.iter().map(|p| p.error).collect();
    let name = format!("{}'", equation.state);
    panel = panel.series(Series::lines_points(name, &terms, &errors).color(Color::Cycle(color)));
    for (k, _) in equation.front.iter().enumerate().filter(|(_, p)| p.chosen) {
        let dot = Series::points("", &terms[k..=k], &errors[k..=k]).width(5.0);
        panel = panel.series(dot.color(Color::Cycle(color)));
    }
    panel
}

fn main() -> Result<(), Box<dyn Error>> {
    let problem = problems::van_der_pol(); // x' = y, y' = 2 y - 2 x^2 y - x, cubic library
    let levels = [0.1, 1.0, 5.0, 10.0, 20.0];
    let (mut errors, mut medians) = (vec![Vec::new(); SEEDS as usize], Vec::new());
    let mut shown = None;
    for percent in levels {
        let (mut of_level, mut exact) = (Vec::new(), 0);
        for (seed, errors) in (0..SEEDS).zip(&mut errors) {
            let found = identify(&problem, percent, (1000.0 * percent) as u64 + seed)?;
            let (error, is_exact) = score(&problem, &found);
            errors.push(error);
            of_level.push(error);
            exact += u32::from(is_exact);
            if percent == 5.0 {
                shown = Some(found);
            }
        }
        of_level.sort_by(f64::total_cmp);
        let median = of_level[of_level.len() / 2];
        medians.push(median);
        println!("{percent:>5} % noise: error {median:.1e}, true terms in {exact} of {SEEDS}");
    }
    let found = shown.ok_or("5 % is among the levels")?;
    println!("\nat 5 %\n{:.3}\n{}\n", found.model, found.choice.reason);
    println!("compared by short simulations from smoothed states (1 is the noise):");
    for c in &found.candidates {
        println!("{:<60} {:>3} terms {:>8.3}", c.name, c.terms, c.free_run);
    }
    println!();

    let mut fronts = Panel::new("terms in the equation", "residual / noise")
        .title("5 % noise: the best terms of every number, the choice large")
        .log_y();
    for (i, equation) in found.equations.iter().enumerate() {
        fronts = front(fronts, equation, i);
    }
    let mut against = Panel::new(
        "noise (% of each state's standard deviation)",
        "error of the coefficients",
    )
    .title("Error against noise")
    .log_x()
    .log_y()
    .series(Series::line("median", &levels, &medians));
    for (seed, errors) in errors.iter().enumerate() {
        let name = if seed == 0 { "one seed" } else { "" };
        against = against.series(Series::points(name, &levels, errors).color(Color::Cycle(1)));
    }
    let picture = Figure::new(
        "04_noise_and_choosing",
        "Van der Pol, chosen by the data alone",
    )
    .size(900, 760)
    .panel(fronts)
    .panel(against);
    figure::save(&picture)
}
