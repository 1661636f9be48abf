//! How often the intervals of a ground effect hold the truth where the flights are hard: vehicles of 30 g and 4 kg, throttles
//! that are logged slowly or late, heights that are the autopilot's estimate, decks that heave, and late accelerometers.
//!
//! ```text
//! cargo run --release -p touchdown-identify --example flight_cases -- SETS FIRST_SET [CASE] >> sets.txt
//! cargo run --release -p touchdown-identify --example flight_coverage -- table sets.txt
//! ```
//!
//! The lines are those of `flight_coverage`, with the case in place of the law.

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

#[path = "../tests/common/vertical.rs"]
mod vertical;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use vertical::found::identify;
use vertical::{Vehicle, uniform};

/// Flights of a set.
const FLIGHTS: u64 = 4;
const CASES: [&str; 28] = [
    "30g",
    "30g-poses",
    "4kg",
    "4kg-poses",
    "slow-throttle",
    "slow-throttle-poses",
    "filtered",
    "filtered-poses",
    "deck",
    "deck-velocity",
    "between-rows",
    "late-throttle",
    "seldom-throttle",
    "late-accelerometer",
    "filtered-accelerometer",
    "later-accelerometer",
    "smoothed-accelerometer",
    "late-0.04-accelerometer",
    "late-0.05-accelerometer",
    "late-0.08-accelerometer",
    "late-0.1-accelerometer",
    "filtered-5hz-accelerometer",
    "smoothed-0.04-accelerometer",
    "late-0.05-accelerometer-deck",
    "late-0.1-range",
    "late-0.05-range",
    "filtered-10hz-accelerometer",
    "filtered-15hz-accelerometer",
];

fn main() -> std::io::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: u64| {
        let given = args.get(k).map(|n| n.parse().expect("a whole number"));
        given.unwrap_or(or)
    };
    let (sets, first) = (number(0, 1), number(1, 1));
    for set in first..first + sets {
        for (index, case) in CASES.iter().enumerate() {
            if args.get(2).is_none_or(|only| only == case) {
                // Seeds of a set and a case of its own.
                let index = index as u64;
                judge(
                    case,
                    100 * (1_000_000 * (7 + index / 6) + 6 * set + index % 6),
                )?;
            }
        }
    }
    Ok(())
}

/// Prints what came of one set of flights, one line for each quantity.
fn judge(case: &str, seed: u64) -> std::io::Result<()> {
    let vehicle = drawn(case, &mut Pcg64::seed_from_u64(seed));
    let head = format!(
        "{seed} {} {} {} {case}",
        vehicle.accelerometer,
        1e3 * vehicle.range_noise_m,
        vehicle.log_hz
    );
    identify(&vehicle, seed, FLIGHTS).print(&head, &vehicle)
}

/// The vehicle of a case.
fn drawn(case: &str, random: &mut Pcg64) -> Vehicle {
    let accelerometer = !case.ends_with("-poses");
    let case = case.trim_end_matches("-poses");
    if case == "30g" {
        return Vehicle::draw_30_g(random, accelerometer);
    }
    let usual = Vehicle::draw(random, accelerometer, 0.002, 50.0);
    let mut between = |low, high| uniform(random, low, high);
    let late = |accelerometer_late_s| Vehicle {
        accelerometer_late_s,
        ..usual
    };
    match case {
        "4kg" => Vehicle {
            rotor_radius_m: between(0.18, 0.24),
            wake_lag_s: between(0.12, 0.35),
            motor_lag_s: between(0.06, 0.12),
            turbulence_mps2: between(0.05, 0.15),
            ..usual
        },
        // A complementary filter of range and accelerometer, in every row.
        "filtered" => Vehicle {
            filtered_height: true,
            ..usual
        },
        // The ground heaves as the deck of a small vessel does; the log has no inertial velocity, or that of a filter.
        "deck" | "deck-velocity" => Vehicle {
            ground_mps: usual.rotor_radius_m * between(0.15, 0.5),
            ground_period_s: between(1.8, 6.0),
            filtered_climb: case == "deck-velocity",
            ..usual
        },
        // 500, 250 or 100 commands a second, in rows of 100 or 50 Hz.
        "between-rows" => {
            let (log_hz, commands_a_row) =
                [(100.0, 5), (50.0, 5), (50.0, 2)][(between(0.0, 3.0) as usize).min(2)];
            Vehicle {
                log_hz,
                commands_a_row,
                ..usual
            }
        }
        // Acceleration at 100 Hz or more, and the throttle of a slower stream, whose commands change in every row.
        "seldom-throttle" => {
            let (log_hz, rows_a_throttle) =
                [(100.0, 2), (200.0, 4), (100.0, 4)][(between(0.0, 3.0) as usize).min(2)];
            Vehicle {
                log_hz,
                rows_a_throttle,
                ..usual
            }
        }
        // The autopilot reports in a row of 10 ms what it commanded before.
        "late-throttle" => Vehicle {
            throttle_late_s: between(0.0, 0.009),
            ..usual
        },
        // Stamps of the receiver, or of the end of an average.
        "late-accelerometer" => Vehicle {
            accelerometer_late_s: 0.005,
            ..usual
        },
        "later-accelerometer" => Vehicle {
            accelerometer_late_s: 0.015,
            ..usual
        },
        // A logger without time stamps.
        "late-0.04-accelerometer" => late(0.04),
        "late-0.05-accelerometer" => late(0.05),
        "late-0.08-accelerometer" => late(0.08),
        "late-0.1-accelerometer" => late(0.1),
        // Second order with a cutoff of 5 Hz: 45 ms.
        "filtered-5hz-accelerometer" => Vehicle {
            accelerometer_cutoff_hz: 5.0,
            ..usual
        },
        // 23 and 15 ms.
        "filtered-10hz-accelerometer" => Vehicle {
            accelerometer_cutoff_hz: 10.0,
            ..usual
        },
        "filtered-15hz-accelerometer" => Vehicle {
            accelerometer_cutoff_hz: 15.0,
            ..usual
        },
        // First order with a cutoff of 4 Hz: 40 ms.
        "smoothed-0.04-accelerometer" => Vehicle {
            accelerometer_lag_s: 0.04,
            ..usual
        },
        // Above a ground that moves.
        "late-0.05-accelerometer-deck" => Vehicle {
            ground_mps: usual.rotor_radius_m * between(0.15, 0.5),
            ground_period_s: between(1.8, 6.0),
            ..late(0.05)
        },
        // A range finder without time stamps, by which the autopilot flies as well.
        "late-0.05-range" => Vehicle {
            range_late_s: 0.05,
            ..usual
        },
        "late-0.1-range" => Vehicle {
            range_late_s: 0.1,
            ..usual
        },
        // The cutoff that PX4 has by default: 7.5 ms.
        "filtered-accelerometer" => Vehicle {
            accelerometer_cutoff_hz: 30.0,
            ..usual
        },
        // First order with a cutoff of 20 Hz: 8 ms.
        "smoothed-accelerometer" => Vehicle {
            accelerometer_lag_s: 0.008,
            ..usual
        },
        // Logged at the rates that are the least for a lag.
        _ => Vehicle {
            log_hz: [40.0, 50.0, 62.5, 80.0][(between(0.0, 4.0) as usize).min(3)],
            range_hz: 40.0,
            ..usual
        },
    }
}
