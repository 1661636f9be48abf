//! The landing computer of a scenario.

use touchdown_flight::SettingsError;
use touchdown_lander::computer::Computer;
use touchdown_lander::settings::{LoopTiming, SensorNumbers, VehicleNumbers};

use super::scenario::SpaceScenario;
use crate::body::motor::Motor;
use crate::body::plant::PlantSettings;
use crate::check;
use crate::error::SimError;
use crate::landing::refused_setting;
use crate::sensors::SensorSettings;
use crate::sensors::suite::vector;

/// The landing computer of the scenario's settings, with the believed numbers of its vehicle
/// and the nominal ones of its sensors.
pub(super) fn computer(scenario: &SpaceScenario) -> Result<Computer<f64>, SimError> {
    if let Some((key, found, default)) = scenario.control.without_effect() {
        let key = key_of_scenario(key);
        let by = replaced_by(&key).unwrap_or("sensors");
        let expected = format!("its default, {default}, since `{by}` replaces it");
        return Err(check::fail(&key, &expected, &found));
    }
    let given = &scenario.believed;
    let timing = LoopTiming {
        period_s: scenario.control_period_s,
        command_delay_s: given.command_delay_s.unwrap_or(scenario.command_delay_s),
    };
    let sensors = &scenario.sensors;
    let imu_latency_s = given.imu_latency_s.unwrap_or(sensors.imu.latency_s);
    scenario
        .control
        .computer(
            &scenario.models,
            &vehicle_numbers(&scenario.believed_plant())?,
            &sensor_numbers(sensors, imu_latency_s),
            &timing,
            scenario.start_m[2],
        )
        .map_err(|error| cannot_be_flown(&error))
}

fn vehicle_numbers(plant: &PlantSettings) -> Result<VehicleNumbers<f64>, SimError> {
    let motor = Motor::new(&plant.motor, plant.weight_n())?;
    Ok(VehicleNumbers {
        mass_kg: plant.mass_kg,
        gravity_mps2: plant.gravity_mps2,
        rotor_radius_m: plant.rotor_radius_m,
        greatest_thrust_n: three_digits_down(motor.rest(1.0).powi(2)),
    })
}

/// A number rounded down to three digits. A limit of thrust lies below what full throttle gives, so that a
/// throttle remains for every thrust; the paper's quadrotor has 20.4 N of 20.476 N. Two digits would give away
/// up to a tenth of the thrust, four would leave 0.1 % to the errors of a thrust curve.
fn three_digits_down(value: f64) -> f64 {
    let digits = 2 - value.log10().floor() as i32;
    // By tens, which are exact; their inverses are not.
    let tens = 10_f64.powi(digits.abs());
    if digits >= 0 {
        (value * tens).floor() / tens
    } else {
        (value / tens).floor() * tens
    }
}

fn sensor_numbers(sensors: &SensorSettings, imu_latency_s: f64) -> SensorNumbers<f64> {
    let (range, tag) = (&sensors.range, &sensors.tag);
    SensorNumbers {
        imu_latency_s,
        range_position_m: vector(range.place_m),
        range_quantum_m: range.quantum_m,
        range_limits_m: [range.least_m, range.greatest_m],
        range_jitter_s: range.schedule.jitter_s,
        camera_position_m: vector(tag.camera.place_m),
        camera_turn_rad: tag.camera.turn_rad,
        camera_jitter_s: tag.schedule.jitter_s,
    }
}

/// Settings that the flight side refuses, by the keys of the scenario.
pub(super) fn cannot_be_flown(error: &SettingsError) -> SimError {
    match refused_setting(error, key_of_scenario) {
        Some((key, expected, found)) => check::fail(&key, &expected, &found),
        None => check::fail(
            "control",
            "settings that the landing computer can fly",
            error,
        ),
    }
}

/// Settings of the landing computer itself that `control` has.
const OF_SETTINGS: [&str; 5] = [
    "contact_height_m",
    "deck_known_mps",
    "least_damping_ratio",
    "motor_lag_share",
    "watch_s",
];

/// The key of the scenario that sets a setting of the landing computer. What the scenario sets under another name, or not
/// at all, keeps its own.
fn key_of_scenario(key: &str) -> String {
    let Some((block, rest)) = key.split_once('.') else {
        return key.to_owned();
    };
    match block {
        "reference" => match rest {
            "terminal.duration_s" => "control.terminal_s".to_owned(),
            "terminal.sink_rate_mps" => "control.terminal_sink_mps".to_owned(),
            "exponential.c_per_s" => "control.exponential_per_s".to_owned(),
            _ => key.to_owned(),
        },
        "computer" if OF_SETTINGS.contains(&rest) => format!("control.{rest}"),
        "planner" => format!("control.planning.{rest}"),
        "adaptation" => format!("control.adapting.{rest}"),
        "deck_estimator" => format!("control.deck.{rest}"),
        "course" | "feet" | "gains" | "guidance" | "horizontal" | "lander" | "latency"
        | "observer" | "relative" | "seeking" => format!("control.{key}"),
        _ => key.to_owned(),
    }
}

/// The key of a scenario whose number replaces a setting of `control.relative`; those of the start do so where the vehicle
/// seeks the deck.
#[must_use]
pub fn replaced_by(key: &str) -> Option<&'static str> {
    Some(match key.strip_prefix("control.relative.")? {
        "gravity_mps2" => "plant.gravity_mps2",
        "imu.delay_s" => "sensors.imu.latency_s",
        "range.position_m.x" | "range.position_m.y" | "range.position_m.z" => {
            "sensors.range.place_m"
        }
        "range.quantum_m" => "sensors.range.quantum_m",
        "range.least_m" => "sensors.range.least_m",
        "range.greatest_m" => "sensors.range.greatest_m",
        "range.jitter_s" => "sensors.range.schedule.jitter_s",
        "tag.position_m.x" | "tag.position_m.y" | "tag.position_m.z" => {
            "sensors.tag.camera.place_m"
        }
        "tag.jitter_s" => "sensors.tag.schedule.jitter_s",
        "initial.height_m" => "start_m",
        "initial.height_sd_m" => "control.seeking.start_sd_m",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_refused_setting_is_named_by_the_key_of_the_scenario() {
        let refused = |change: fn(&mut SpaceScenario)| {
            let mut scenario = SpaceScenario::default();
            change(&mut scenario);
            computer(&scenario).unwrap_err().to_string()
        };
        for (change, said) in [
            (
                (|s| s.control.planning.horizon_s = -1.0) as fn(&mut SpaceScenario),
                "setting `control.planning.descent.duration_max_s`: expected less than `control.planning.horizon_s` = -1, found",
            ),
            (
                |s| s.control.state_machine.tag_age_s = 0.0,
                "setting `control.lander.tag_age_s`: expected a finite number greater than 0, found 0",
            ),
            (
                |s| s.control.deck.gate_sd = f64::NAN,
                "setting `control.deck.gate_sd`: expected a finite number",
            ),
            (
                |s| s.control.watch_s = -1.0,
                "setting `control.watch_s`: expected",
            ),
            (
                |s| (s.control.planner, s.control.terminal_s) = (false, -1.0),
                "setting `control.terminal_s`: expected",
            ),
            (
                |s| s.control.motor_lag_share = 0.3,
                "setting `control.motor_lag_share`: expected",
            ),
            (
                |s| s.control.gains.k_p = -4.0,
                "setting `control.gains.k_p`: expected",
            ),
            (
                |s| s.control.state_machine.hold_height_m = 50.0,
                "setting `control.lander.hold_height_m`: expected a height from which a descent ends within `control.planning.horizon_s`",
            ),
            (
                |s| s.control.relative.range.quantum_m = 0.05,
                "setting `control.relative.range.quantum_m`: expected its default, 0.01, since `sensors.range.quantum_m` replaces it, found 0.05",
            ),
            (
                |s| s.control.relative.tag.position_m.z = f64::NAN,
                "setting `control.relative.tag.position_m.z`: expected its default, 0, since `sensors.tag.camera.place_m` replaces it",
            ),
            (
                |s| (s.control.seeks, s.control.relative.initial.height_m) = (true, 7.0),
                "setting `control.relative.initial.height_m`: expected its default, 0, since `start_m` replaces it",
            ),
        ] {
            let error = refused(change);
            assert!(error.starts_with(said), "{error}");
        }
        // Without a search that height counts.
        let mut scenario = SpaceScenario::default();
        scenario.control.relative.initial.height_m = 7.0;
        computer(&scenario).unwrap();
    }

    #[test]
    fn analytic_three_digits() {
        for (value, expected) in [
            (20.4764, 20.4),
            (0.598, 0.598),
            (0.059_87, 0.0598),
            (294.9, 294.0),
            (4_909.0, 4_900.0),
        ] {
            assert_eq!(three_digits_down(value), expected);
        }
    }

    #[test]
    fn prop_the_limit_of_thrust_is_the_believed_vehicles() {
        let standard = SpaceScenario::default();
        let limits = |scenario: &SpaceScenario| computer(scenario).unwrap().controller.limits;
        assert_eq!(limits(&standard).thrust_max_n, 20.4);
        let mut strong = standard.clone();
        strong.plant.motor.linear_loss /= 2.0;
        strong.plant.motor.quadratic_loss /= 4.0;
        // Losses of a half and a quarter are four times the thrust: 81.9 N.
        assert_eq!(limits(&strong).thrust_max_n, 81.9);
        strong.believed.motor = Some(standard.plant.motor);
        assert_eq!(limits(&strong).thrust_max_n, 20.4);
    }
}
