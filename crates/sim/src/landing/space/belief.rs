//! What the flight software believes of its vehicle, and how the true vehicle differs.
//!
//! ```text
//! stated vehicle (plant, body) ──> belief: the stated values, or those of `believed`
//!                              └─> truth:  the stated values times the ratios of `truth`
//! ```
//!
//! The landing computer and the attitude control are built from the belief; the physics from the truth.

use serde::{Deserialize, Serialize};

use super::scenario::SpaceScenario;
use crate::body::BodySettings;
use crate::body::motor::{Motor, MotorSettings};
use crate::body::plant::PlantSettings;
use crate::body::rigid::RigidVehicle;
use crate::check;
use crate::error::SimError;

/// What the flight software believes of the vehicle; an absent value is the stated one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BelievedSettings {
    /// Mass, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Rotor radius, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_radius_m: Option<f64>,
    /// Distance of neighbouring rotor axes, m: the lever of roll and pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_spacing_m: Option<f64>,
    /// Moments of inertia about x, y, z, kg m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<[f64; 3]>,
    /// Reaction torque of a rotor over its thrust, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_per_thrust_m: Option<f64>,
    /// Delay of a command, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command_delay_s: Option<f64>,
    /// Latency of specific force and attitude, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu_latency_s: Option<f64>,
    /// Thrust curve, sag and lag of the motors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorSettings>,
}

/// Ratios of the true vehicle to the stated one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TruthSettings {
    /// Ratio of the mass.
    pub mass: f64,
    /// Ratio of the moments of inertia.
    pub inertia: f64,
    /// Ratio of the rotors' distances from the centre.
    pub arm: f64,
    /// Ratio of the thrust at every throttle.
    pub thrust: f64,
    /// Ratio of the motors' time constant.
    pub motor_lag: f64,
    /// Ratio of the delay of commands and of the inertial unit's latency.
    pub delay: f64,
}

impl Default for TruthSettings {
    /// The stated vehicle.
    fn default() -> Self {
        Self {
            mass: 1.0,
            inertia: 1.0,
            arm: 1.0,
            thrust: 1.0,
            motor_lag: 1.0,
            delay: 1.0,
        }
    }
}

impl TruthSettings {
    fn validate(&self) -> Result<(), SimError> {
        check::positive("mass", self.mass)?;
        check::positive("inertia", self.inertia)?;
        check::positive("arm", self.arm)?;
        check::positive("thrust", self.thrust)?;
        check::positive("motor_lag", self.motor_lag)?;
        check::not_negative("delay", self.delay)
    }

    /// The true plant. With x = √T, a thrust of t times as much at every throttle divides the
    /// linear loss by √t and the quadratic one by t.
    #[must_use]
    pub fn plant(&self, stated: &PlantSettings) -> PlantSettings {
        let motor = stated.motor;
        PlantSettings {
            mass_kg: stated.mass_kg * self.mass,
            rotor_spacing_m: stated.rotor_spacing_m * self.arm,
            motor: MotorSettings {
                time_constant_s: motor.time_constant_s * self.motor_lag,
                linear_loss: motor.linear_loss / self.thrust.sqrt(),
                quadratic_loss: motor.quadratic_loss / self.thrust,
                ..motor
            },
            ..*stated
        }
    }

    fn body(&self, stated: &BodySettings) -> BodySettings {
        BodySettings {
            inertia_kg_m2: stated.inertia_kg_m2.map(|i| i * self.inertia),
            ..*stated
        }
    }
}

/// Greatest thrust of a plant over its weight.
///
/// # Errors
/// Motors or a mass that make no sense.
pub fn thrust_to_weight(plant: &PlantSettings) -> Result<f64, SimError> {
    let motor = Motor::new(&plant.motor, plant.weight_n()).map_err(|e| e.in_section("motor"))?;
    Ok(motor.rest(1.0).powi(2) / plant.weight_n())
}

/// The error of a vehicle as one of the belief, whose keys are not divided into `plant` and `body`.
fn of_belief(error: SimError) -> SimError {
    match error {
        SimError::Setting {
            key,
            expected,
            found,
        } => {
            let of_part = ["plant.", "body."].iter().find_map(|s| key.strip_prefix(s));
            SimError::Setting {
                key: of_part.unwrap_or(&key).to_owned(),
                expected,
                found,
            }
            .in_section("believed")
        }
        other => other,
    }
}

impl SpaceScenario {
    /// The error of the true vehicle, by the ratio of `truth` that makes it where the stated vehicle has none.
    pub(super) fn of_truth(&self, error: SimError) -> SimError {
        let truth = &self.truth;
        let ratios = [
            ("plant.mass_kg", "mass", truth.mass),
            ("plant.mass_kg", "thrust", truth.thrust),
            ("plant.rotor_spacing_m", "arm", truth.arm),
            ("plant.motor.time_constant_s", "motor_lag", truth.motor_lag),
            ("plant.motor", "thrust", truth.thrust),
            ("body.inertia_kg_m2", "inertia", truth.inertia),
            ("command_delay_s", "delay", truth.delay),
            ("sensors.imu.latency_s", "delay", truth.delay),
        ];
        let SimError::Setting {
            key,
            expected,
            found,
        } = &error
        else {
            return error;
        };
        let mut made = ratios
            .into_iter()
            .filter(|(of, _, ratio)| key.starts_with(of) && (ratio - 1.0).abs() > 0.0);
        let Some((_, name, _)) = made.next() else {
            return error;
        };
        SimError::Setting {
            key: format!("truth.{name}"),
            expected: format!("for the true `{key}` {expected}"),
            found: found.clone(),
        }
    }

    /// The belief with every value that is absent taken from the stated vehicle.
    #[must_use]
    pub fn complete_belief(&self) -> BelievedSettings {
        let (given, plant, body) = (&self.believed, &self.plant, &self.body);
        let latency_s = self.sensors.imu.latency_s;
        BelievedSettings {
            mass_kg: given.mass_kg.or(Some(plant.mass_kg)),
            rotor_radius_m: given.rotor_radius_m.or(Some(plant.rotor_radius_m)),
            rotor_spacing_m: given.rotor_spacing_m.or(Some(plant.rotor_spacing_m)),
            inertia_kg_m2: given.inertia_kg_m2.or(Some(body.inertia_kg_m2)),
            torque_per_thrust_m: given.torque_per_thrust_m.or(Some(body.torque_per_thrust_m)),
            command_delay_s: given.command_delay_s.or(Some(self.command_delay_s)),
            imu_latency_s: given.imu_latency_s.or(Some(latency_s)),
            motor: given.motor.or(Some(plant.motor)),
        }
    }

    /// The vehicle that is believed.
    ///
    /// # Errors
    /// Believed values that no vehicle has.
    pub(super) fn believed_vehicle(&self) -> Result<RigidVehicle, SimError> {
        let (given, body) = (&self.believed, &self.body);
        let body = BodySettings {
            inertia_kg_m2: given.inertia_kg_m2.unwrap_or(body.inertia_kg_m2),
            torque_per_thrust_m: given
                .torque_per_thrust_m
                .unwrap_or(body.torque_per_thrust_m),
            ..*body
        };
        RigidVehicle::new(&self.believed_plant(), &body).map_err(of_belief)
    }

    /// The plant that is believed: mass, rotors and motors.
    pub(super) fn believed_plant(&self) -> PlantSettings {
        let (given, plant) = (&self.believed, &self.plant);
        PlantSettings {
            mass_kg: given.mass_kg.unwrap_or(plant.mass_kg),
            rotor_radius_m: given.rotor_radius_m.unwrap_or(plant.rotor_radius_m),
            rotor_spacing_m: given.rotor_spacing_m.unwrap_or(plant.rotor_spacing_m),
            motor: given.motor.unwrap_or(plant.motor),
            ..*plant
        }
    }

    /// The scenario that is flown: its vehicle is the true one, its belief is complete.
    ///
    /// # Errors
    /// Ratios of the true vehicle that are not positive.
    pub(super) fn resolved(&self) -> Result<Self, SimError> {
        let truth = self.truth;
        truth.validate().map_err(|e| e.in_section("truth"))?;
        let mut flown = self.clone();
        flown.believed = self.complete_belief();
        flown.plant = truth.plant(&self.plant);
        flown.body = truth.body(&self.body);
        flown.command_delay_s *= truth.delay;
        flown.sensors.imu.latency_s *= truth.delay;
        flown.truth = TruthSettings::default();
        Ok(flown)
    }
}
