//! What is known of the vehicle beside the logs.

use serde::{Deserialize, Serialize};

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
        let lengths = [
            ("vehicle.mass_kg", self.mass_kg),
            ("vehicle.rotor_radius_m", self.rotor_radius_m),
            ("vehicle.arm_m", self.arm_m),
        ];
        for (key, value) in lengths {
            if let Some(v) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Some((key, "a finite number above 0", v.to_string()));
            }
        }
        let counts = [
            ("vehicle.rotors", self.rotors),
            ("vehicle.measured_rotors", self.measured_rotors),
        ];
        let zero = counts.into_iter().find(|(_, count)| *count == Some(0));
        zero.map(|(key, _)| (key, "at least 1", "0".to_string()))
    }
}
