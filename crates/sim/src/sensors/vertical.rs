//! Measurements of the vertical vehicle.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;

/// The vehicle's own measurements, sampled once a control period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlightSensorSettings {
    /// Height above the deck, standard deviation, m.
    pub height_sd_m: f64,
    /// Velocity relative to the deck, standard deviation, m/s.
    pub relative_velocity_sd_mps: f64,
    /// Velocity of the vehicle, standard deviation, m/s.
    pub vehicle_velocity_sd_mps: f64,
    /// Acceleration, standard deviation of a sample, m/s².
    pub acceleration_sd_mps2: f64,
    /// Acceleration, constant bias of a landing: standard deviation, m/s².
    pub acceleration_bias_sd_mps2: f64,
    /// Age of every measurement, s.
    pub latency_s: f64,
}

impl Default for FlightSensorSettings {
    fn default() -> Self {
        Self {
            height_sd_m: 0.003,
            relative_velocity_sd_mps: 0.02,
            vehicle_velocity_sd_mps: 0.02,
            acceleration_sd_mps2: 0.15,
            acceleration_bias_sd_mps2: 0.03,
            latency_s: 0.02,
        }
    }
}

impl FlightSensorSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Standard deviations must not be negative and the age is 0..1 s.
    pub fn validate(&self) -> Result<(), SimError> {
        check::not_negative("height_sd_m", self.height_sd_m)?;
        check::not_negative("relative_velocity_sd_mps", self.relative_velocity_sd_mps)?;
        check::not_negative("vehicle_velocity_sd_mps", self.vehicle_velocity_sd_mps)?;
        check::not_negative("acceleration_sd_mps2", self.acceleration_sd_mps2)?;
        check::not_negative("acceleration_bias_sd_mps2", self.acceleration_bias_sd_mps2)?;
        check::within("latency_s", self.latency_s, 0.0, 1.0)
    }

    /// The same sensors without noise; their age stays.
    #[must_use]
    pub fn without_noise(self) -> Self {
        Self {
            height_sd_m: 0.0,
            relative_velocity_sd_mps: 0.0,
            vehicle_velocity_sd_mps: 0.0,
            acceleration_sd_mps2: 0.0,
            acceleration_bias_sd_mps2: 0.0,
            latency_s: self.latency_s,
        }
    }
}
