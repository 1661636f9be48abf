//! Settings of the landing computer that other settings of a flight replace.

/// Key, what is expected of its value, and the key that replaces it. Those of the start are replaced where the vehicle seeks the deck.
const REPLACED: [(&str, &str, Option<&str>); 15] = [
    (
        "control.relative.gravity_mps2",
        "its default, since `vehicle.gravity_mps2` replaces it",
        Some("vehicle.gravity_mps2"),
    ),
    (
        "control.relative.imu.delay_s",
        "its default, since `sensors.imu_latency_s` replaces it",
        Some("sensors.imu_latency_s"),
    ),
    (
        "control.relative.range.position_m.x",
        "its default, since `sensors.range_position_m` replaces it",
        Some("sensors.range_position_m"),
    ),
    (
        "control.relative.range.position_m.y",
        "its default, since `sensors.range_position_m` replaces it",
        Some("sensors.range_position_m"),
    ),
    (
        "control.relative.range.position_m.z",
        "its default, since `sensors.range_position_m` replaces it",
        Some("sensors.range_position_m"),
    ),
    (
        "control.relative.range.quantum_m",
        "its default, since `sensors.range_quantum_m` replaces it",
        Some("sensors.range_quantum_m"),
    ),
    (
        "control.relative.range.least_m",
        "its default, since `sensors.range_limits_m` replaces it",
        Some("sensors.range_limits_m"),
    ),
    (
        "control.relative.range.greatest_m",
        "its default, since `sensors.range_limits_m` replaces it",
        Some("sensors.range_limits_m"),
    ),
    (
        "control.relative.range.jitter_s",
        "its default, since a flight does not set it",
        None,
    ),
    (
        "control.relative.tag.position_m.x",
        "its default, since `camera.position_m` replaces it",
        Some("camera.position_m"),
    ),
    (
        "control.relative.tag.position_m.y",
        "its default, since `camera.position_m` replaces it",
        Some("camera.position_m"),
    ),
    (
        "control.relative.tag.position_m.z",
        "its default, since `camera.position_m` replaces it",
        Some("camera.position_m"),
    ),
    (
        "control.relative.tag.jitter_s",
        "its default, since a flight does not set it",
        None,
    ),
    (
        "control.relative.initial.height_m",
        "its default, since `control.lander.hold_height_m` replaces it",
        Some("control.lander.hold_height_m"),
    ),
    (
        "control.relative.initial.height_sd_m",
        "its default, since `control.seeking.start_sd_m` replaces it",
        Some("control.seeking.start_sd_m"),
    ),
];

/// Key of a flight and expected value, by the key of the landing computer.
pub(super) fn expected(key: &str) -> (&'static str, &'static str) {
    let of_key = |row: &&(&'static str, _, _)| row.0.strip_prefix("control.") == Some(key);
    let row = REPLACED.iter().find(of_key);
    row.map_or(("control.relative", "its default"), |row| (row.0, row.1))
}

/// The key of a flight whose number replaces a setting of `control.relative`; none where nothing does.
#[must_use]
pub fn replaced_by(key: &str) -> Option<&'static str> {
    REPLACED.iter().find(|row| row.0 == key)?.2
}

#[cfg(test)]
mod tests {
    use crate::settings::FlightSettings;

    #[test]
    fn prop_settings_that_others_replace_are_refused_by_the_key_that_sets_them() {
        let mut settings = FlightSettings::default();
        settings.control.relative.range.greatest_m = 30.0;
        let said = settings.computer().unwrap_err().to_string();
        assert_eq!(
            said,
            "control.relative.range.greatest_m: expected its default, since `sensors.range_limits_m` replaces it, found 30"
        );
    }
}
