//! Settings of the vehicle's sensors.

use serde::{Deserialize, Serialize};

use super::camera::tags::TagSettings;
use crate::check;
use crate::error::SimError;

/// How the readings of a sensor come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Schedule {
    /// Readings per second, Hz.
    pub rate_hz: f64,
    /// Time from the moment that is measured to the arrival, s.
    pub latency_s: f64,
    /// Further latency, half-normal, its scale, s. Its mean is known to the
    /// vehicle, the rest is an error of a reading's age.
    pub jitter_s: f64,
    /// Share of readings that get lost.
    pub loss_share: f64,
}

impl Schedule {
    /// A schedule without losses.
    #[must_use]
    pub const fn new(rate_hz: f64, latency_s: f64, jitter_s: f64) -> Self {
        Self {
            rate_hz,
            latency_s,
            jitter_s,
            loss_share: 0.0,
        }
    }

    /// Checks the schedule.
    ///
    /// # Errors
    /// The rate lies in 0.1..1000 Hz, times in 0..0.25 s, the share below 1.
    pub fn validate(&self) -> Result<(), SimError> {
        check::within("rate_hz", self.rate_hz, 0.1, 1.0 / crate::STEP_S)?;
        check::within("latency_s", self.latency_s, 0.0, 0.25)?;
        check::within("jitter_s", self.jitter_s, 0.0, 0.1)?;
        check::within("loss_share", self.loss_share, 0.0, 0.99)
    }
}

/// Inertial unit and the attitude that is made of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImuSettings {
    /// Specific force, white noise, m/s²/√Hz.
    pub noise_density: f64,
    /// Its bias on each axis, constant over a landing: standard deviation, m/s².
    pub bias_sd_mps2: f64,
    /// Age of specific force and attitude when the landing computer gets them, s.
    pub latency_s: f64,
    /// Error of roll and pitch, constant over a landing: standard deviation, rad.
    pub tilt_bias_sd_rad: f64,
    /// Error of roll and pitch that wanders: standard deviation, rad.
    pub tilt_wander_sd_rad: f64,
    /// Its correlation time, s.
    pub tilt_wander_s: f64,
    /// Error of heading, constant over a landing: standard deviation, rad.
    pub yaw_bias_sd_rad: f64,
    /// White noise of the rates in a step of the attitude control, rad/s.
    pub gyro_sd: f64,
}

impl Default for ImuSettings {
    /// 0.015 m/s²/√Hz (0.15 m/s² over 10 ms), bias 0.03 m/s², 20 ms old; tilt to
    /// 5 mrad and 2 mrad in 1 s, heading to 20 mrad, rates to 10 mrad/s.
    fn default() -> Self {
        Self {
            noise_density: 0.015,
            bias_sd_mps2: 0.03,
            latency_s: 0.02,
            tilt_bias_sd_rad: 0.005,
            tilt_wander_sd_rad: 0.002,
            tilt_wander_s: 1.0,
            yaw_bias_sd_rad: 0.02,
            gyro_sd: 0.01,
        }
    }
}

/// The range finder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RangeSettings {
    /// When readings come.
    pub schedule: Schedule,
    /// Place in body axes, m; the beam is against the body's z axis.
    pub place_m: [f64; 3],
    /// White noise, standard deviation, m.
    pub noise_sd_m: f64,
    /// Quantum, m; 0 for none.
    pub quantum_m: f64,
    /// Least distance that is read, m.
    pub least_m: f64,
    /// Greatest distance that is read, m.
    pub greatest_m: f64,
}

impl Default for RangeSettings {
    /// 50 Hz, 20 ms and 2 ms; at the reference point; 5 mm, whole centimetres, 0.02 to
    /// 12 m.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(50.0, 0.02, 0.002),
            place_m: [0.0; 3],
            noise_sd_m: 0.005,
            quantum_m: 0.01,
            least_m: 0.02,
            greatest_m: 12.0,
        }
    }
}

/// Velocity by satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GnssSettings {
    /// When readings come.
    pub schedule: Schedule,
    /// Horizontal noise on each axis, standard deviation, m/s.
    pub horizontal_sd_mps: f64,
    /// Vertical noise, standard deviation, m/s.
    pub vertical_sd_mps: f64,
    /// Error on each axis that wanders: standard deviation, m/s.
    pub wander_sd_mps: f64,
    /// Its correlation time, s.
    pub wander_s: f64,
}

impl Default for GnssSettings {
    /// 10 Hz, 100 ms and 5 ms; 0.05 and 0.08 m/s, and 0.03 m/s within 10 s.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(10.0, 0.1, 0.005),
            horizontal_sd_mps: 0.05,
            vertical_sd_mps: 0.08,
            wander_sd_mps: 0.03,
            wander_s: 10.0,
        }
    }
}

/// The barometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BarometerSettings {
    /// When readings come.
    pub schedule: Schedule,
    /// White noise, standard deviation, m.
    pub noise_sd_m: f64,
    /// Slow drift, standard deviation of its change, m/√s.
    pub drift: f64,
    /// How much lower it reads on the deck, for the rotors' pressure under the
    /// vehicle, m; falls off with height as exp(-z/0.3 m).
    pub ground_effect_m: f64,
}

impl Default for BarometerSettings {
    /// 20 Hz, 30 ms and 2 ms; 0.12 m, 0.02 m/√s, 1.5 m too low on the deck.
    fn default() -> Self {
        Self {
            schedule: Schedule::new(20.0, 0.03, 0.002),
            noise_sd_m: 0.12,
            drift: 0.02,
            ground_effect_m: 1.5,
        }
    }
}

/// How tags are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraMode {
    /// Without images, with the errors that a detector makes.
    #[default]
    Fast,
    /// By a detector in rendered images; needs a [`crate::sensors::camera::pipeline::PipelineFactory`].
    Rendered,
}

/// All sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorSettings {
    /// How tags are found.
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
    /// Whether there is a barometer.
    pub with_barometer: bool,
}

impl Default for SensorSettings {
    /// All of them.
    fn default() -> Self {
        Self {
            camera: CameraMode::default(),
            imu: ImuSettings::default(),
            range: RangeSettings::default(),
            tag: TagSettings::default(),
            gnss: GnssSettings::default(),
            barometer: BarometerSettings::default(),
            with_gnss: true,
            with_barometer: true,
        }
    }
}

impl SensorSettings {
    /// The same sensors without noise, bias, jitter, losses and quantum; rates and
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
            .map_err(|e| e.in_section("barometer"))
    }
}

impl ImuSettings {
    fn validate(&self) -> Result<(), SimError> {
        check::not_negative("noise_density", self.noise_density)?;
        check::not_negative("bias_sd_mps2", self.bias_sd_mps2)?;
        check::within("latency_s", self.latency_s, 0.0, 0.1)?;
        check::within("tilt_bias_sd_rad", self.tilt_bias_sd_rad, 0.0, 0.2)?;
        check::within("tilt_wander_sd_rad", self.tilt_wander_sd_rad, 0.0, 0.2)?;
        check::positive("tilt_wander_s", self.tilt_wander_s)?;
        check::within("yaw_bias_sd_rad", self.yaw_bias_sd_rad, 0.0, 1.0)?;
        check::not_negative("gyro_sd", self.gyro_sd)
    }
}

impl RangeSettings {
    fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        for value in self.place_m {
            check::finite("place_m", value)?;
        }
        check::not_negative("noise_sd_m", self.noise_sd_m)?;
        check::not_negative("quantum_m", self.quantum_m)?;
        check::not_negative("least_m", self.least_m)?;
        check::that(
            self.greatest_m.is_finite() && self.greatest_m > self.least_m,
            "greatest_m",
            "a distance above `least_m`",
            self.greatest_m,
        )
    }
}

impl GnssSettings {
    fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        check::not_negative("horizontal_sd_mps", self.horizontal_sd_mps)?;
        check::not_negative("vertical_sd_mps", self.vertical_sd_mps)?;
        check::not_negative("wander_sd_mps", self.wander_sd_mps)?;
        check::positive("wander_s", self.wander_s)
    }
}

impl BarometerSettings {
    fn validate(&self) -> Result<(), SimError> {
        self.schedule
            .validate()
            .map_err(|e| e.in_section("schedule"))?;
        check::not_negative("noise_sd_m", self.noise_sd_m)?;
        check::not_negative("drift", self.drift)?;
        check::finite("ground_effect_m", self.ground_effect_m)
    }
}
