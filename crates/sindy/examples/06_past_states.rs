//! Past inputs: a heated room whose heater acts after a delay, in discrete time.
//!
//! `cargo run --release -p sindy --example 06_past_states [FOLDER]`
#![allow(clippy::print_stdout)]

mod figure;

use std::error::Error;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use sindy::model::{Limits, Model, Term, Time};
use sindy::solve::exact::BestBy;
use sindy::trajectory::shift::{Delay, chain, next, past};
use sindy::{BestSubset, Criterion, Gram, Library, Samples, Solver};
use touchdown_report::{Color, Figure, Panel, Series};

/// Samples until the heater's work is felt.
const DELAY: usize = 7;
/// Time from one sample to the next, in minutes.
const PERIOD: f64 = 1.0;

/// Switching times that look irregular: on where the sum of three sines is above zero.
fn heater(k: usize, phase: f64) -> f64 {
    let t = k as f64 + phase;
    let sum = (0.11 * t).sin() + (0.047 * t).sin() + (0.29 * t).sin();
    if sum > 0.0 { 1.0 } else { 0.0 }
}

/// T[k+1] = 0.95 T[k] + 0.8 u[k-7] - 0.002 T[k]^2, disturbed.
fn room(rows: usize, phase: f64, seed: u64) -> Result<[Vec<f64>; 2], Box<dyn Error>> {
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let u: Vec<f64> = (0..rows).map(|k| heater(k, phase)).collect();
    let mut t = vec![5.0];
    for k in 0..rows - 1 {
        let past = if k >= DELAY { u[k - DELAY] } else { 0.0 };
        let noise: f64 = StandardNormal.sample(&mut random);
        t.push(0.95 * t[k] + 0.8 * past - 0.002 * t[k] * t[k] + 0.05 * noise);
    }
    Ok([t, u])
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut samples = Samples::new(&["T", "u"]);
    samples.push_group(room(3000, 0.0, 1)?.to_vec())?;

    // Candidates: what the heater did 1 to 12 samples ago, beside the present.
    let delays = Delay::parse("u@1..12")?;
    let with_past = past(&samples, &delays, None)?;
    let pairs = next(&with_past.samples, &["T"], None, None)?;
    let mut terms: Vec<String> = ["1", "T", "T^2", "T^3", "u"].map(String::from).to_vec();
    terms.extend(with_past.added.iter().cloned());
    let library = Library::parse(&terms)?;
    let gram = Gram::total(&Gram::accumulate(&library, "T_next", &pairs.samples)?);

    let all = sindy::statistics::regression::least_squares(&gram, &vec![true; terms.len()]);
    let search = BestSubset::new();
    let fit = BestBy {
        search,
        criterion: Criterion::Bic,
    }
    .fit(&gram)?;

    // The past inputs become states, so that the model runs by itself.
    let (older, shifts) = chain(&delays)?;
    let states = [vec!["T".to_string()], older].concat();
    let equation = Term::of_library(&library, fit.coefficients.as_slice())?;
    let equations = [vec![equation], shifts].concat();
    let model = Model::new(
        Time::Discrete { period: PERIOD },
        &states,
        &["u".to_string()],
        equations,
    )?;
    let text = format!("{model:.3}");
    println!("{}\n", text.lines().next().unwrap_or_default());

    // Another day: a free run over 300 minutes against what happens.
    let [truth, u] = room(300, 555.0, 2)?;
    let mut start = vec![0.0; states.len()];
    start[0] = truth[0];
    let run = model.iterate(&start, u.len() - 1, &[&u], &Limits::default())?;
    let wrong: f64 = (run.states[0].iter().zip(&truth))
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    println!(
        "free run on another day: rms error {:.2} degrees\n",
        (wrong / truth.len() as f64).sqrt()
    );

    let ago: Vec<f64> = (0..=12).map(f64::from).collect();
    let of = |xi: &[f64]| xi[4..].to_vec(); // u, u_ago1, …
    let minutes: Vec<f64> = (0..u.len()).map(|k| k as f64 * PERIOD).collect();
    let picture = Figure::new("06_past_states", "A heater that acts after seven minutes")
        .size(900, 640)
        .panel(
            Panel::new("minutes ago", "weight of the heater")
                .series(Series::bars("all terms", &ago, &of(all.as_slice())).color(Color::GREY))
                .series(Series::bars(
                    "best subset",
                    &ago,
                    &of(fit.coefficients.as_slice()),
                )),
        )
        .panel(
            Panel::new("time (min)", "temperature (K above outside)")
                .series(
                    Series::line("measured", &minutes, &truth)
                        .color(Color::GREY)
                        .width(2.5),
                )
                .series(Series::dashed("free run", &minutes, &run.states[0]))
                .series(Series::steps("heater", &minutes, &u)),
        );
    figure::save(&picture)
}
