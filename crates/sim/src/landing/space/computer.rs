//! The landing computer of a scenario.

use touchdown_flight::SettingsError;
use touchdown_lander::computer::Computer;
use touchdown_lander::settings::{LoopTiming, SensorNumbers, VehicleNumbers};

use super::scenario::SpaceScenario;
use crate::body::plant::PlantSettings;
use crate::error::SimError;
use crate::sensors::SensorSettings;
use crate::sensors::suite::vector;

/// The landing computer of the scenario's settings, with the nominal numbers of its vehicle
/// and sensors.
pub(super) fn computer(scenario: &SpaceScenario) -> Result<Computer<f64>, SimError> {
    let timing = LoopTiming {
        period_s: scenario.control_period_s,
        command_delay_s: scenario.command_delay_s,
    };
    scenario
        .control
        .computer(
            &scenario.models,
            &vehicle_numbers(&scenario.plant),
            &sensor_numbers(&scenario.sensors),
            &timing,
            scenario.start_m[2],
        )
        .map_err(|error| cannot_be_flown(&error))
}

fn vehicle_numbers(plant: &PlantSettings) -> VehicleNumbers<f64> {
    VehicleNumbers {
        mass_kg: plant.mass_kg,
        gravity_mps2: plant.gravity_mps2,
        rotor_radius_m: plant.rotor_radius_m,
    }
}

fn sensor_numbers(sensors: &SensorSettings) -> SensorNumbers<f64> {
    let (range, tag) = (&sensors.range, &sensors.tag);
    SensorNumbers {
        imu_latency_s: sensors.imu.latency_s,
        range_position_m: vector(range.place_m),
        range_quantum_m: range.quantum_m,
        range_limits_m: [range.least_m, range.greatest_m],
        range_jitter_s: range.schedule.jitter_s,
        camera_position_m: vector(tag.camera.place_m),
        camera_turn_rad: tag.camera.turn_rad,
        camera_jitter_s: tag.schedule.jitter_s,
    }
}

/// Settings that the flight side refuses.
pub(super) fn cannot_be_flown(error: &SettingsError) -> SimError {
    let expected = "settings that the landing computer can fly";
    crate::check::fail("control", expected, error)
}
