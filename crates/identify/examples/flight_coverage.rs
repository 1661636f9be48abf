//! How often the intervals of a ground effect from flights hold the truth, by range noise, its rate and the accelerometer.
//!
//! Vehicle, sensors and pilot are those of `tests/common/vertical.rs`, which shares nothing with the simulator.
//!
//! ```text
//! cargo run --release -p touchdown-identify --example flight_coverage -- [sets] [first set] [flights] [noise m] [Hz]
//! ```

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

#[path = "../tests/common/vertical.rs"]
mod vertical;

use touchdown_identify::estimate::Estimate;
use vertical::{Cell, QUANTITIES, Vehicle};

#[derive(Default, Clone)]
struct Tally {
    errors: Vec<f64>,
    half_widths: Vec<f64>,
    held: usize,
    missing: usize,
}

impl Tally {
    fn count(&mut self, truth: f64, found: Option<Estimate>) {
        let Some(found) = found else {
            self.missing += 1;
            return;
        };
        let [low, high] = found.ci95;
        self.errors.push(found.value - truth);
        self.half_widths.push(0.5 * (high - low));
        self.held += usize::from(low <= truth && truth <= high);
    }
}

fn main() {
    let args: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse().expect("numbers"))
        .collect();
    let number = |k: usize, or: f64| args.get(k).copied().unwrap_or(or);
    let [sets, first, flights] = [(0, 4.0), (1, 1.0), (2, 6.0)].map(|(k, or)| number(k, or) as u64);
    let asked = |k: usize, value: f64| args.get(k).is_none_or(|&a| a == value);
    println!(
        "accelerometer  noise mm   Hz  quantity     truth     bias    rmse  half width  held      missing  refused"
    );
    for accelerometer in [true, false] {
        for noise_m in [0.0005, 0.002, 0.004, 0.010] {
            for hz in [25.0, 50.0, 100.0] {
                if asked(3, noise_m) && asked(4, hz) {
                    let vehicle = Vehicle {
                        accelerometer,
                        range_noise_m: noise_m,
                        range_hz: hz,
                        ..Vehicle::default()
                    };
                    cell(&vehicle, first..first + sets, flights);
                }
            }
        }
    }
}

fn cell(vehicle: &Vehicle, sets: std::ops::Range<u64>, flights: u64) {
    let truth = vehicle.truth();
    let mut tally = vec![Tally::default(); QUANTITIES.len()];
    let (mut refused, count) = (0, sets.end - sets.start);
    for set in sets {
        match vertical::identify(vehicle, 10_000 + 100 * set, flights) {
            Cell::Found(found) => {
                for ((tally, truth), found) in tally.iter_mut().zip(truth).zip(*found) {
                    tally.count(truth, found);
                }
            }
            Cell::Refused(_) => refused += 1,
        }
    }
    for ((name, truth), t) in QUANTITIES.iter().zip(truth).zip(tally) {
        let n = t.errors.len() as f64;
        let bias = t.errors.iter().sum::<f64>() / n;
        let rmse = (t.errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        let half = t.half_widths.iter().sum::<f64>() / n;
        println!(
            "{:13}  {:8.1} {:4.0}  {name:11} {truth:7.4}  {bias:+7.4}  {rmse:6.4}  {half:10.4}  {:>3} of {:<3}  {:7}  {refused} of {count}",
            vehicle.accelerometer,
            1e3 * vehicle.range_noise_m,
            vehicle.range_hz,
            t.held,
            t.errors.len(),
            t.missing,
        );
    }
}
