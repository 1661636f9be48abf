//! Settings of the plant.

use serde::{Deserialize, Serialize};

use super::Plant;
use crate::air::exponential::ExponentialSettings;
use crate::air::ground::{Surface, WakeSettings};
use crate::body::motor::MotorSettings;
use crate::error::SimError;

/// Ground-effect law of the plant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroundLaw {
    /// Image sources, fountain, finite plate and two lags.
    #[default]
    WakeLag,
    /// An exponential in the height with one lag.
    Exponential,
}

/// All parameters of the plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantSettings {
    /// Mass of the vehicle m, kg.
    pub mass_kg: f64,
    /// Gravity g, m/s².
    pub gravity_mps2: f64,
    /// Rotor radius R, m.
    pub rotor_radius_m: f64,
    /// Distance of neighbouring rotor axes d, m; opposite axes are √2 d apart.
    pub rotor_spacing_m: f64,
    /// Height of the rotor plane above the reference point h_r, m.
    pub rotor_height_m: f64,
    /// Side of the square plate, m.
    pub plate_side_m: f64,
    /// The surface below.
    pub surface: Surface,
    /// The law of the ground effect.
    pub ground_law: GroundLaw,
    /// Scale of the ground effect γ (0.42 fits published flight logs).
    pub ground_effect_scale: f64,
    /// Gain of the fountain K_b.
    pub fountain_gain: f64,
    /// Time constant of a rotor's own inflow at hover and z_r = 5/3 R (0.2 m for R = 0.12 m), s.
    pub rotor_lag_s: f64,
    /// Time constant of the fountain at hover and z_r = 5/3 R (0.2 m for R = 0.12 m), s.
    pub fountain_lag_s: f64,
    /// Climb damping at hover k_v, N s/m.
    pub climb_damping_ns_per_m: f64,
    /// Turbulence c_t in `sd = c_t x² (0.2 + (q1* + q2*)/0.15)`; 0 for none.
    pub turbulence: f64,
    /// Correlation time of the turbulence, s.
    pub turbulence_correlation_s: f64,
    /// The motors.
    pub motor: MotorSettings,
    /// The exponential law, used if `ground_law` is `exponential`.
    pub exponential: ExponentialSettings,
}

impl Default for PlantSettings {
    /// The paper's quadrotor and plate; values that the paper does not print have the order
    /// of magnitude of their physics.
    ///
    /// - Mass and rotor radius: the paper's, 1.37 kg and 0.12 m. Rotor spacing 2.7 R and
    ///   rotor height 0.05 m are those of a common frame of this size.
    /// - Fountain gain 2: of the order in Sanchez-Cuevas et al. (2017).
    /// - Rotor lag: near the wake's travel time `z_r / v_i` = 36 ms at 0.2 m, with the
    ///   induced speed v_i = 5.6 m/s in hover. The fountain recirculates several times
    ///   farther, so its lag is some times longer.
    /// - Climb damping: a third of `W / v_i`, a blade-element order of magnitude.
    /// - Turbulence: a standard deviation of 0.2 % of the thrust far from the ground, and
    ///   about 1 % near it; its correlation time is that of eddies of the plate's size.
    fn default() -> Self {
        Self {
            mass_kg: 1.37,
            gravity_mps2: 9.81,
            rotor_radius_m: 0.12,
            rotor_spacing_m: 0.32,
            rotor_height_m: 0.05,
            plate_side_m: 1.5,
            surface: Surface::Plate,
            ground_law: GroundLaw::WakeLag,
            ground_effect_scale: 1.0,
            fountain_gain: 2.0,
            rotor_lag_s: 0.05,
            fountain_lag_s: 0.28,
            climb_damping_ns_per_m: 0.79,
            turbulence: 0.01,
            turbulence_correlation_s: 0.15,
            motor: MotorSettings::default(),
            exponential: ExponentialSettings::default(),
        }
    }
}

impl PlantSettings {
    /// The default values with the second plant's law.
    #[must_use]
    pub fn exponential() -> Self {
        Self {
            ground_law: GroundLaw::Exponential,
            ..Self::default()
        }
    }

    /// Weight W = m g, N.
    #[must_use]
    pub fn weight_n(&self) -> f64 {
        self.mass_kg * self.gravity_mps2
    }

    /// The settings of the wake law.
    #[must_use]
    pub fn wake(&self) -> WakeSettings {
        WakeSettings {
            surface: self.surface,
            plate_side_m: self.plate_side_m,
            rotor_radius_m: self.rotor_radius_m,
            rotor_spacing_m: self.rotor_spacing_m,
            weight_n: self.weight_n(),
            scale: self.ground_effect_scale,
            fountain_gain: self.fountain_gain,
            rotor_lag_s: self.rotor_lag_s,
            fountain_lag_s: self.fountain_lag_s,
        }
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn validate(&self) -> Result<(), SimError> {
        Plant::new(self).map(|_| ())
    }
}
