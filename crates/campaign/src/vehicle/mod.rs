//! The vehicle that is simulated: its rotors, mass and size, and motors that give the thrust of its card.
//!
//! A stand measures one motor, a vehicle has several. The thrust of a card is multiplied by the rotors of the vehicle over
//! those that were measured ([`VehicleSettings::thrust`]). The simulated vehicle has four rotors; a vehicle of another number
//! is simulated by four with the thrust of all and the same lever of roll and pitch ([`RotorLayout`]).
//!
//! | module | what it holds |
//! | --- | --- |
//! | `preset` | vehicles by name |
//! | `layout` | number and arrangement of rotors |
//! | [`scaling`] | the law of every setting that depends on the vehicle |
//! | `proportion` | the plant alone, for landings of the vertical vehicle |
//! | `motor` | motors by a thrust card |

mod layout;
mod motor;
mod preset;
mod proportion;
pub mod scaling;

use serde::{Deserialize, Serialize};
use touchdown_flight::thrust::{LEAST_THRUST_TO_WEIGHT, THRUST_ERROR, ThrustModel};
use touchdown_model::Card;
use touchdown_model::card::Vehicle;
use touchdown_sim::body::motor::{Motor, MotorSettings};
use touchdown_sim::body::plant::PlantSettings;

use crate::error::{Error, Result};
use layout::COAXIAL_SHARE;
pub use layout::RotorLayout;
pub use motor::MotorFit;
pub use preset::{PRESETS, Preset, PresetName};
pub use proportion::in_proportion;
use scaling::Ratios;

/// Rotors of the simulated vehicle.
const SIMULATED_ROTORS: u32 = 4;
/// Difference of steady thrust, as a share of the weight, up to which the simulated motors are those of the card. A card
/// that was identified on the simulated vehicle is within 0.02: its error stays what a landing has to bear. Half of it
/// takes that error away for poor cards; twice flies controllers with a thrust that no stand gets wrong.
const OF_THE_SAME_MOTORS: f64 = 0.05;

/// Least distance of neighbouring rotors' axes over the width of their discs, where no arm is stated. Presets of six and eight
/// arms have 1.03 to 1.06, as such vehicles are built.
const DISCS_APART: f64 = 1.05;

/// Greatest mass of a vehicle, kg. It is that of the heaviest multirotors that are built; above it, somebody meant grams.
const GREATEST_MASS_KG: f64 = 1000.0;

/// What is stated of the vehicle; without a value, the preset's, then the thrust card's, then the simulated one's.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleSettings {
    /// A vehicle by its name.
    pub preset: Option<PresetName>,
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Radius of a rotor, m.
    pub rotor_radius_m: Option<f64>,
    /// Distance of the rotors' axes from the centre, m.
    pub arm_m: Option<f64>,
    /// Number of rotors.
    pub rotors: Option<u32>,
    /// Whether each arm carries two rotors, one above the other.
    pub coaxial: Option<bool>,
    /// Greatest thrust of all rotors, N.
    pub greatest_thrust_n: Option<f64>,
    /// Whether the motion of the deck is scaled with the vehicle: lengths with the rotor radius, times with its root.
    pub scales_deck: Option<bool>,
}

impl VehicleSettings {
    /// With the values of the preset where none is stated.
    #[must_use]
    pub fn with_preset(&self) -> Self {
        let Some(preset) = self.preset.map(PresetName::preset) else {
            return *self;
        };
        let thrust_n = Some(preset.greatest_thrust_n);
        Self {
            preset: None,
            mass_kg: self.mass_kg.or(Some(preset.mass_kg)),
            rotor_radius_m: self.rotor_radius_m.or(Some(preset.rotor_radius_m)),
            arm_m: self.arm_m.or(Some(preset.arm_m)),
            rotors: self.rotors.or(Some(preset.layout.rotors)),
            coaxial: self.coaxial.or(Some(preset.layout.coaxial)),
            greatest_thrust_n: self.greatest_thrust_n.or(thrust_n),
            scales_deck: self.scales_deck,
        }
    }

    /// With the values of a card's vehicle where none is stated.
    #[must_use]
    pub fn with_card(&self, card: &Card) -> Self {
        let known = |value: Option<f64>| value.filter(|v| v.is_finite() && *v > 0.0);
        let of = &card.vehicle;
        Self {
            mass_kg: self.mass_kg.or(known(of.mass_kg)),
            rotor_radius_m: self.rotor_radius_m.or(known(of.rotor_radius_m)),
            arm_m: self.arm_m.or(known(of.arm_m)),
            rotors: self.rotors.or(of.rotors),
            ..*self
        }
    }

    /// Number and arrangement of the rotors; four where nothing is stated.
    #[must_use]
    pub fn layout(&self) -> RotorLayout {
        RotorLayout {
            rotors: self.rotors.unwrap_or(SIMULATED_ROTORS),
            coaxial: self.coaxial.unwrap_or(false),
        }
    }

    /// Ratios to the standard vehicle. Without a radius, that of a vehicle of equal density; without an arm, in proportion
    /// to the radius, or as long as more than four arms keep their discs apart; without a thrust, in proportion to the mass.
    #[must_use]
    pub fn ratios(&self) -> Ratios {
        let [mass_kg, rotor_radius_m, arm_m, thrust_n] = preset::STANDARD;
        let mass = self.mass_kg.map_or(1.0, |m| m / mass_kg);
        let of_density = || mass.cbrt();
        let radius = self
            .rotor_radius_m
            .map_or_else(of_density, |r| r / rotor_radius_m);
        let apart = DISCS_APART * 2.0 / self.layout().spacing_of_arm();
        Ratios {
            radius,
            mass,
            arm: self.arm_m.map_or_else(
                || radius.max(radius * rotor_radius_m * apart / arm_m),
                |a| a / arm_m,
            ),
            thrust: self.greatest_thrust_n.map_or(mass, |t| t / thrust_n),
        }
    }

    /// The rotors' discs overlap, in a sentence.
    #[must_use]
    pub fn overlap(&self) -> Option<String> {
        let of = self.ratios();
        let [_, rotor_radius_m, arm_m, _] = preset::STANDARD;
        let width_m = 2.0 * of.radius * rotor_radius_m;
        let apart_m = of.arm * arm_m * self.layout().spacing_of_arm();
        // Rounding only: discs may touch.
        (apart_m < width_m * (1.0 - 1e-9)).then(|| {
            format!(
                "the rotors' discs overlap: neighbouring axes are {apart_m:.3} m apart, discs {width_m:.3} m wide. Are arm_m, \
                 rotor_radius_m and rotors in [vehicle] right?"
            )
        })
    }

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
        let bad = |key: &str, expected: &str, found: String| Error::Settings {
            file: file.to_string(),
            message: format!("key `{key}`: expected {expected}, found {found}"),
        };
        if let Some((key, expected, found)) = vehicle.fault() {
            return Err(bad(key, expected, found));
        }
        let thrust_n = self.greatest_thrust_n;
        if let Some(v) = thrust_n.filter(|v| !(*v > 0.0 && v.is_finite())) {
            let key = "vehicle.greatest_thrust_n";
            return Err(bad(key, "a finite number above 0", v.to_string()));
        }
        let RotorLayout { rotors, coaxial } = self.with_preset().layout();
        if coaxial && rotors % 2 == 1 {
            let expected = "an even number of coaxial rotors";
            return Err(bad("vehicle.rotors", expected, rotors.to_string()));
        }
        if let Some(mass_kg) = self.mass_kg.filter(|kg| *kg > GREATEST_MASS_KG) {
            let expected = format!("a mass of at most {GREATEST_MASS_KG} kg");
            return Err(bad("vehicle.mass_kg", &expected, mass_kg.to_string()));
        }
        Ok(())
    }

    /// The thrust of the whole vehicle by a card. Coaxial rotors lose thrust where the card's were apart.
    ///
    /// # Errors
    /// A card that does not fly.
    pub fn thrust(&self, card: &Card) -> Result<ThrustModel<f64>> {
        let given = self.with_preset().with_card(card);
        let RotorLayout { rotors, coaxial } = given.layout();
        let model = card.thrust_model_of(Some(rotors))?;
        let apart = card.measured_rotors.is_some_and(|m| m < rotors);
        let share = if coaxial && apart { COAXIAL_SHARE } else { 1.0 };
        Ok(model.of_rotors(share))
    }

    /// How the thrust of a card becomes that of the vehicle, in words; none where it was measured on all of its rotors.
    #[must_use]
    pub fn multiplied(&self, card: &Card) -> Option<String> {
        let measured = card.measured_rotors?;
        let stated = self.with_preset().with_card(card).rotors;
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

/// Greatest steady thrust of a model, N.
#[must_use]
pub fn greatest_thrust_n(model: &ThrustModel<f64>) -> f64 {
    motor::throttles()
        .map(|s| model.rest(s).powi(2))
        .fold(0.0, f64::max)
}

/// Checks that a vehicle lifts itself with something to spare.
///
/// # Errors
/// A greatest thrust below 1.3 times the weight, or a hover that no throttle gives.
pub fn check_lift(card: &Card, model: &ThrustModel<f64>, weight_n: f64) -> Result<()> {
    let most_n = greatest_thrust_n(model);
    if most_n < LEAST_THRUST_TO_WEIGHT * weight_n {
        let hint = match card.measured_rotors {
            None => {
                "Is it of one motor? Then identify it again with `measured_rotors = 1` in [vehicle]"
            }
            Some(_) => "Are mass_kg and rotors in [vehicle] right?",
        };
        return Err(Error::Arguments(format!(
            "thrust card `{}`: its greatest thrust, {most_n:.3} N, is below {LEAST_THRUST_TO_WEIGHT} times the weight of the \
             vehicle, {weight_n:.3} N. {hint}",
            card.name
        )));
    }
    let hover_n = model.rest(model.throttle_for(weight_n)).powi(2);
    if (hover_n / weight_n - 1.0).abs() > THRUST_ERROR {
        return Err(Error::Arguments(format!(
            "thrust card `{}`: no throttle gives the weight of the vehicle, {weight_n:.3} N; the nearest thrust is {hover_n:.3} N",
            card.name
        )));
    }
    Ok(())
}

/// Motors by a card, and whether their thrust differs from that of a plant's own motors by more than a card identified on
/// them errs.
///
/// # Errors
/// A card whose vehicle cannot lift itself.
pub fn motors_by(
    card: &Card,
    model: &ThrustModel<f64>,
    plant: &PlantSettings,
) -> Result<(MotorFit, bool)> {
    let weight_n = plant.weight_n();
    check_lift(card, model, weight_n)?;
    let own = Motor::new(&plant.motor, weight_n)?;
    let fit = motor::fit(card, model, weight_n)?;
    let [low, high] = fit.throttles;
    let apart = motor::throttles()
        .filter(|s| (low..=high).contains(s))
        .map(|s| (own.rest(s).powi(2) - model.rest(s).powi(2)).abs() / weight_n)
        .fold(0.0, f64::max);
    Ok((fit, apart > OF_THE_SAME_MOTORS))
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
    if plant.motor != MotorSettings::default() {
        check_lift(card, model, plant.weight_n())?;
        return Ok(None);
    }
    let (fit, others) = motors_by(card, model, plant)?;
    Ok(others.then_some(fit))
}
