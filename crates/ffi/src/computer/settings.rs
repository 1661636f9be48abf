//! Settings of the landing computer.

use touchdown_flight::Vector;
use touchdown_flight::error::{finite, positive};
use touchdown_lander::computer::Computer;
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{ControlSettings, LoopTiming, SensorNumbers};

use crate::error::td_error;
use crate::memory::write;
use crate::models::td_models;
use crate::refusal::Refusal;
use crate::vehicle::{method, td_method, td_vehicle};

/// What the estimators know of the sensors. Body axes: x forward, y left, z up.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_sensors {
    /// Latency of specific force and attitude, s.
    pub imu_latency_s: f32,
    /// Position of the range finder, m.
    pub range_position_m: [f32; 3],
    /// Resolution of the range finder, m; 0 for none.
    pub range_quantum_m: f32,
    /// Smallest distance of the range finder, m.
    pub range_min_m: f32,
    /// Greatest distance of the range finder, m.
    pub range_max_m: f32,
    /// Scale of the range finder's half-normal jitter, s.
    pub range_jitter_s: f32,
    /// Position of the camera, m.
    pub camera_position_m: [f32; 3],
    /// Rotation of the camera about the body's z axis, rad.
    pub camera_turn_rad: f32,
    /// Scale of the camera's half-normal jitter, s.
    pub camera_jitter_s: f32,
}

/// Settings of the landing computer. All others have the defaults that campaigns fly, which are
/// tuned for the paper's quadrotor.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct td_computer_settings {
    /// The vehicle.
    pub vehicle: td_vehicle,
    /// Its models.
    pub models: td_models,
    /// Its sensors.
    pub sensors: td_sensors,
    /// A `td_method`.
    pub method: u32,
    /// Time between two steps, s.
    pub period_s: f32,
    /// Delay of a command to the attitude control, s.
    pub command_delay_s: f32,
    /// Height above the deck at which the landing begins, m.
    pub start_height_m: f32,
    /// 1 if the deck may be under way, 0 if not.
    pub deck_under_way: u32,
    /// 1 if the vehicle seeks a deck that is not below, 0 if it hovers then.
    pub seeks_deck: u32,
}

fn flag(field: &'static str, number: u32) -> Result<bool, Refusal> {
    match number {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Refusal::unknown(field, "0 or 1", number)),
    }
}

impl td_computer_settings {
    fn standard() -> Self {
        let sensors = SensorNumbers::<f32>::default();
        let timing = LoopTiming::<f32>::default();
        let [range_min_m, range_max_m] = sensors.range_limits_m;
        Self {
            vehicle: td_vehicle::standard(),
            models: td_models::new(&FlightModels::default()),
            sensors: td_sensors {
                imu_latency_s: sensors.imu_latency_s,
                range_position_m: sensors.range_position_m.to_array(),
                range_quantum_m: sensors.range_quantum_m,
                range_min_m,
                range_max_m,
                range_jitter_s: sensors.range_jitter_s,
                camera_position_m: sensors.camera_position_m.to_array(),
                camera_turn_rad: sensors.camera_turn_rad,
                camera_jitter_s: sensors.camera_jitter_s,
            },
            method: td_method::DynamicObserver as u32,
            period_s: timing.period_s,
            command_delay_s: timing.command_delay_s,
            // Where the hover is from which the paper's landings begin.
            start_height_m: 0.8,
            deck_under_way: 0,
            seeks_deck: 0,
        }
    }

    pub(super) fn computer(&self) -> Result<Computer<f32>, Refusal> {
        let method = method(self.method)?;
        let control = ControlSettings {
            method,
            under_way: flag("deck_under_way", self.deck_under_way)?,
            seeks: flag("seeks_deck", self.seeks_deck)?,
            ..ControlSettings::default()
        };
        // The landing computer has no check of its own for them.
        positive("period_s", self.period_s)?;
        finite("sensors.camera_turn_rad", self.sensors.camera_turn_rad)?;
        positive("start_height_m", self.start_height_m)?;
        let of = &self.sensors;
        let sensors = SensorNumbers {
            imu_latency_s: of.imu_latency_s,
            range_position_m: vector(of.range_position_m),
            range_quantum_m: of.range_quantum_m,
            range_limits_m: [of.range_min_m, of.range_max_m],
            range_jitter_s: of.range_jitter_s,
            camera_position_m: vector(of.camera_position_m),
            camera_turn_rad: of.camera_turn_rad,
            camera_jitter_s: of.camera_jitter_s,
        };
        let timing = LoopTiming {
            period_s: self.period_s,
            command_delay_s: self.command_delay_s,
        };
        let models = self.models.models(method, &self.vehicle)?;
        let vehicle = self.vehicle.numbers();
        Ok(control.computer(&models, &vehicle, &sensors, &timing, self.start_height_m)?)
    }
}

pub(super) fn vector([x, y, z]: [f32; 3]) -> Vector<f32> {
    Vector::new(x, y, z)
}

/// Settings of the paper's quadrotor with the simulator's sensors, at 100 Hz.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn td_computer_settings_default(
    settings: *mut td_computer_settings,
) -> td_error {
    // SAFETY: as the crate's documentation requires of every pointer.
    unsafe { write(settings, td_computer_settings::standard()) }.into()
}
