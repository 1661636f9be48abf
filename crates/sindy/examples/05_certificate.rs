//! The best terms of every number, proven, beside what a greedy search finds.
//!
//! `cargo run --release -p sindy --example 05_certificate [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use sindy::solve::exact::BestSubsets;
use sindy::solve::stepwise::Direction;
use sindy::{BestSubset, Criterion, Library, Samples, Stepwise, WeakForm, problems};
use touchdown_report::{Color, Figure, Panel, Series};

/// Terms, up to this many.
const MOST: usize = 8;

fn print(found: &BestSubsets, names: &[String], rows: f64) {
    println!("{:?} after {} nodes", found.outcome, found.nodes);
    for (size, s) in found.sizes.iter().enumerate().skip(1) {
        let kept = names.iter().zip(&s.fit.support).filter(|(_, kept)| **kept);
        let kept: Vec<&str> = kept.map(|(name, _)| name.as_str()).collect();
        let rms = (s.fit.residual_sum / rows).sqrt();
        println!(
            "{size:>3} terms, rms {rms:.4}, gap {:>4.1} %: {}",
            100.0 * s.gap(),
            kept.join(", ")
        );
    }
    println!();
}

fn main() -> Result<(), Box<dyn Error>> {
    // y' of the Lorenz system in weak form, 10 % noise, all monomials up to degree 4.
    let problem = problems::lorenz();
    let run = problem.noisy(10.0, 3)?.remove(0);
    let library = Library::polynomial(&["x", "y", "z"], 4)?;
    let mut samples = Samples::new(&["t", "x", "y", "z"]);
    samples.push_group([vec![run.time], run.states].concat())?;
    let weak = WeakForm::default().system(&library, "t", &["y"], &samples)?;
    let gram = weak.total(0);
    let rows = gram.weight();

    let p = library.len();
    let subsets: f64 = (0..=MOST)
        .map(|s| (0..s).fold(1.0, |n, k| n * (p - k) as f64 / (k + 1) as f64))
        .sum();
    println!("{p} terms: {subsets:.0} subsets of up to {MOST}\n");
    let exact = BestSubset::new().max_size(MOST).solve(&gram)?;
    print(&exact, library.names(), rows);
    // Proven is that no terms fit better, not that they are the true ones: that many is for a criterion to say, and it
    // needs to know that windows overlap. Some span / half-width of them are independent.
    let independent = problem.rows as f64 * problem.step / weak.half_width;
    for (count, rows) in [("all windows", rows), ("independent windows", independent)] {
        let choice = exact.choose(&gram, Criterion::Bic, Some(rows))?;
        println!(
            "counting {rows:.0} {count}, the Bayesian criterion takes {} terms",
            choice.fit.terms()
        );
    }
    println!();

    println!("stopped early, the gap that is left is stated:");
    let early = BestSubset::new()
        .max_size(MOST)
        .node_limit(2000)
        .solve(&gram)?;
    print(&early, library.names(), rows);

    // Greedy: the path of additions, each fitted by least squares.
    let (_, steps) = Stepwise::new(Direction::Forward, Criterion::Aic).path(&gram)?;
    let mut support = vec![false; p];
    let mut greedy = vec![(gram.yty / rows).sqrt()];
    for step in steps.iter().take(MOST) {
        support[step.term] = step.added;
        let xi = sindy::statistics::regression::least_squares(&gram, &support);
        greedy.push((gram.residual_sum(&xi) / rows).sqrt());
    }

    let sizes: Vec<f64> = (0..=MOST).map(|s| s as f64).collect();
    let rms = |found: &BestSubsets| -> Vec<f64> {
        (found.sizes.iter())
            .map(|s| (s.fit.residual_sum / rows).sqrt())
            .collect()
    };
    let bound: Vec<f64> = (early.sizes.iter())
        .map(|s| (s.lower_bound / rows).sqrt())
        .collect();
    let proven = rms(&exact);
    let picture = Figure::new(
        "05_certificate",
        "Lorenz, y': the best of every number of terms",
    )
    .panel(
        Panel::new("terms", "rms residual of y'")
            .log_y()
            .series(Series::band(
                "gap left after 2000 nodes",
                &sizes,
                &bound,
                &rms(&early),
            ))
            .series(Series::lines_points("best, proven", &sizes, &proven))
            .series(Series::lines_points(
                "greedy, one term at a time",
                &sizes[..greedy.len()],
                &greedy,
            ))
            .series(Series::vertical("true number", 3.0).color(Color::GREY)),
    );
    figure::save(&picture)
}
