//! Sensors of the force rig and of the vehicle: noise, latency, losses.

mod barometer;
mod beacon;
pub mod camera;
mod gnss;
pub(crate) mod history;
mod inertial;
mod load_cell;
mod range_finder;
mod schedule;
pub(crate) mod suite;
mod vertical;

use serde::{Deserialize, Serialize};

use crate::error::SimError;

pub use barometer::BarometerSettings;
pub use beacon::BeaconSettings;
pub use camera::tags::TagSettings;
pub use gnss::GnssSettings;
pub use inertial::ImuSettings;
pub(crate) use inertial::LOG_STEPS;
pub use load_cell::LoadCellSettings;
pub use range_finder::{RangeRow, RangeSettings};
pub use schedule::Schedule;
pub(crate) use schedule::Wander;
pub use vertical::FlightSensorSettings;

/// Model of the tag detection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraMode {
    /// No images; poses have the measured errors of a detector.
    #[default]
    Fast,
    /// A detector runs on rendered images. It needs a [`camera::pipeline::PipelineFactory`].
    Rendered,
}

/// All sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorSettings {
    /// Model of the tag detection.
    pub camera: CameraMode,
    /// Inertial unit.
    pub imu: ImuSettings,
    /// Range finder.
    pub range: RangeSettings,
    /// Camera.
    pub tag: TagSettings,
    /// Satellite navigation.
    pub gnss: GnssSettings,
    /// Barometer.
    pub barometer: BarometerSettings,
    /// Whether there is satellite navigation.
    pub with_gnss: bool,
    /// Broadcast of the deck.
    pub beacon: BeaconSettings,
    /// Whether there is a barometer.
    pub with_barometer: bool,
    /// Whether the deck broadcasts its place and velocity.
    pub with_beacon: bool,
}

impl Default for SensorSettings {
    /// All sensors, with their own defaults.
    fn default() -> Self {
        Self {
            camera: CameraMode::default(),
            imu: ImuSettings::default(),
            range: RangeSettings::default(),
            tag: TagSettings::default(),
            gnss: GnssSettings::default(),
            barometer: BarometerSettings::default(),
            with_gnss: true,
            beacon: BeaconSettings::default(),
            with_barometer: true,
            with_beacon: false,
        }
    }
}

impl SensorSettings {
    /// The same sensors without noise, bias, jitter, losses and rounding. Rates and
    /// latencies stay.
    #[must_use]
    pub fn perfect(mut self) -> Self {
        let exact = |schedule: &mut Schedule| {
            schedule.jitter_s = 0.0;
            schedule.loss_share = 0.0;
        };
        self.imu = ImuSettings {
            latency_s: self.imu.latency_s,
            noise_density: 0.0,
            bias_sd_mps2: 0.0,
            tilt_bias_sd_rad: 0.0,
            tilt_wander_sd_rad: 0.0,
            yaw_bias_sd_rad: 0.0,
            gyro_sd: 0.0,
            ..self.imu
        };
        exact(&mut self.range.schedule);
        self.range.noise_sd_m = 0.0;
        self.range.quantum_m = 0.0;
        exact(&mut self.tag.schedule);
        self.tag.errors = false;
        exact(&mut self.gnss.schedule);
        self.gnss.horizontal_sd_mps = 0.0;
        self.gnss.vertical_sd_mps = 0.0;
        self.gnss.wander_sd_mps = 0.0;
        exact(&mut self.barometer.schedule);
        self.barometer.noise_sd_m = 0.0;
        self.barometer.drift = 0.0;
        self.barometer.ground_effect_m = 0.0;
        exact(&mut self.beacon.schedule);
        self.beacon.horizontal_sd_m = 0.0;
        self.beacon.vertical_sd_m = 0.0;
        self.beacon.velocity_sd_mps = 0.0;
        self.beacon.velocity_wander_sd_mps = 0.0;
        self
    }

    /// Checks the settings.
    ///
    /// # Errors
    /// Names the first bad key, what is expected and the offending number.
    pub fn validate(&self) -> Result<(), SimError> {
        self.imu.validate().map_err(|e| e.in_section("imu"))?;
        self.range.validate().map_err(|e| e.in_section("range"))?;
        self.tag.validate().map_err(|e| e.in_section("tag"))?;
        self.gnss.validate().map_err(|e| e.in_section("gnss"))?;
        self.barometer
            .validate()
            .map_err(|e| e.in_section("barometer"))?;
        self.beacon.validate().map_err(|e| e.in_section("beacon"))
    }
}
