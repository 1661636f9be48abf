//! Thousands of landings on one core, with ideal sensors, side by side in the lanes of the
//! processor's vectors:
//!
//! ```text
//! cargo run --release -p touchdown-sim --example batch_landings -- [TRIALS [SEED]]
//! ```
//!
//! Prints for the paper's deck, a stronger heave with roll and a sea how many of the landings succeed, and
//! mean and percentiles of their durations T_L and touchdown speeds V_L. What it prints is the
//! same on every processor.
#![allow(clippy::print_stdout)]

use touchdown_sim::landing::space::{Batch, Case, SpaceLanding, Touch};

/// Mean, median, 99th percentile and the greatest.
fn spread(landings: &[SpaceLanding], of: impl Fn(&Touch) -> f64) -> [f64; 4] {
    let landed = landings.iter().filter(|landing| landing.outcome.landed());
    let mut values: Vec<f64> = landed.filter_map(|l| l.touch.as_ref()).map(of).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    let at = |share: f64| values.get((share * last).round() as usize).copied();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    [Some(mean), at(0.5), at(0.99), at(1.0)].map(|value| value.unwrap_or(f64::NAN))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: u64| words.get(k).map_or(Ok(or), |word| word.parse::<u64>());
    let (trials, seed) = (number(0, 2_000)?, number(1, 1)?);
    println!("{trials} landings each, seed {seed}: mean, 50 %, 99 %, greatest");
    for case in [Case::Paper, Case::Heave, Case::Sea] {
        let batch = Batch::new(&case.scenario())?;
        let landings = batch.land(0..trials, seed)?;
        let landed = landings.iter().filter(|l| l.outcome.landed()).count();
        let steps: u64 = landings.iter().map(|landing| landing.steps).sum();
        println!("{}: {landed} landed, {steps} steps of 1 ms", case.name());
        for (what, [mean, middle, high, greatest]) in [
            ("T_L s", spread(&landings, |touch| touch.t_l_s)),
            ("V_L m/s", spread(&landings, |touch| touch.v_l_mps)),
            ("lateral m", spread(&landings, |touch| touch.lateral_m)),
        ] {
            println!("  {what:10} {mean:7.4} {middle:7.4} {high:7.4} {greatest:7.4}");
        }
    }
    Ok(())
}
