//! Whole landings one after the other, one core: steps of the vehicle per second of processor time,
//! sensors, estimators, planner, state machine, pilot and attitude control included.
//!
//! Time is that of the thread on the processor (`/proc/thread-self/schedstat`, else the clock); the best
//! and the median of several runs are printed.
#![allow(clippy::print_stdout)]

mod common;

use std::time::Instant;

use common::processor_s;
use touchdown_sim::landing::space::{Case, SpaceLander};

const LANDINGS: u64 = 12;
const RUNS: usize = 9;

fn main() {
    let lander = SpaceLander::new(&Case::Paper.scenario()).expect("a valid scenario");
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
