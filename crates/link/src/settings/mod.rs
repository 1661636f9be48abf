//! Settings of a flight, as they stand in `FLIGHT.toml`.

mod replaced;
mod sensors;

pub use replaced::replaced_by;
pub use sensors::SensorSettings;

use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use touchdown_flight::error::{SettingsError, positive, within};
use touchdown_flight::{Attitude, Vector};
use touchdown_lander::computer::Computer;
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{ControlSettings, LoopTiming, SensorNumbers, VehicleNumbers};

use crate::camera::CameraSettings;

/// Greatest age up to which a reading may count as fresh, s: a deck at 0.5 Hz is half a period on by then.
const GREATEST_AGE_S: f64 = 1.0;

/// The side of the autopilot's thrust curve on which the thrust card stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ThrottleSide {
    /// The card maps the motors' signal to thrust.
    #[default]
    MotorSignal,
    /// The card maps the autopilot's thrust setpoint to thrust.
    ThrustSetpoint,
}

/// The vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleSettings {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: f64,
    /// Radius of a rotor, m.
    pub rotor_radius_m: f64,
    /// Number of rotors; absent: the thrust card's. A card of one motor needs it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotors: Option<u32>,
    /// Meaning of the throttle of the thrust card.
    pub throttle: ThrottleSide,
    /// Time from a command to the attitude control, s.
    pub command_delay_s: f64,
}

impl Default for VehicleSettings {
    /// The paper's quadrotor.
    fn default() -> Self {
        let numbers = VehicleNumbers::default();
        Self {
            mass_kg: numbers.mass_kg,
            gravity_mps2: numbers.gravity_mps2,
            rotor_radius_m: numbers.rotor_radius_m,
            rotors: None,
            throttle: ThrottleSide::default(),
            command_delay_s: LoopTiming::default().command_delay_s,
        }
    }
}

/// Rates that the autopilot is asked for, Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RateSettings {
    /// `ATTITUDE_QUATERNION`.
    pub attitude_hz: f64,
    /// `HIGHRES_IMU` of PX4, `SCALED_IMU` of ArduPilot.
    pub imu_hz: f64,
    /// `DISTANCE_SENSOR`.
    pub range_hz: f64,
    /// `LOCAL_POSITION_NED`.
    pub velocity_hz: f64,
    /// `LANDING_TARGET`: its sender is not asked, its rate is only judged.
    pub target_hz: f64,
    /// Least share of these rates with which control is possible.
    pub least_share: f64,
}

impl Default for RateSettings {
    fn default() -> Self {
        Self {
            attitude_hz: 100.0,
            imu_hz: 100.0,
            range_hz: 50.0,
            velocity_hz: 30.0,
            target_hz: 20.0,
            least_share: 0.5,
        }
    }
}

/// Limits beyond which the companion gives the vehicle back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LimitSettings {
    /// Silence of the autopilot, s.
    pub silent_s: f64,
    /// Age of the newest attitude or specific force, s.
    pub stale_s: f64,
    /// Longest round trip of a time synchronisation before control, s.
    pub round_trip_s: f64,
    /// Greatest difference between the hover thrust of the thrust card and that of the autopilot.
    pub hover_thrust: f64,
    /// Longest time after which the autopilot leaves a setpoint that is not renewed, s.
    pub failsafe_s: f64,
}

impl Default for LimitSettings {
    fn default() -> Self {
        Self {
            silent_s: 0.3,
            stale_s: 0.4,
            round_trip_s: 0.02,
            hover_thrust: 0.15,
            failsafe_s: 0.5,
        }
    }
}

/// Model cards that replace the default models. Paths are relative to the settings file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CardSettings {
    /// Thrust.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thrust: Option<PathBuf>,
    /// Ground effect of `empirical`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical: Option<PathBuf>,
    /// Ground effect of `dynamic` and `dynamic+observer`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic: Option<PathBuf>,
}

/// A deck that reports its own position, as another system on the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeckSettings {
    /// System id of the deck; 0 for none.
    pub system_id: u8,
    /// Age of its position at arrival, s.
    pub latency_s: f64,
    /// Error of the position relative to the vehicle on each axis, standard deviation, m.
    pub sd_m: f64,
}

impl Default for DeckSettings {
    fn default() -> Self {
        Self {
            system_id: 0,
            latency_s: 0.05,
            sd_m: 0.02,
        }
    }
}

/// Signatures of MAVLink 2.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SigningSettings {
    /// File with the key: 64 hexadecimal digits, or a passphrase of at least 8 letters. Relative to the settings file. Without it nothing is signed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key_file: Option<PathBuf>,
    /// Id of this link.
    pub link_id: u8,
}

/// All settings of a flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlightSettings {
    /// The link to the autopilot.
    pub link: String,
    /// System id of the vehicle; 0 for the first one that is heard.
    pub system_id: u8,
    /// Component id of the companion, from 2: 1 is the autopilot's.
    pub component_id: u8,
    /// The deck, if it reports its own position.
    pub deck: DeckSettings,
    /// Signatures.
    pub signing: SigningSettings,
    /// Model cards.
    pub cards: CardSettings,
    /// The vehicle.
    pub vehicle: VehicleSettings,
    /// The sensors.
    pub sensors: SensorSettings,
    /// The camera.
    pub camera: CameraSettings,
    /// The rates.
    pub rates: RateSettings,
    /// The limits.
    pub limits: LimitSettings,
    /// The landing computer.
    pub control: ControlSettings<f64>,
    /// The models of thrust and ground effect.
    pub models: FlightModels<f64>,
}

impl Default for FlightSettings {
    fn default() -> Self {
        Self {
            link: "udpin:0.0.0.0:14540".to_string(),
            system_id: 0,
            component_id: 191,
            deck: DeckSettings::default(),
            signing: SigningSettings::default(),
            cards: CardSettings::default(),
            vehicle: VehicleSettings::default(),
            sensors: SensorSettings::default(),
            camera: CameraSettings::default(),
            rates: RateSettings::default(),
            limits: LimitSettings::default(),
            control: ControlSettings::default(),
            models: FlightModels::default(),
        }
    }
}

/// Time between two ticks of the companion, s.
pub const PERIOD_S: f64 = 0.01;

impl FlightSettings {
    /// Whether the companion has a camera of its own.
    #[must_use]
    pub fn has_camera(&self) -> bool {
        let camera = &self.camera;
        camera.device.is_some() || camera.folder.is_some() || camera.command.is_some()
    }

    /// The same with the images of a program in the place of the companion's own camera, or without a camera.
    #[must_use]
    pub fn with_camera_command(&self, command: Option<Vec<String>>) -> Self {
        let mut settings = self.clone();
        let camera = &mut settings.camera;
        (camera.device, camera.folder, camera.times) = (None, None, None);
        camera.command = command;
        settings
    }

    /// Checks all settings and builds the landing computer, as campaigns do.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn computer(&self) -> Result<Computer<f64>, SettingsError> {
        self.check()?;
        let vehicle = VehicleNumbers {
            mass_kg: self.vehicle.mass_kg,
            gravity_mps2: self.vehicle.gravity_mps2,
            rotor_radius_m: self.vehicle.rotor_radius_m,
            greatest_thrust_n: self.models.thrust.rest(1.0).powi(2),
        };
        let weight_n = vehicle.mass_kg * vehicle.gravity_mps2;
        let flies = weight_n < vehicle.greatest_thrust_n;
        let expected = "a mass whose weight is below the greatest thrust of the thrust card";
        within("vehicle.mass_kg", vehicle.mass_kg, flies, expected)?;
        let sensors = SensorNumbers {
            imu_latency_s: self.sensors.imu_latency_s,
            range_position_m: Vector::from_array(self.sensors.range_position_m),
            range_quantum_m: self.sensors.range_quantum_m,
            range_limits_m: self.sensors.range_limits_m,
            // Positions of the deck arrive relative to the vehicle's reference point, in body axes.
            camera_position_m: Vector::ZERO,
            camera_turn_rad: 0.0,
            ..SensorNumbers::default()
        };
        let timing = LoopTiming {
            period_s: PERIOD_S,
            command_delay_s: self.vehicle.command_delay_s,
        };
        if let Some((key, found, _)) = self.control.without_effect() {
            let (key, expected) = replaced::expected(key);
            return Err(SettingsError::OutOfRange {
                key,
                expected,
                found,
            });
        }
        let mut control = self.control.clone();
        control.relative.tag.attitude = Attitude::LEVEL;
        let hold_height_m = control.state_machine.hold_height_m;
        control.computer(&self.models, &vehicle, &sensors, &timing, hold_height_m)
    }

    fn check(&self) -> Result<(), SettingsError> {
        self.vehicle.check()?;
        self.sensors.check()?;
        self.rates.check()?;
        let latency_s = self.deck.latency_s;
        between("deck.latency_s", latency_s, 0.0..=0.3, "0 to 0.3 s")?;
        positive("deck.sd_m", self.deck.sd_m)?;
        let component_id = f64::from(self.component_id);
        between("component_id", component_id, 2.0..=255.0, "2 to 255")?;
        self.ages()?;
        self.limits.check()
    }

    /// The ages up to which the landing computer descends by a reading, and takes it for fresh.
    fn ages(&self) -> Result<(), SettingsError> {
        let (lander, relative) = (&self.control.state_machine, &self.control.relative);
        for (key, age_s) in [
            ("control.lander.range_age_s", lander.range_age_s),
            ("control.lander.tag_age_s", lander.tag_age_s),
            ("control.lander.imu_age_s", lander.imu_age_s),
            ("control.relative.imu.stale_s", relative.imu.stale_s),
            ("control.relative.range.stale_s", relative.range.stale_s),
            ("control.relative.tag.stale_s", relative.tag.stale_s),
        ] {
            between(key, age_s, 0.0..=GREATEST_AGE_S, "0 to 1 s")?;
        }
        Ok(())
    }
}

/// Accepts a value within its bounds, which `expected` names.
fn between(
    key: &'static str,
    value: f64,
    bounds: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), SettingsError> {
    within(key, value, bounds.contains(&value), expected)
}

impl VehicleSettings {
    fn check(&self) -> Result<(), SettingsError> {
        positive("vehicle.mass_kg", self.mass_kg)?;
        positive("vehicle.gravity_mps2", self.gravity_mps2)?;
        positive("vehicle.rotor_radius_m", self.rotor_radius_m)?;
        if let Some(rotors) = self.rotors {
            positive("vehicle.rotors", f64::from(rotors))?;
        }
        let key = "vehicle.command_delay_s";
        between(key, self.command_delay_s, 0.0..=0.5, "0 to 0.5 s")
    }
}

impl RateSettings {
    fn check(&self) -> Result<(), SettingsError> {
        for (key, hz) in [
            ("rates.attitude_hz", self.attitude_hz),
            ("rates.imu_hz", self.imu_hz),
            ("rates.range_hz", self.range_hz),
            ("rates.velocity_hz", self.velocity_hz),
            ("rates.target_hz", self.target_hz),
        ] {
            between(key, hz, 1.0..=1000.0, "1 to 1000 Hz")?;
        }
        between(
            "rates.least_share",
            self.least_share,
            0.05..=1.0,
            "0.05 to 1",
        )
    }
}

impl LimitSettings {
    fn check(&self) -> Result<(), SettingsError> {
        between("limits.silent_s", self.silent_s, 0.05..=1.0, "0.05 to 1 s")?;
        between("limits.stale_s", self.stale_s, 0.05..=1.0, "0.05 to 1 s")?;
        let round_trip_s = self.round_trip_s;
        between(
            "limits.round_trip_s",
            round_trip_s,
            0.001..=0.5,
            "0.001 to 0.5 s",
        )?;
        between(
            "limits.hover_thrust",
            self.hover_thrust,
            0.01..=1.0,
            "0.01 to 1",
        )?;
        between(
            "limits.failsafe_s",
            self.failsafe_s,
            0.1..=5.0,
            "0.1 to 5 s",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_no_setting_lets_old_readings_count_as_fresh() {
        let refused = |change: fn(&mut ControlSettings<f64>)| {
            let mut settings = FlightSettings::default();
            change(&mut settings.control);
            settings.computer().unwrap_err().to_string()
        };
        let said = refused(|control| control.state_machine.tag_age_s = 100.0);
        assert!(said.contains("control.lander.tag_age_s"), "{said}");
        let said = refused(|control| control.relative.range.stale_s = 100.0);
        assert!(said.contains("control.relative.range.stale_s"), "{said}");
    }

    #[test]
    fn prop_the_defaults_can_be_flown() {
        FlightSettings::default().computer().unwrap();
    }

    #[test]
    fn prop_unknown_keys_and_absurd_values_are_refused() {
        let error = toml::from_str::<FlightSettings>("[vehicle]\nmas_kg = 1.0\n").unwrap_err();
        assert!(error.to_string().contains("mas_kg"), "{error}");
        let mut settings = FlightSettings::default();
        settings.vehicle.mass_kg = f64::NAN;
        assert!(
            settings
                .computer()
                .unwrap_err()
                .to_string()
                .contains("vehicle.mass_kg")
        );
        let mut settings = FlightSettings::default();
        settings.limits.silent_s = 10.0;
        assert!(
            settings
                .computer()
                .unwrap_err()
                .to_string()
                .contains("limits.silent_s")
        );
    }
}
