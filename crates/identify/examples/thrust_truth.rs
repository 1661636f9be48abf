//! Thrust stands with known truth: how far identified lags, dead times and curves are from it, and how often their 95 %
//! intervals hold it.
//!
//! ```text
//! cargo run --release -p touchdown-identify --example thrust_truth -- [LOGS per case] [SEED]
//! ```
//!
//! The stands are no part of the simulator: a command that changes at times of its own, a dead time, rotors whose speed
//! follows with one lag, a load cell with white or wandering noise and a resolution. Each log has its own vehicle, drawn
//! from the ranges below. Coverage is over all logs of a case that state an interval.

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use touchdown_identify::settings::ThrustForm;
use touchdown_identify::{IdentificationSettings, Origin, thrust};
use touchdown_model::Card;
use touchdown_trial::Trial;

#[path = "thrust_truth/stand.rs"]
mod stand;

use stand::{Command, Noise, Stand};

/// A stand, the form that is fitted to its logs, and what of it is compared.
struct Case {
    name: &'static str,
    command: Command,
    rate_hz: f64,
    noise: Noise,
    form: ThrustForm,
}

const WHITE: Noise = Noise {
    sd_share: 0.01,
    memory_s: 0.0,
};
const WANDERING: Noise = Noise {
    sd_share: 0.01,
    memory_s: 0.05,
};
const QUIET: Noise = Noise {
    sd_share: 0.001,
    memory_s: 0.0,
};

const fn case(
    name: &'static str,
    command: Command,
    rate_hz: f64,
    noise: Noise,
    form: ThrustForm,
) -> Case {
    Case {
        name,
        command,
        rate_hz,
        noise,
        form,
    }
}

const CASES: [Case; 13] = [
    case(
        "steps, 50 Hz",
        Command::Steps,
        50.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 100 Hz",
        Command::Steps,
        100.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 200 Hz",
        Command::Steps,
        200.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 100 Hz, wandering noise",
        Command::Steps,
        100.0,
        WANDERING,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 100 Hz, quiet",
        Command::Steps,
        100.0,
        QUIET,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 100 Hz, logger's clock",
        Command::FreeSteps,
        100.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "steps, 50 Hz, logger's clock",
        Command::FreeSteps,
        50.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "sines, 50 Hz",
        Command::Sines,
        50.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "sines, 100 Hz, wandering noise",
        Command::Sines,
        100.0,
        WANDERING,
        ThrustForm::FirstOrder,
    ),
    case(
        "motors, 100 Hz",
        Command::Motors,
        100.0,
        WHITE,
        ThrustForm::LaggedMotors,
    ),
    case(
        "motors, 200 Hz, wandering noise",
        Command::Motors,
        200.0,
        WANDERING,
        ThrustForm::LaggedMotors,
    ),
    case(
        "ramp, 8 Hz",
        Command::Ramp,
        8.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
    case(
        "ramp, 50 Hz",
        Command::Ramp,
        50.0,
        WHITE,
        ThrustForm::FirstOrder,
    ),
];

/// An estimate beside its truth.
#[derive(Clone, Copy)]
struct Compared {
    error: f64,
    /// Whether the interval, or the upper bound, holds the truth; none where there is neither.
    holds: Option<bool>,
    bounded: bool,
}

fn compared(card: &Card, of: &str, expression: &str, truth: f64) -> Compared {
    let term = card
        .terms
        .iter()
        .find(|t| t.of == of && t.expression == expression);
    let value = term.map_or(0.0, |t| t.value);
    let within = term
        .and_then(|t| t.ci95)
        .map(|[low, high]| low <= truth && truth <= high);
    let below = term.and_then(|t| t.upper_bound).map(|bound| truth <= bound);
    Compared {
        error: value - truth,
        holds: within.or(below),
        bounded: below.is_some(),
    }
}

fn fitted(case: &Case, stand: &Stand) -> Option<Card> {
    let log: Trial = stand.log(case.command, case.rate_hz, case.noise)?;
    let mut settings = IdentificationSettings::default();
    settings.thrust.form = Some(case.form);
    let made = thrust::fit(&[log], &settings, &Origin::default()).ok()?;
    Some(made.card)
}

/// One line of the table.
fn line(case: &Case, quantity: &str, logs: usize, all: &[Compared]) -> String {
    let n = all.len().max(1) as f64;
    let bias = all.iter().map(|c| c.error).sum::<f64>() / n;
    let rmse = (all.iter().map(|c| c.error * c.error).sum::<f64>() / n).sqrt();
    let judged: Vec<bool> = all.iter().filter_map(|c| c.holds).collect();
    let held = judged.iter().filter(|h| **h).count();
    let coverage = held as f64 / judged.len().max(1) as f64;
    let refused = 1.0 - judged.len() as f64 / logs as f64;
    let bounded = all.iter().filter(|c| c.bounded).count() as f64 / logs as f64;
    format!(
        "| {} | {quantity} | {bias:+.5} | {rmse:.5} | {coverage:.3} of {} | {:.0} % | {:.0} % |",
        case.name,
        judged.len(),
        100.0 * bounded,
        100.0 * refused
    )
}

fn main() {
    let mut args = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse::<u64>().ok());
    let logs = args.next().unwrap_or(40) as usize;
    let seed = args.next().unwrap_or(900_001);
    println!("| case | quantity | bias | RMSE | 95 % coverage | upper bound only | refused |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut pooled: Vec<(&str, Vec<bool>)> = Vec::new();
    for (index, case) in CASES.iter().enumerate() {
        let found: Vec<Option<[(&str, Compared); 4]>> = (0..logs)
            .into_par_iter()
            .map(|k| {
                let stand = Stand::draw(
                    Pcg64::seed_from_u64(seed + 1000 * index as u64 + k as u64),
                    case.command,
                );
                let card = fitted(case, &stand)?;
                let [a, b] = stand.line(case.form);
                Some([
                    ("T_m (s)", compared(&card, "T_m", "1", stand.lag_s)),
                    (
                        "dead time (s)",
                        compared(&card, "dead_time", "1", stand.dead_time_s),
                    ),
                    ("constant", compared(&card, a.0, a.1, a.2)),
                    ("slope", compared(&card, b.0, b.1, b.2)),
                ])
            })
            .collect();
        for q in 0..4 {
            let all: Vec<Compared> = found.iter().flatten().map(|f| f[q].1).collect();
            let name = found.iter().flatten().map(|f| f[q].0).next().unwrap_or("");
            println!("{}", line(case, name, logs, &all));
            let held = all.iter().filter_map(|c| c.holds);
            match pooled.iter_mut().find(|p| p.0 == name) {
                Some(p) => p.1.extend(held),
                None => pooled.push((name, held.collect())),
            }
        }
    }
    for (name, held) in pooled {
        let n = held.len().max(1) as f64;
        let share = held.iter().filter(|h| **h).count() as f64 / n;
        let half = 1.96 * (share * (1.0 - share) / n).sqrt();
        println!(
            "| all | {name} | | | {share:.3} ± {half:.3} of {} | | |",
            held.len()
        );
    }
}

/// A draw from a normal law of mean 0.
fn normal(random: &mut Pcg64, sd: f64) -> f64 {
    Normal::new(0.0, sd).map_or(0.0, |law| law.sample(random))
}

/// A draw between two numbers.
fn between(random: &mut Pcg64, [low, high]: [f64; 2]) -> f64 {
    random.random_range(low..high)
}
