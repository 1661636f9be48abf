//! Names of channels that stages of Touchdown read, and slips in them.

use super::Map;
use crate::LogError;
use sindy_expr::nearest;
use touchdown_trial::{TIME_CHANNEL, Unit, unit_of};

/// Channels that a stage reads or a page shows, without the number of a motor.
const CHANNELS: [&str; 34] = [
    TIME_CHANNEL,
    "throttle",
    "throttle_command",
    "throttle_compensated",
    "thrust_n",
    "rotor_rpm",
    "battery_v",
    "current_a",
    "power_w",
    "motor_v",
    "supply_v",
    "torque_n_m",
    "specific_force_mps2",
    "acceleration_mps2",
    "tilt_rad",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
    "height_m",
    "vehicle_velocity_mps",
    "x_m",
    "y_m",
    "z_m",
    "deck_height_m",
    "deck_velocity_mps",
    "deck_acceleration_mps2",
    "deck_x_m",
    "deck_y_m",
    "deck_z_m",
    "deck_roll_rad",
    "deck_pitch_rad",
    "deck_yaw_rad",
    "truth_thrust_n",
    "truth_free_air_n",
];

impl Map {
    /// Checks the names of the map's channels. A name is one that Touchdown knows, such as `thrust_n`, with or
    /// without the number of a motor, or one of the user's own that ends in its unit and is no slip of a known one.
    ///
    /// # Errors
    /// [`LogError::MapValue`] with the nearest known name.
    pub fn check_names(&self) -> Result<(), LogError> {
        let is_wrong = |channel: &str| {
            let bare = without_numbers(channel);
            let near = nearest(&bare, CHANNELS);
            let is_slip = near.is_some_and(|near| unit_of(near) == unit_of(&bare));
            !is_channel(channel) && (is_slip || unit_of(&bare) == Unit::Dimensionless)
        };
        let Some(rule) = self.channels.iter().find(|rule| is_wrong(&rule.channel)) else {
            return Ok(());
        };
        let near = nearest(&without_numbers(&rule.channel), CHANNELS);
        let near = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
        Err(LogError::MapValue {
            at: Box::new(rule.place.clone()),
            expected: format!(
                "a channel such as thrust_n, throttle or height_m, or a name of your own that ends in its unit, such as oil_v{near}"
            ),
            found: format!("{:?}", rule.channel),
        })
    }
}

/// Whether a name is that of a channel that Touchdown knows, with or without the number of a motor.
pub(super) fn is_channel(channel: &str) -> bool {
    CHANNELS.contains(&&*without_numbers(channel))
}

/// A name without the numbers of motors: `rotor_rpm` for `rotor_rpm_3`, `height_m` for `height_2_m`.
fn without_numbers(name: &str) -> String {
    let parts = name.split('_');
    let words: Vec<&str> = parts
        .filter(|part| part.is_empty() || !part.bytes().all(|b| b.is_ascii_digit()))
        .collect();
    words.join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_slips_of_known_names_are_told_and_own_names_pass() {
        let check = |channel: &str| {
            let text = format!("schema = 1\n[channels]\ntime_s = 't'\n{channel} = 'x'\n");
            Map::parse("m.toml", &text).unwrap().check_names()
        };
        for good in [
            "thrust_n",
            "rotor_rpm_4",
            "throttle_2",
            "gust_mps",
            "height_2_m",
            "battery_a",
        ] {
            assert!(check(good).is_ok(), "{good}");
        }
        for (slip, near) in [
            ("thrust_N", "thrust_n"),
            ("trhust_n", "thrust_n"),
            ("thrust", "thrust_n"),
            ("throtle", "throttle"),
            ("heigth_m", "height_m"),
            ("rotor_rmp_2", "rotor_rpm"),
        ] {
            let text = check(slip).unwrap_err().to_string();
            assert!(text.contains(&format!("did you mean {near:?}?")), "{text}");
            assert!(text.starts_with("m.toml, line 4"), "{text}");
        }
        assert!(check("load").is_err());
    }

    #[test]
    fn prop_built_in_maps_have_known_names() {
        for name in ["px4", "ardupilot", "ros"] {
            Map::built_in_named(name).unwrap().check_names().unwrap();
        }
    }
}
