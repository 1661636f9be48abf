//! How often the intervals of a ground effect from flights hold the truth, by range noise, its rate and the accelerometer.
//!
//! Vehicles, sensors and pilot are those of `tests/common/vertical.rs`, which shares nothing with the simulator. Every set of
//! flights has a vehicle and seeds of its own, so all intervals are independent. Sets print as they end, one line for each
//! quantity; `table` pools the lines of any number of such files.
//!
//! ```text
//! cargo run --release -p touchdown-identify --example flight_coverage -- run ROUNDS FIRST_ROUND FLIGHTS [CELL] >> sets.txt
//! cargo run --release -p touchdown-identify --example flight_coverage -- table sets.txt...
//! ```
//!
//! A round has 36 cells: for each noise and rate of the range, two sets with accelerometer and one without. The zero of heights
//! differs from flight to flight by what the settings expect, 0.15 rotor radii.

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

#[path = "flight_coverage/table.rs"]
mod table;
#[path = "../tests/common/vertical.rs"]
mod vertical;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use touchdown_identify::flights::FlightSettings;
use vertical::Vehicle;

/// Noise of the range (m), standard deviation.
const NOISES_M: [f64; 4] = [0.0005, 0.002, 0.004, 0.010];
/// Rates of the range (Hz).
const RATES_HZ: [f64; 3] = [25.0, 50.0, 100.0];
/// Whether the sets of a round have an accelerometer: two of three, because only these give a climb damping.
const ACCELEROMETERS: [bool; 3] = [true, false, true];

fn main() -> std::io::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.split_first() {
        Some((what, files)) if what == "table" => table::print(files),
        Some((what, numbers)) if what == "run" => {
            let number = |k: usize, or: u64| {
                let given = numbers.get(k).map(|n| n.parse().expect("a whole number"));
                given.unwrap_or(or)
            };
            let (rounds, first, flights) = (number(0, 1), number(1, 1), number(2, 4));
            let only = (numbers.len() > 3).then(|| number(3, 0));
            for round in first..first + rounds {
                run(round, flights, only)?;
            }
            Ok(())
        }
        _ => {
            println!("flight_coverage run [ROUNDS] [FIRST_ROUND] [FLIGHTS] [CELL] | table FILE...");
            Ok(())
        }
    }
}

/// Flies and identifies the sets of a round, or one of them.
fn run(round: u64, flights: u64, only: Option<u64>) -> std::io::Result<()> {
    let mut cell = 0;
    for accelerometer in ACCELEROMETERS {
        for noise_m in NOISES_M {
            for hz in RATES_HZ {
                // No two sets share a seed: a round has 36 sets of at most a hundred flights.
                let seed = 100 * (1_000_000 + 36 * round + cell);
                let asked = only.is_none_or(|c| c == cell);
                cell += 1;
                if !asked {
                    continue;
                }
                let mut random = Pcg64::seed_from_u64(seed);
                let vehicle = Vehicle {
                    height_error_radii: FlightSettings::default().height_bias_radii,
                    ..Vehicle::draw(&mut random, accelerometer, noise_m, hz)
                };
                set(&vehicle, seed, flights)?;
            }
        }
    }
    Ok(())
}

/// Prints what came of a set of flights, one line for each quantity.
fn set(vehicle: &Vehicle, seed: u64, flights: u64) -> std::io::Result<()> {
    let head = format!(
        "{seed} {} {} {} {:?}",
        vehicle.accelerometer,
        1e3 * vehicle.range_noise_m,
        vehicle.range_hz,
        vehicle.law
    );
    vertical::found::identify(vehicle, seed, flights).print(&head, vehicle)
}
