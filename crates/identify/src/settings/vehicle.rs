//! What is known of the vehicle beside the logs.

use serde::{Deserialize, Serialize};
use touchdown_model::card::Vehicle;

/// The vehicle, and how many of its rotors the logs have the thrust of.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleSettings {
    /// Mass (kg); absent: the map's.
    pub mass_kg: Option<f64>,
    /// Rotor radius (m); absent: the map's.
    pub rotor_radius_m: Option<f64>,
    /// Distance of the rotors' axes from the centre (m); absent: the map's.
    pub arm_m: Option<f64>,
    /// Number of rotors; absent: the map's.
    pub rotors: Option<u32>,
    /// Rotors whose thrust the logs have; absent: the map's, else as [`crate::thrust::fit`] finds it.
    pub measured_rotors: Option<u32>,
}

impl VehicleSettings {
    /// These values where they are set, otherwise those of `other`.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            mass_kg: self.mass_kg.or(other.mass_kg),
            rotor_radius_m: self.rotor_radius_m.or(other.rotor_radius_m),
            arm_m: self.arm_m.or(other.arm_m),
            rotors: self.rotors.or(other.rotors),
            measured_rotors: self.measured_rotors.or(other.measured_rotors),
        }
    }

    /// The first key out of range: its name, what it must be, and what was found.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, &'static str, String)> {
        let vehicle = Vehicle {
            mass_kg: self.mass_kg,
            rotor_radius_m: self.rotor_radius_m,
            rotors: self.rotors,
            arm_m: self.arm_m,
            ..Vehicle::default()
        };
        let measured = || {
            let zero = self.measured_rotors == Some(0);
            zero.then(|| ("vehicle.measured_rotors", "at least 1", "0".to_string()))
        };
        vehicle.fault().or_else(measured)
    }
}
