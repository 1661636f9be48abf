//! Whole landings one after the other, one core: steps of the vehicle per second of processor time,
//! sensors, estimators, planner, state machine, pilot and attitude control included.
//!
//! Time is that of the thread on the processor (`/proc/thread-self/schedstat`, else the clock); the best
//! and the median of several runs are printed.
#![allow(clippy::print_stdout)]

use std::time::Instant;

use touchdown_sim::deck::rigid::{Axis, RigidMotion, Tone};
use touchdown_sim::space::{SpaceLander, SpaceScenario};

const LANDINGS: u64 = 12;
const RUNS: usize = 9;

/// Time of this thread on the processor, s; the clock's where the system does not tell.
fn processor_s(start: Instant) -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

fn main() {
    let tone = Tone {
        axis: Axis::Heave,
        amplitude: 0.05,
        frequency_hz: 0.5,
        phase_rad: 0.0,
    };
    let scenario = SpaceScenario {
        deck: RigidMotion::Sines { tones: vec![tone] },
        ..SpaceScenario::default()
    };
    let lander = SpaceLander::new(&scenario).expect("a valid scenario");
    let start = Instant::now();
    let mut speeds: Vec<f64> = (0..RUNS)
        .map(|_| {
            let before = processor_s(start);
            let land = |trial| lander.land(trial, 1, false).expect("a checked scenario");
            let steps: u64 = (0..LANDINGS).map(|trial| land(trial).steps).sum();
            steps as f64 / (processor_s(start) - before)
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    println!(
        "whole landings: {:.2} million steps per second of processor time (median {:.2})",
        1e-6 * speeds[RUNS - 1],
        1e-6 * speeds[RUNS / 2]
    );
}
