//! Thrust from flights: mass times specific force, where the vehicle flies and the ground is far.

use touchdown_trial::Trial;

use super::phases::{Phase, Phases};
use super::{Flight, FlightSettings};
use crate::error::{Error, Result};
use crate::identify::thrust::throttle;

/// The trial with `thrust_n` from specific force and mass. On the ground, around impacts, leaning, and in ground effect
/// (where height and rotor radius are known) thrust is a gap. How many rows are left is noted in the provenance.
///
/// # Errors
/// No mass, no specific force, or no row in flight.
pub fn with_thrust(
    trial: &Trial,
    settings: &FlightSettings,
    mass_kg: Option<f64>,
) -> Result<Trial> {
    let Some(mass_kg) = settings.mass_kg.or(mass_kg) else {
        return Err(Error::Arguments(
            "thrust from flight needs the mass: expected `mass_kg` in the table [vehicle] of --map or in [flight] of \
             --settings, found neither"
                .to_string(),
        ));
    };
    let force = trial.require("specific_force_mps2")?;
    let flight = Flight::of(trial, settings)?;
    let phases = Phases::of(&flight, settings);
    let reference_m = settings
        .rotor_radius_m
        .map(|r| r * settings.reference_radii);
    // The flight's clock may be coarser than the trial's.
    let mut at = 0;
    let thrust: Vec<f64> = trial
        .time_s()
        .iter()
        .zip(force)
        .map(|(&t, f)| {
            while at + 1 < flight.time_s.len() && flight.time_s[at + 1] <= t {
                at += 1;
            }
            let near =
                reference_m.is_some_and(|m| flight.height_m.get(at).is_some_and(|z| !(*z > m)));
            if phases.rows[at] == Phase::Airborne && !near {
                mass_kg * f
            } else {
                f64::NAN
            }
        })
        .collect();
    let used = thrust.iter().filter(|t| t.is_finite()).count();
    if used == 0 {
        let far = reference_m.map_or_else(String::new, |m| format!(" above {m:.3} m"));
        return Err(Error::data(
            trial.name(),
            format!("rows in flight{far} with a specific force"),
            "none",
        ));
    }
    // The motors' own throttles are kept; a mean is what a flight has at least.
    let mean = throttle(trial)?;
    let mut out = trial.clone();
    out.insert("thrust_n", thrust)?;
    if out.channel("throttle").is_none() {
        out.insert("throttle", mean)?;
    }
    out.note(format!(
        "thrust is {mass_kg} kg times specific force in {used} of {} rows, in flight out of ground effect",
        trial.len()
    ));
    Ok(out)
}
