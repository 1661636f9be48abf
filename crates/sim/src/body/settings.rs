//! Settings of the body: inertia, torque of the rotors, drag.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;

/// Inertia, rotor torque and drag, beside [`PlantSettings`](crate::body::plant::PlantSettings).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodySettings {
    /// Moments of inertia about x, y, z, kg m².
    pub inertia_kg_m2: [f64; 3],
    /// Reaction torque of a rotor over its thrust κ, m.
    pub torque_per_thrust_m: f64,
    /// Angular momentum of a rotor in hover, kg m²/s.
    pub rotor_momentum_kg_m2_ps: f64,
    /// Drag in the rotors' plane, linear c_1, N s/m (blade flapping and induced drag).
    pub drag_ns_per_m: f64,
    /// Drag in the rotors' plane, quadratic c_2, N s²/m² (frame).
    pub drag_ns2_per_m2: f64,
}

impl Default for BodySettings {
    /// A quadrotor of 1.37 kg with rotors of 0.12 m radius, by order of magnitude; the paper
    /// prints none of these values.
    ///
    /// - Inertia: a radius of gyration of 0.096 m in roll and pitch, 0.42 of the arm of
    ///   0.226 m, because battery and electronics sit at the centre.
    /// - Torque over thrust: 0.13 R; propellers of this size have 0.1 R to 0.15 R.
    /// - Rotor momentum: a propeller of 12 g and 0.24 m, as a rod with three quarters of its inertia because blades
    ///   taper, and the bell of its motor have 5.5e-5 kg m²; they turn at 550 rad/s.
    /// - Linear drag: 0.26 1/s times the mass; flapping and induced drag of small
    ///   quadrotors are 0.2 to 0.6 1/s.
    /// - Quadratic drag: an area times drag coefficient of 0.033 m² (`2 c_2/ρ`).
    fn default() -> Self {
        Self {
            inertia_kg_m2: [0.0125, 0.0125, 0.022],
            torque_per_thrust_m: 0.016,
            rotor_momentum_kg_m2_ps: 0.03,
            drag_ns_per_m: 0.35,
            drag_ns2_per_m2: 0.02,
        }
    }
}

impl BodySettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Moments of inertia must be positive and each at most the sum of the
    /// others; torque, rotor momentum and drag must not be negative.
    pub fn validate(&self) -> Result<(), SimError> {
        let inertia = self.inertia_kg_m2;
        let sum = inertia[0] + inertia[1] + inertia[2];
        for moment in inertia {
            check::positive("inertia_kg_m2", moment)?;
            check::that(
                2.0 * moment <= sum * (1.0 + 1e-12),
                "inertia_kg_m2",
                "at most the sum of the other two moments",
                moment,
            )?;
        }
        check::not_negative("torque_per_thrust_m", self.torque_per_thrust_m)?;
        check::not_negative("rotor_momentum_kg_m2_ps", self.rotor_momentum_kg_m2_ps)?;
        check::not_negative("drag_ns_per_m", self.drag_ns_per_m)?;
        check::not_negative("drag_ns2_per_m2", self.drag_ns2_per_m2)
    }
}
