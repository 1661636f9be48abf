//! Whether the routes to a ground effect check one another: flights of independent vehicles with accelerometer, rotor speed and a
//! thrust card, all right, or one of them wrong.
//!
//! | case | what is wrong |
//! | --- | --- |
//! | `right` | nothing |
//! | `scale` | the accelerometer reads 10 % too much |
//! | `card` | the thrust card is that of a vehicle whose thrust goes with throttle to another power |
//! | `no-accelerometer` | nothing; the logs have no accelerometer |
//!
//! ```text
//! cargo run --release -p touchdown-identify --example route_truth -- SETS FIRST_SET [CASE] >> routes.txt
//! ```
//!
//! A line for each route of each set: case, set, route, taken or not, then for 0.5, 1 and 2 rotor radii value, interval and
//! truth (%); at the end whether a warning names a difference.

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

#[path = "../tests/common/vertical.rs"]
mod vertical;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use touchdown_identify::flights::{FlightSettings, Route, ground_effect_by_routes};
use touchdown_trial::Trial;
use vertical::{Vehicle, another, fly, thrust_card};

/// Flights of a set.
const FLIGHTS: u64 = 4;
/// Noise (m) and rate (Hz) of the range, which sets take in turn.
const RANGES: [[f64; 2]; 4] = [[0.002, 50.0], [0.004, 100.0], [0.0005, 25.0], [0.010, 50.0]];

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: u64| {
        let given = args.get(k).map(|n| n.parse().expect("a whole number"));
        given.unwrap_or(or)
    };
    let (sets, first) = (number(0, 4), number(1, 1));
    for set in first..first + sets {
        for case in ["right", "scale", "card", "no-accelerometer"] {
            if args.get(2).is_none_or(|only| only == case) {
                judge(case, set);
            }
        }
    }
}

/// Prints what came of one set of flights.
fn judge(case: &str, set: u64) {
    let seed = 100 * (5_000_000 + set);
    let [noise_m, hz] = RANGES[set as usize % RANGES.len()];
    let mut random = Pcg64::seed_from_u64(seed);
    let mut vehicle = Vehicle::draw(&mut random, case != "no-accelerometer", noise_m, hz);
    vehicle.rotor_speed = true;
    let trials: Vec<Trial> = (seed..seed + FLIGHTS)
        .map(|seed| fly(&vehicle, seed))
        .map(|trial| {
            if case == "scale" {
                scaled(trial)
            } else {
                trial
            }
        })
        .collect();
    let card = match case {
        "card" => thrust_card(&another(&vehicle)),
        _ => thrust_card(&vehicle),
    };
    let settings = FlightSettings {
        rotor_radius_m: Some(vehicle.rotor_radius_m),
        ..FlightSettings::default()
    };
    let trials: Vec<&Trial> = trials.iter().collect();
    match ground_effect_by_routes(&trials, &settings, Some(&card)) {
        Err(error) => println!("{case} {set} refused: {error}"),
        Ok(routed) => {
            let truth = vehicle.lifts(settings.reference_radii);
            for route in &routed.routes {
                print(case, set, route, truth);
            }
            println!("{case} {set} warnings {}", routed.warnings.len());
            for warning in &routed.warnings {
                println!("{case} {set} warning: {warning}");
            }
        }
    }
}

/// The trial with an accelerometer that reads a tenth too much.
fn scaled(mut trial: Trial) -> Trial {
    if let Some(force) = trial.channel("specific_force_mps2") {
        let force = force.iter().map(|f| 1.1 * f).collect();
        trial.insert("specific_force_mps2", force).expect("as long");
    }
    trial
}

fn print(case: &str, set: u64, route: &Route, truth: [f64; 3]) {
    let taken = if route.taken { "taken" } else { "-" };
    print!(
        "{case} {set} {} {taken}",
        route.basis.name().replace(' ', "_")
    );
    for (radii, truth) in [0.5, 1.0, 2.0].into_iter().zip(truth) {
        let found = route.extra_lift.iter().find(|at| at.radii == radii);
        match found.map(|at| at.lift) {
            Some(e) => {
                let held = (e.ci95[0]..=e.ci95[1]).contains(&truth);
                let [value, low, high, truth] =
                    [e.value, e.ci95[0], e.ci95[1], truth].map(|v| 100.0 * v);
                print!(" | {value:.2} {low:.2} {high:.2} {truth:.2} {held}");
            }
            None => print!(" | -"),
        }
    }
    match (&route.lag_s, &route.refused) {
        (_, Some(why)) => println!(" | refused: {}", why.replace('\n', " ")),
        (Some(lag), None) => println!(
            " | lag {:.3} ({:.3} to {:.3})",
            lag.value, lag.ci95[0], lag.ci95[1]
        ),
        (None, None) => println!(),
    }
}
