//! Scaling laws: every setting of a landing from a few numbers of its vehicle.
//!
//! The standard vehicle (1.37 kg, rotors of 0.12 m) is tuned by hand. Another vehicle flies the same dimensionless
//! landing by Froude's law, under the same gravity: with the ratio λ of the rotor radius, lengths follow λ, times and
//! speeds √λ, accelerations and angles stay. Forces follow the mass m, moments of inertia m a² with the arm a, losses of
//! the motors the greatest thrust T. The laws of all keys stand in `table.rs`, and [`laws`] lists them.
//!
//! | quantity | law | examples |
//! | --- | --- | --- |
//! | length | λ | heights, legs, plate, tags, positions of sensors |
//! | time | √λ | motor lag, filters, durations of descents |
//! | speed | √λ | climb, sink rate, limits of the state machine |
//! | rate | 1/√λ | bandwidth of attitude and rate control, Γ |
//! | force | m | limits of observer and integral |
//! | force over length, over speed | m/λ, m/√λ | stiffness and damping of legs, K_I, K_P |
//! | moment of inertia | m a² | body |
//! | linear drag | λ√m | weight over induced velocity: climb damping, flapping |
//! | losses of the motors | 1/√T, 1/T | thrust at every throttle follows the greatest |
//!
//! Electronics do not follow: rates, latencies and noise of inertial units stay. Errors of range finders follow
//! smaller vehicles only, and times that the deck sets follow larger ones only. On the deck the thrust of a larger vehicle decreases
//! more slowly than by similarity, so that its feet come down no faster.

mod law;
mod table;

use toml::{Table, Value};
use touchdown_flight::thrust::{Library, LibraryOfRotors, ThrustModel};
use touchdown_lander::models::FlightModels;
use touchdown_sim::deck::rigid::{Axis, RigidMotion};
use touchdown_sim::deck::wave::WaveSpectrum;
use touchdown_sim::landing::space::SpaceScenario;

use crate::error::{Error, Result};
use law::Entry;
pub use law::Ratios;
use table::TABLE;

/// Keys of a scenario that depend on the vehicle, with their laws in words of λ, m, a and T.
pub fn laws() -> impl Iterator<Item = (&'static str, String)> {
    TABLE.iter().map(|entry| (entry.key, entry.text()))
}

/// The scenario for a vehicle of other ratios with the standard electronics. A key that `stated` names keeps its value.
///
/// # Errors
/// Ratios that give no scenario.
pub fn scaled(
    scenario: &SpaceScenario,
    of: &Ratios,
    stated: &dyn Fn(&str) -> bool,
) -> Result<SpaceScenario> {
    if *of == Ratios::STANDARD {
        return Ok(scenario.clone());
    }
    let mut scaled = by(scenario, &|entry| {
        if stated(entry.key) {
            1.0
        } else {
            entry.factor(of)
        }
    })?;
    if !stated("models.thrust") {
        scaled.models.thrust = thrust(scenario.models.thrust, of);
    }
    Ok(scaled)
}

/// The scenario of a similar vehicle with similar electronics over a similar deck: the same dimensionless landing.
///
/// # Errors
/// As [`scaled`].
pub fn similar(scenario: &SpaceScenario, radius: f64) -> Result<SpaceScenario> {
    let of = Ratios::similar(radius);
    let mut scaled = by(scenario, &|entry| entry.similar(&of))?;
    scaled.models.thrust = thrust(scenario.models.thrust, &of);
    deck(&mut scaled.deck, radius);
    Ok(scaled)
}

/// A motion of the deck in proportion: lengths with λ, times with √λ.
pub fn deck(motion: &mut RigidMotion, radius: f64) {
    let pace = radius.sqrt();
    match motion {
        RigidMotion::Still {} => {}
        RigidMotion::Sines { tones } => {
            for tone in tones {
                tone.frequency_hz /= pace;
                if matches!(tone.axis, Axis::Surge | Axis::Sway | Axis::Heave) {
                    tone.amplitude *= radius;
                }
            }
        }
        RigidMotion::Triangle {
            amplitude_m,
            speed_mps,
            ..
        } => {
            *amplitude_m *= radius;
            *speed_mps *= pace;
        }
        RigidMotion::Sea(sea) => {
            match &mut sea.spectrum {
                WaveSpectrum::Jonswap {
                    significant_height_m,
                    peak_period_s,
                    ..
                }
                | WaveSpectrum::PiersonMoskowitz {
                    significant_height_m,
                    peak_period_s,
                } => {
                    *significant_height_m *= radius;
                    *peak_period_s *= pace;
                }
            }
            let ship = &mut sea.ship;
            ship.length_m *= radius;
            ship.beam_m *= radius;
            ship.draught_m *= radius;
            ship.roll_period_s *= pace;
            ship.deck_place_m = ship.deck_place_m.map(|x| x * radius);
        }
    }
}

/// The default thrust model with lags of √λ and the greatest thrust of the vehicle; another one stays.
fn thrust(model: ThrustModel<f64>, of: &Ratios) -> ThrustModel<f64> {
    let ThrustModel::Library(library) = model else {
        return model;
    };
    if model != FlightModels::default().thrust {
        return model;
    }
    let rate = of.radius.powf(-0.5);
    ThrustModel::LibraryOfRotors(LibraryOfRotors {
        library: Library {
            one: library.one * rate,
            x: library.x * rate,
            s: library.s * rate,
            s2: library.s2 * rate,
            x3: library.x3 * rate,
            s3: library.s3 * rate,
            exp_neg_x_s: library.exp_neg_x_s * rate,
            sin_x_s: library.sin_x_s * rate,
        },
        root_factor: of.thrust.sqrt(),
    })
}

/// The scenario with every key of the table times its factor.
fn by(scenario: &SpaceScenario, factor: &dyn Fn(&Entry) -> f64) -> Result<SpaceScenario> {
    let bad = |message: String| Error::Arguments(format!("scaling of the vehicle: {message}"));
    let mut table = Table::try_from(scenario).map_err(|e| bad(e.to_string()))?;
    for entry in TABLE {
        let factor = factor(entry);
        if factor != 1.0 {
            let mut parts = entry.key.split('.');
            let place = parts.try_fold(Place::Table(&mut table), Place::below);
            if let Some(Place::Value(value)) = place {
                multiply(value, factor);
            }
        }
    }
    table
        .try_into()
        .map_err(|e: toml::de::Error| bad(e.message().to_string()))
}

/// A place in a tree of settings.
enum Place<'a> {
    Table(&'a mut Table),
    Value(&'a mut Value),
}

impl<'a> Place<'a> {
    /// The value of a key, where there is one.
    fn below(self, key: &str) -> Option<Self> {
        let table = match self {
            Self::Table(table) | Self::Value(Value::Table(table)) => table,
            Self::Value(_) => return None,
        };
        table.get_mut(key).map(Self::Value)
    }
}

/// Multiplies a number, and all numbers of a list or table.
fn multiply(value: &mut Value, factor: f64) {
    match value {
        Value::Float(number) => *number *= factor,
        Value::Array(values) => values.iter_mut().for_each(|v| multiply(v, factor)),
        Value::Table(values) => values.iter_mut().for_each(|(_, v)| multiply(v, factor)),
        _ => {}
    }
}

#[cfg(test)]
mod tests;
