//! The default vehicle's plant with another mass and size.

use touchdown_sim::body::plant::PlantSettings;
use touchdown_sim::landing::space::SpaceScenario;

use super::preset::STANDARD;
use super::scaling::{Ratios, scaled};
use crate::error::Result;

/// The default vehicle in proportion, by the [scaling laws](super::scaling). Its motors and the second plant's law stay the
/// default ones.
///
/// # Errors
/// Numbers of no vehicle.
pub fn in_proportion(
    mass_kg: f64,
    rotor_radius_m: f64,
    arm_m: Option<f64>,
) -> Result<PlantSettings> {
    let standard = PlantSettings::default();
    let radius = rotor_radius_m / standard.rotor_radius_m;
    let mass = mass_kg / standard.mass_kg;
    let of = Ratios {
        radius,
        mass,
        arm: arm_m.map_or(radius, |arm_m| arm_m / STANDARD[2]),
        thrust: mass,
    };
    let plant = scaled(&SpaceScenario::default(), &of, &|_| false)?.plant;
    Ok(PlantSettings {
        mass_kg,
        rotor_radius_m,
        motor: standard.motor,
        exponential: standard.exponential,
        ..plant
    })
}
