//! Landings with ideal sensors, one at a time and by the lane, on one core: steps of the vehicle per
//! second of processor time. Runge–Kutta at 1 kHz, four rotors with their ground effect, a deck as
//! a spline, legs, attitude control at 500 Hz, the pilot at 100 Hz.
//!
//! Time is that of the thread on the processor (`/proc/thread-self/schedstat`, else the clock); the best
//! and the median of several runs are printed.
#![allow(clippy::print_stdout)]

mod common;

use std::time::Instant;

use common::processor_s;
use touchdown_sim::air::wind::{DrydenSettings, WindSettings};
use touchdown_sim::landing::space::{Batch, Case, SpaceScenario};

const LANDINGS: u64 = 192;
const RUNS: usize = 9;

fn main() {
    let turbulent = Case::Paper.scenario();
    let waves = SpaceScenario {
        turbulence: false,
        ..turbulent.clone()
    };
    let sea = SpaceScenario {
        wind: WindSettings {
            steady_mps: [1.0, 0.0, 0.0],
            dryden: DrydenSettings::low_altitude(6.0, 3.0).ok(),
            gust: None,
            airwake: None,
        },
        ..Case::Sea.scenario()
    };
    println!(
        "million steps per second of processor time, best (median): one at a time, by the lane"
    );
    for (name, scenario) in [
        ("the paper's deck", waves),
        ("+ turbulence", turbulent),
        ("a sea of 100 waves, + Dryden gusts", sea),
    ] {
        let batch = Batch::new(&scenario).expect("a valid scenario");
        let start = Instant::now();
        let speed = |by_lane: bool| {
            let mut speeds: Vec<f64> = (0..RUNS)
                .map(|_| {
                    let before = processor_s(start);
                    let landings = if by_lane {
                        batch.land(0..LANDINGS, 1).expect("a checked scenario")
                    } else {
                        let one = |trial| batch.land_one(trial, 1).expect("a checked scenario");
                        (0..LANDINGS / 8).map(one).collect()
                    };
                    let landed = landings.iter().filter(|l| l.outcome.landed()).count();
                    assert!(10 * landed >= 9 * landings.len(), "{landed} landed");
                    let steps: u64 = landings.iter().map(|landing| landing.steps).sum();
                    1e-6 * steps as f64 / (processor_s(start) - before)
                })
                .collect();
            speeds.sort_by(f64::total_cmp);
            (speeds[RUNS - 1], speeds[RUNS / 2])
        };
        let (one, lanes) = (speed(false), speed(true));
        println!(
            "{name:36} {:6.2} ({:.2}) {:6.2} ({:.2})",
            one.0, one.1, lanes.0, lanes.1
        );
    }
}
