//! The vehicle of a sweep: what `[vehicle]` and the thrust card say, in the scenario.

use touchdown_model::Card;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::contact::LegSettings;
use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::landing::space::SpaceScenario;

use super::axes::KeyError;
use crate::error::Result;
use crate::vehicle::{VehicleSettings, in_proportion, motors_of};

/// Puts mass, rotor radius and arm of `[vehicle]` and the motors of the thrust card into the scenario. Returns what was
/// done, in a line.
///
/// # Errors
/// A mass or size that the scenario sets, too; a vehicle whose thrust does not lift it.
pub(super) fn put_into(
    scenario: &mut SpaceScenario,
    vehicle: &VehicleSettings,
    thrust: Option<&Card>,
    bad: &KeyError<'_>,
) -> Result<Option<String>> {
    let mut said = Vec::new();
    let sized = VehicleSettings {
        rotors: None,
        ..*vehicle
    };
    if !sized.is_empty() {
        if scenario.plant != PlantSettings::default() || scenario.body != BodySettings::default() {
            return Err(bad(
                "vehicle",
                "`scenario.plant` or `scenario.body` set the vehicle; remove one of them",
            ));
        }
        resize(scenario, vehicle);
        said.push(format!(
            "simulated vehicle: {} kg, rotor radius {:.4} m",
            scenario.plant.mass_kg, scenario.plant.rotor_radius_m
        ));
    }
    if let Some(card) = thrust {
        said.extend(vehicle.multiplied(card));
        if let Some(fit) = motors_of(card, &scenario.models.thrust, &scenario.plant)? {
            scenario.plant.motor = fit.motor;
            said.push(format!(
                "simulated motors: those of card `{}` within {:.1} % of thrust over throttle {:.2} to {:.2}",
                card.name,
                100.0 * fit.worst,
                fit.throttles[0],
                fit.throttles[1]
            ));
        }
    }
    Ok((!said.is_empty()).then(|| said.join("; ")))
}

/// The default vehicle with another mass and size: forces of legs and air with the mass, inertia with mass times the square
/// of the arm. Lengths of the legs and heights of the landing computer stay.
fn resize(scenario: &mut SpaceScenario, vehicle: &VehicleSettings) {
    let standard = PlantSettings::default();
    let mass_kg = vehicle.mass_kg.unwrap_or(standard.mass_kg);
    let radius_m = vehicle.rotor_radius_m.unwrap_or(standard.rotor_radius_m);
    scenario.plant = in_proportion(mass_kg, radius_m, vehicle.arm_m);
    let weight = mass_kg / standard.mass_kg;
    let arm = scenario.plant.rotor_spacing_m / standard.rotor_spacing_m;
    let body = &mut scenario.body;
    body.inertia_kg_m2 = body.inertia_kg_m2.map(|i| i * weight * arm * arm);
    body.torque_per_thrust_m *= radius_m / standard.rotor_radius_m;
    body.drag_ns_per_m *= weight;
    body.drag_ns2_per_m2 *= arm * arm;
    if scenario.legs == LegSettings::default() {
        let legs = &mut scenario.legs;
        legs.stiffness_n_per_m *= weight;
        legs.damping_ns_per_m *= weight;
        legs.tangential_stiffness_n_per_m *= weight;
        legs.tangential_damping_ns_per_m *= weight;
    }
}
