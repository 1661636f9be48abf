//! The vehicle that is simulated: its rotors, mass and size, and motors that give the thrust of its card.
//!
//! A stand measures one motor, a vehicle has several. The thrust of a card is multiplied by the rotors of the vehicle over
//! those that were measured ([`VehicleSettings::thrust`]). The simulated vehicle has four rotors; a vehicle of another number
//! is simulated by four with the thrust of all.

mod motor;
mod proportion;

use serde::{Deserialize, Serialize};
use touchdown_flight::thrust::ThrustModel;
use touchdown_model::Card;
use touchdown_model::card::Vehicle;
use touchdown_sim::body::motor::{Motor, MotorSettings};
use touchdown_sim::body::plant::PlantSettings;

use crate::error::{Error, Result};
pub use motor::MotorFit;
pub use proportion::in_proportion;

/// Rotors of the simulated vehicle.
const SIMULATED_ROTORS: u32 = 4;
/// Greatest thrust over weight below which a vehicle is not flown: it could neither brake a descent nor answer a gust. At half
/// of the excess a landing at 1 m/s takes twice as long to stop; twice refuses heavy lifters that fly.
const LEAST_THRUST_TO_WEIGHT: f64 = 1.3;
/// Difference of steady thrust, as a share of the weight, up to which the simulated motors are those of the card. A card
/// that was identified on the simulated vehicle is within 0.02: its error stays what a landing has to bear. Half of it
/// takes that error away for poor cards; twice flies controllers with a thrust that no stand gets wrong.
const OF_THE_SAME_MOTORS: f64 = 0.05;

/// What is stated of the vehicle; without a value, the thrust card's, then the simulated one's.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleSettings {
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Radius of a rotor, m.
    pub rotor_radius_m: Option<f64>,
    /// Distance of the rotors' axes from the centre, m.
    pub arm_m: Option<f64>,
    /// Number of rotors.
    pub rotors: Option<u32>,
}

impl VehicleSettings {
    /// Whether nothing is stated.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks the values; `file` names them in errors.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self, file: &str) -> Result<()> {
        let vehicle = Vehicle {
            mass_kg: self.mass_kg,
            rotor_radius_m: self.rotor_radius_m,
            rotors: self.rotors,
            arm_m: self.arm_m,
            ..Vehicle::default()
        };
        vehicle.fault().map_or(Ok(()), |(key, expected, found)| {
            Err(Error::Settings {
                file: file.to_string(),
                message: format!("key `{key}`: expected {expected}, found {found}"),
            })
        })
    }

    /// The thrust of the whole vehicle by a card.
    ///
    /// # Errors
    /// A card that does not fly.
    pub fn thrust(&self, card: &Card) -> Result<ThrustModel<f64>> {
        let rotors = self.rotors.or(card.vehicle.rotors);
        Ok(card.thrust_model_of(Some(rotors.unwrap_or(SIMULATED_ROTORS)))?)
    }

    /// How the thrust of a card becomes that of the vehicle, in words; none where it was measured on all of its rotors.
    #[must_use]
    pub fn multiplied(&self, card: &Card) -> Option<String> {
        let measured = card.measured_rotors?;
        let stated = self.rotors.or(card.vehicle.rotors);
        let rotors = stated.unwrap_or(SIMULATED_ROTORS);
        let source = if stated.is_some() {
            ""
        } else {
            " (assumed: set rotors in [vehicle])"
        };
        (rotors != measured).then(|| {
            format!(
                "thrust of card `{}` times {rotors}/{measured}: {rotors} rotors{source}, {measured} measured",
                card.name
            )
        })
    }
}

/// Checks that a vehicle lifts itself with something to spare.
///
/// # Errors
/// A greatest thrust below 1.3 times the weight, or a hover that no throttle gives.
pub fn check_lift(card: &Card, model: &ThrustModel<f64>, weight_n: f64) -> Result<()> {
    let most_n = motor::throttles()
        .map(|s| model.rest(s).powi(2))
        .fold(0.0, f64::max);
    if most_n < LEAST_THRUST_TO_WEIGHT * weight_n {
        let hint = match card.measured_rotors {
            None => "Is it of one motor? Then identify it again with --rotors 1",
            Some(_) => "Are mass_kg and rotors in [vehicle] right?",
        };
        return Err(Error::Arguments(format!(
            "thrust card `{}`: its greatest thrust, {most_n:.3} N, is below {LEAST_THRUST_TO_WEIGHT} times the weight of the \
             vehicle, {weight_n:.3} N. {hint}",
            card.name
        )));
    }
    let hover_n = model.rest(model.throttle_for(weight_n)).powi(2);
    if (hover_n / weight_n - 1.0).abs() > 0.01 {
        return Err(Error::Arguments(format!(
            "thrust card `{}`: no throttle gives the weight of the vehicle, {weight_n:.3} N; the nearest thrust is {hover_n:.3} N",
            card.name
        )));
    }
    Ok(())
}

/// Motors for a plant that has the default ones, where a card's thrust is another; none where the plant sets motors of its
/// own or its motors give the card's thrust already.
///
/// # Errors
/// A card whose vehicle cannot lift itself.
pub fn motors_of(
    card: &Card,
    model: &ThrustModel<f64>,
    plant: &PlantSettings,
) -> Result<Option<MotorFit>> {
    let weight_n = plant.weight_n();
    check_lift(card, model, weight_n)?;
    if plant.motor != MotorSettings::default() {
        return Ok(None);
    }
    let own = Motor::new(&plant.motor, weight_n)?;
    let fit = motor::fit(card, model, weight_n)?;
    let [low, high] = fit.throttles;
    let apart = motor::throttles()
        .filter(|s| (low..=high).contains(s))
        .map(|s| (own.rest(s).powi(2) - model.rest(s).powi(2)).abs() / weight_n)
        .fold(0.0, f64::max);
    Ok((apart > OF_THE_SAME_MOTORS).then_some(fit))
}
