//! What is identified of flights of a vehicle, beside its truth.

use std::io::Write as _;

use touchdown_identify::estimate::Estimate;
use touchdown_identify::flights::{Flight, FlightSettings, ground_effect};
use touchdown_identify::warning::Warning;
use touchdown_identify::{IdentificationSettings, Origin};

use super::{Vehicle, fly};

/// What is identified of a set of flights: extra lift at half, one and two rotor radii over that at six, lag (s), decay (1/R),
/// climb damping (s/m), lag of the motors (s).
pub const QUANTITIES: [&str; 7] = [
    "lift 0.5 R",
    "lift 1 R",
    "lift 2 R",
    "lag",
    "decay",
    "damping",
    "motor lag",
];

/// The latency of the accelerometer (s), which is identified only where there is one.
const LATENCY: &str = "accelerometer latency";

/// What came of a set of flights.
pub enum Cell {
    /// Each of [`QUANTITIES`], where it was identified, and the [`LATENCY`]; and whether the card warns of a late sensor.
    Found(Box<[Option<Estimate>; 8]>, bool),
    /// Nothing, for the reason given.
    Refused(String),
}

impl Cell {
    /// Prints a line for each quantity: `head`, which ends in the name of a case, its name, the truth, and what was found. A case
    /// whose late sensor is warned of is another one: `+warned`.
    pub fn print(&self, head: &str, vehicle: &Vehicle) -> std::io::Result<()> {
        let mut out = std::io::stdout().lock();
        match self {
            Self::Refused(why) => writeln!(out, "{head} refused {}", why.replace('\n', " "))?,
            Self::Found(found, warned) => {
                let head = format!("{head}{}", if *warned { "+warned" } else { "" });
                let names = QUANTITIES.iter().chain([&LATENCY]);
                for ((name, truth), found) in names.zip(vehicle.truth()).zip(&**found) {
                    let name = name.replace(' ', "_");
                    match found {
                        Some(e) => {
                            let [low, high] = e.ci95;
                            writeln!(out, "{head} {name} {truth} {} {low} {high}", e.value)?;
                        }
                        None => writeln!(out, "{head} {name} {truth} missing")?,
                    }
                }
            }
        }
        out.flush()
    }
}

/// Flies `flights` times from the seeds `seed` on, and identifies.
pub fn identify(vehicle: &Vehicle, seed: u64, flights: u64) -> Cell {
    let r = vehicle.rotor_radius_m;
    let settings = FlightSettings {
        rotor_radius_m: Some(r),
        ..FlightSettings::default()
    };
    let logs: Vec<Flight> = (seed..seed + flights)
        .map(|seed| Flight::of(&fly(vehicle, seed), &settings).expect("a log of a flight"))
        .collect();
    let found = match ground_effect(&logs, &settings) {
        Ok(found) => found,
        Err(error) => return Cell::Refused(error.to_string()),
    };
    let lift = |radii: f64| found.extra_lift([radii * r; 2], [6.0 * r; 2]);
    let numbers = found.numbers();
    let of = |name: &str| numbers.iter().find(|n| n.name == name).map(|n| n.estimate);
    let decay = found.decay_per_m().map(|d| Estimate {
        value: d.value * r,
        std_error: d.std_error * r,
        ci95: d.ci95.map(|v| v * r),
    });
    let all = IdentificationSettings {
        flight: settings,
        ..IdentificationSettings::default()
    };
    let warnings = found.card(&all, &Origin::default()).warnings;
    let warned = warnings.iter().any(|w| {
        matches!(
            w,
            Warning::AccelerometerLate { .. } | Warning::RangeLate { .. }
        )
    });
    let numbers = [
        lift(0.5),
        lift(1.0),
        lift(2.0),
        found.lag_s(),
        decay,
        of("damping"),
        found.motor_lag_s(),
        of("accelerometer_latency"),
    ];
    Cell::Found(Box::new(numbers), warned)
}
