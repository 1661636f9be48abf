//! The fields of the settings in C, by the keys of errors in Rust.

/// The field that a key is computed from. Keys of the interface itself are fields already.
pub(crate) fn field(key: &'static str) -> &'static str {
    match key {
        "mass_kg" => "vehicle.mass_kg",
        "gravity_mps2" | "relative.gravity_mps2" => "vehicle.gravity_mps2",
        // What counts as known grows with the vehicle.
        "ground_effect.empirical.rotor_radius_m"
        | "computer.known_sd_m"
        | "computer.known_sd_mps" => "vehicle.rotor_radius_m",
        // The least thrust is a share of the weight, and this is above it.
        "limits.thrust_min_n" | "limits.thrust_max_n" => "vehicle.greatest_thrust_n",
        "ground_effect.empirical.mu" => "models.empirical_mu",
        "thrust.greatest_n" | "thrust.hover_n" => "models.thrust.coefficients",
        "validity.height_min_m" => "models.ground_effect.height_min_m",
        "validity.height_max_m" => "models.ground_effect.height_max_m",
        "validity.ratio_min" => "models.ground_effect.ratio_min",
        "validity.ratio_max" => "models.ground_effect.ratio_max",
        "reference.exponential.c_per_s" => "descent_rate_per_s",
        "reference.exponential.start_height_m" | "relative.initial.height_m" => "start_height_m",
        "reference.exponential.end_height_m" => "end_height_m",
        "relative.imu.delay_s" | "computer.lead_s" | "delays.sensing_s" | "delays.attitude_s" => {
            "sensors.imu_latency_s"
        }
        "delays.command_s" => "command_delay_s",
        "relative.range.position_m" => "sensors.range_position_m",
        "relative.tag.position_m" => "sensors.camera_position_m",
        "relative.range.quantum_m" => "sensors.range_quantum_m",
        "relative.range.least_m" => "sensors.range_min_m",
        "relative.range.greatest_m" => "sensors.range_max_m",
        "relative.range.jitter_s" => "sensors.range_jitter_s",
        "relative.tag.jitter_s" => "sensors.camera_jitter_s",
        other => other,
    }
}

/// The index, as in C, of the coefficient of a model that an error is about: the first that is as
/// found, from the first of the key on.
pub(crate) fn coefficient(key: &str, found: f64, coefficients: &[f32]) -> Option<&'static str> {
    const INDICES: [&str; 12] = [
        "[0]", "[1]", "[2]", "[3]", "[4]", "[5]", "[6]", "[7]", "[8]", "[9]", "[10]", "[11]",
    ];
    let first = first_coefficient(key)?;
    let same = |c: f32| f64::from(c) == found || (c.is_nan() && found.is_nan());
    let numbered = coefficients.iter().zip(INDICES).skip(first);
    numbered
        .filter(|&(&c, _)| same(c))
        .map(|(_, index)| index)
        .next()
}

/// The index of the first coefficient of a key, in the order of `td_thrust_model` and
/// `td_ground_effect`.
fn first_coefficient(key: &str) -> Option<usize> {
    Some(match key {
        "thrust.first_order.c0"
        | "thrust.library.one"
        | "thrust.static.coefficients"
        | "thrust.lagged_throttle.coefficients"
        | "ground_effect.empirical.mu"
        | "ground_effect.static.h"
        | "ground_effect.polynomial.theta"
        | "ground_effect.ratio.xi"
        | "ground_effect.lag.map.h" => 0,
        "thrust.first_order.c1" | "thrust.library.x" | "ground_effect.empirical.rotor_radius_m" => {
            1
        }
        "thrust.first_order.t_m_s"
        | "thrust.library.s"
        | "ground_effect.empirical.rotor_offset_m" => 2,
        "thrust.library.s2" => 3,
        "thrust.static.t_m_s"
        | "thrust.lagged_throttle.t_m_s"
        | "thrust.library.x3"
        | "ground_effect.static.length_m"
        | "ground_effect.lag.map.length_m" => 4,
        "thrust.library.s3" => 5,
        "thrust.library.exp_neg_x_s" => 6,
        "thrust.library.sin_x_s" | "ground_effect.lag.k" => 7,
        "thrust.library_of_rotors.root_factor" => 8,
        "ground_effect.ratio.length_m" | "ground_effect.lag.tau_s" => 9,
        _ => return None,
    })
}
