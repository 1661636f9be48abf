//! How close identification from flights comes to the truth, on simulated vehicles: curves, lags and their intervals.
//!
//! ```text
//! cargo run --release --example flight_truth -- [sets] [first set] [law] [vehicle] [Hz] [flights] [turbulence]
//! ```
//!
//! Each set is ten new flights (or as many as asked for) of one vehicle (seeds `1000 set + 0..10`) with sensor noise and
//! turbulence (a share of thrust, 0.01 unless told), at 250 Hz.
//! The curve is judged at twelve heights from 0.3 to 3 rotor radii against the settled ratio of the plant; the lag
//! against the single lag that fits the plant's ratio best along the flights.

#![allow(clippy::print_stdout, reason = "a program whose output is its table")]

#[path = "../tests/common/flights.rs"]
mod flights;

use flights::Flown;
use touchdown_identify::flights::{Flight, FlightSettings, ground_effect};
use touchdown_sim::body::plant::{GroundLaw, PlantSettings};

/// Heights at which curves are judged, in rotor radii.
const HEIGHTS: [f64; 12] = [0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 1.8, 2.2, 2.6, 3.0];
/// Mass (kg), rotor radius (m) and lag of the exponential law (s).
const VEHICLES: [[f64; 3]; 3] = [[0.03, 0.023, 0.08], [1.4, 0.12, 0.15], [4.0, 0.19, 0.2]];

/// What came out over sets.
#[derive(Default)]
struct Tally {
    sets: usize,
    worst: Vec<f64>,
    lag: Vec<f64>,
    refused: usize,
    curve_held: usize,
    curve_asked: usize,
    lag_held: usize,
    curve_half: Vec<f64>,
    lag_half: Vec<f64>,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, or: f64| args.get(k).and_then(|a| a.parse().ok()).unwrap_or(or);
    let (sets, first) = (number(0, 6.0) as u64, number(1, 1.0) as u64);
    let law = args.get(2).map_or("all", String::as_str);
    let vehicle = args.get(3).map_or("all", String::as_str);
    let rate_hz = number(4, 250.0);
    let flights = number(5, 10.0) as u64;
    println!(
        "law          mass_kg set  curve      worst_%   at_R lag_s  true_s   lag_%  held  lag_interval_s"
    );
    let mut all = Vec::new();
    for (name, ground) in [
        ("exponential", GroundLaw::Exponential),
        ("wake", GroundLaw::WakeLag),
    ] {
        for [mass_kg, radius_m, lag_s] in VEHICLES {
            if (law != "all" && law != name) || (vehicle != "all" && vehicle != mass_kg.to_string())
            {
                continue;
            }
            let mut plant = flights::vehicle(mass_kg, radius_m, ground, lag_s);
            plant.turbulence = number(6, plant.turbulence);
            let mut tally = Tally::default();
            for set in first..first + sets {
                let logs = fly(&plant, set, rate_hz, flights);
                judge(name, &plant, set, &logs, &mut tally);
            }
            all.push((name, mass_kg, tally));
        }
    }
    println!();
    println!(
        "law          mass_kg sets worst_curve_%  worst_lag_%  lag_refused  curve_held  lag_held  median_half_curve_%  _lag_%"
    );
    for (name, mass_kg, mut t) in all {
        let most = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        println!(
            "{name:12} {mass_kg:7} {:4} {:13.1} {:12.1} {:12} {:>11} {:>9} {:20.1} {:7.1}",
            t.sets,
            most(&t.worst),
            most(&t.lag),
            t.refused,
            format!("{}/{}", t.curve_held, t.curve_asked),
            format!("{}/{}", t.lag_held, t.lag.len()),
            middle(&mut t.curve_half),
            middle(&mut t.lag_half),
        );
    }
}

fn fly(plant: &PlantSettings, set: u64, rate_hz: f64, flights: u64) -> Vec<Flown> {
    (0..flights)
        .map(|k| flights::fly(plant, 1000 * set + k, 250.0, rate_hz))
        .collect()
}

/// How far off what new flights give is.
fn judge(law: &str, plant: &PlantSettings, set: u64, flown: &[Flown], tally: &mut Tally) {
    let settings = FlightSettings {
        rotor_radius_m: Some(plant.rotor_radius_m),
        ..FlightSettings::default()
    };
    let logs: Vec<Flight> = flown
        .iter()
        .map(|f| Flight::of(&f.trial, &settings).expect("a log of a flight"))
        .collect();
    let found = match ground_effect(&logs, &settings) {
        Ok(found) => found,
        Err(e) => {
            println!("{law:12} {:7} {set:3}  {e}", plant.mass_kg);
            return;
        }
    };
    tally.sets += 1;
    let (mut worst, mut at, mut held) = (0.0_f64, 0.0, 0);
    for radii in HEIGHTS {
        let height_m = radii * plant.rotor_radius_m;
        let truth = flights::true_ratio(plant, height_m);
        let Some(ratio) = found.ratio(height_m) else {
            continue;
        };
        let error = 100.0 * (ratio.value / truth - 1.0);
        if error.abs() > worst.abs() {
            (worst, at) = (error, radii);
        }
        held += usize::from((ratio.ci95[0]..=ratio.ci95[1]).contains(&truth));
        let half = 0.5 * (ratio.ci95[1] - ratio.ci95[0]);
        tally.curve_half.push(100.0 * half / truth);
    }
    tally.worst.push(worst);
    tally.curve_held += held;
    tally.curve_asked += HEIGHTS.len();
    let truth = flights::true_lag_s(plant, flown);
    let (mut lag_s, mut off, mut interval) = (f64::NAN, f64::NAN, [f64::NAN; 2]);
    if let Some(lag) = found.lag_s() {
        (lag_s, off, interval) = (lag.value, 100.0 * (lag.value / truth - 1.0), lag.ci95);
        tally.lag.push(off);
        tally.lag_held += usize::from((interval[0]..=interval[1]).contains(&truth));
        tally
            .lag_half
            .push(50.0 * (interval[1] - interval[0]) / truth);
    } else {
        tally.refused += 1;
    }
    println!(
        "{law:12} {:7} {set:3}  {:10} {worst:+7.1} {at:6} {lag_s:6.3} {truth:6.3} {off:+7.1} {held:3}/{}  {:.3} {:.3}",
        plant.mass_kg,
        found.fit.shape.curve.name(),
        HEIGHTS.len(),
        interval[0],
        interval[1],
    );
}

fn middle(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
