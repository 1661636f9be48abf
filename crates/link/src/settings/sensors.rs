//! Settings of the vehicle's sensors, as their readings arrive.

use serde::{Deserialize, Serialize};
use touchdown_flight::error::{SettingsError, not_negative, positive, within};
use touchdown_lander::settings::SensorNumbers;

use super::between;

/// The sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorSettings {
    /// Latency of specific force and attitude, s.
    pub imu_latency_s: f64,
    /// Longest gap between two of their messages that is bridged by the last one, s.
    pub imu_gap_s: f64,
    /// Position of the range finder from the vehicle's reference point, forward-left-up, m.
    pub range_position_m: [f64; 3],
    /// Smallest and largest distance of the range finder, m.
    pub range_limits_m: [f64; 2],
    /// Latency of the range finder: age of a range at its time stamp, s.
    pub range_latency_s: f64,
    /// Steps in which ranges arrive, m. An autopilot sends whole centimetres without their fraction, and PX4 leaves some out:
    /// at 0.1 m the error of a range with 5 mm of noise was 9 to 10 mm over PX4, as that of steps of 3 cm.
    pub range_quantum_m: f64,
    /// Error of `LANDING_TARGET` on each axis close to the deck, standard deviation, m.
    pub target_sd_m: f64,
    /// Further error of `LANDING_TARGET`, as a share of the distance: √(`target_sd_m`² + (share · distance)²). A tag that is
    /// seen under half the angle gives half the precision.
    pub target_sd_share: f64,
    /// Age of a `LANDING_TARGET` without a time stamp, at its arrival, s.
    pub target_latency_s: f64,
    /// Least time between two velocities that are used, s. They come from the autopilot's own filter, so that faster ones
    /// repeat each other's errors.
    pub velocity_period_s: f64,
    /// A reading older than this at its arrival is ignored, s.
    pub greatest_age_s: f64,
}

impl Default for SensorSettings {
    fn default() -> Self {
        let numbers = SensorNumbers::default();
        Self {
            imu_latency_s: numbers.imu_latency_s,
            imu_gap_s: 0.05,
            range_position_m: numbers.range_position_m.to_array(),
            range_limits_m: numbers.range_limits_m,
            range_latency_s: 0.02,
            range_quantum_m: 0.03,
            target_sd_m: 0.003,
            target_sd_share: 0.01,
            target_latency_s: 0.05,
            velocity_period_s: 0.1,
            greatest_age_s: 0.3,
        }
    }
}

impl SensorSettings {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        let latency_s = self.imu_latency_s;
        between("sensors.imu_latency_s", latency_s, 0.0..=0.2, "0 to 0.2 s")?;
        between(
            "sensors.imu_gap_s",
            self.imu_gap_s,
            0.01..=0.5,
            "0.01 to 0.5 s",
        )?;
        let key = "sensors.range_limits_m";
        let [least_m, greatest_m] = self.range_limits_m;
        not_negative(key, least_m)?;
        let above = greatest_m > least_m;
        within(
            key,
            greatest_m,
            above,
            "a smallest distance and a larger one",
        )?;
        between(
            "sensors.range_latency_s",
            self.range_latency_s,
            0.0..=0.2,
            "0 to 0.2 s",
        )?;
        not_negative("sensors.range_quantum_m", self.range_quantum_m)?;
        positive("sensors.target_sd_m", self.target_sd_m)?;
        not_negative("sensors.target_sd_share", self.target_sd_share)?;
        let latency_s = self.target_latency_s;
        between(
            "sensors.target_latency_s",
            latency_s,
            0.0..=0.3,
            "0 to 0.3 s",
        )?;
        not_negative("sensors.velocity_period_s", self.velocity_period_s)?;
        let key = "sensors.greatest_age_s";
        between(key, self.greatest_age_s, 0.01..=1.0, "0.01 to 1 s")
    }
}
