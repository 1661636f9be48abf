//! Settings of identification from flights.

use serde::{Deserialize, Serialize};

/// Resampled sets of flights at most: ends of intervals are then known to a hundredth of their length, and each set takes memory.
const MOST_RESAMPLES: usize = 100_000;

/// What is known of the vehicle, and how flights are read.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlightSettings {
    /// Mass (kg); absent: the map's. Thrust in newtons needs it, ratios of thrust do not.
    pub mass_kg: Option<f64>,
    /// Rotor radius R (m). The ground effect needs it.
    pub rotor_radius_m: Option<f64>,
    /// Added to `height_m` (m): heights count from where the feet stand on the ground. Minus the standing height of the logs.
    pub height_offset_m: f64,
    /// Gravity (m/s²).
    pub gravity_mps2: f64,
    /// Throttle above which the motors run.
    pub idle_throttle: f64,
    /// Heights above so many rotor radii are out of ground effect: the reference.
    pub reference_radii: f64,
    /// Standard deviation of a flight's constant error of height, in rotor radii.
    pub height_bias_radii: f64,
    /// Slowest rate of the throttle at which lags are estimated (Hz).
    pub least_rate_hz: f64,
    /// Resampled sets of flights for intervals.
    pub resamples: usize,
    /// Seed of the resampling.
    pub seed: u64,
}

impl Default for FlightSettings {
    fn default() -> Self {
        Self {
            mass_kg: None,
            rotor_radius_m: None,
            height_offset_m: 0.0,
            gravity_mps2: 9.81,
            idle_throttle: 0.02,
            reference_radii: 4.0,
            height_bias_radii: 0.15,
            least_rate_hz: 40.0,
            resamples: 1000,
            seed: 1,
        }
    }
}

impl FlightSettings {
    /// The first key out of range: its name, what it must be, and what was found.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, &'static str, String)> {
        const POSITIVE: &str = "a finite number above 0";
        let positive = [
            ("flight.mass_kg", self.mass_kg),
            ("flight.rotor_radius_m", self.rotor_radius_m),
            ("flight.gravity_mps2", Some(self.gravity_mps2)),
            ("flight.height_bias_radii", Some(self.height_bias_radii)),
            ("flight.least_rate_hz", Some(self.least_rate_hz)),
        ];
        for (key, value) in positive {
            if let Some(v) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Some((key, POSITIVE, v.to_string()));
            }
        }
        if !self.height_offset_m.is_finite() {
            return Some((
                "flight.height_offset_m",
                "a finite number",
                self.height_offset_m.to_string(),
            ));
        }
        if !(0.0..1.0).contains(&self.idle_throttle) {
            return Some((
                "flight.idle_throttle",
                "at least 0, less than 1",
                self.idle_throttle.to_string(),
            ));
        }
        if !(self.reference_radii >= 2.0 && self.reference_radii.is_finite()) {
            return Some((
                "flight.reference_radii",
                "at least 2",
                self.reference_radii.to_string(),
            ));
        }
        if !(100..=MOST_RESAMPLES).contains(&self.resamples) {
            return Some((
                "flight.resamples",
                "100 to 100000",
                self.resamples.to_string(),
            ));
        }
        None
    }
}
