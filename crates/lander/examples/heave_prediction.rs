//! Accuracy of the deck estimator's predictions of displacement, velocity, acceleration:
//! errors relative to the motion, and how often the truth lies within 1.96 standard
//! deviations.
//!
//! `cargo run --release -p touchdown-lander --example heave_prediction`
#![allow(clippy::print_stdout, unreachable_pub)]

#[path = "../tests/common/deck.rs"]
mod deck;
#[path = "../tests/common/noise.rs"]
mod noise;

use deck::{Score, Sines, paper_deck, run};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};

/// A motion for each run.
type Motion = fn(u64) -> Sines;

fn two_tones(seed: u64) -> Sines {
    let phase = seed as f64;
    Sines(vec![[0.05, 3.0, 0.7 * phase], [0.03, 5.1, 1.3 * phase]])
}

fn main() {
    let sources = [
        ("5 mm", Observed::Displacement, 0.005),
        ("0.03 m/s", Observed::Velocity, 0.03),
    ];
    let motions: [(&str, Motion, [[f64; 2]; 2]); 3] = [
        (
            "0.05 m, 0.5 Hz",
            |seed| paper_deck(0.7 * seed as f64),
            [[6.0, 15.0], [20.0, 60.0]],
        ),
        ("two tones", two_tones, [[6.0, 15.0], [20.0, 60.0]]),
        (
            "JONSWAP 6 s, 0.5 m",
            |seed| Sines::jonswap(0.5, 6.0, seed),
            [[15.0, 30.0], [40.0, 120.0]],
        ),
    ];
    println!("motion, readings, seconds seen, ahead: relative error | coverage");
    for (name, motion, spans) in motions {
        for (reading, observed, sd) in sources {
            let estimator = DeckEstimator::new(observed, sd);
            for span in spans {
                for horizon in [1.0, 2.0] {
                    let mut score = Score::default();
                    for seed in 0..12 {
                        run(
                            &estimator,
                            &motion(seed),
                            100 + seed,
                            span,
                            horizon,
                            &mut score,
                        );
                    }
                    println!(
                        "{name}, {reading}, {span:?} s, {horizon} s: {:.3?} | {:.3?}",
                        score.relative(),
                        score.coverage()
                    );
                }
            }
        }
    }
}
