//! The default vehicle with another mass and size.

use std::f64::consts::SQRT_2;

use touchdown_sim::body::plant::PlantSettings;

/// The default vehicle in proportion, by Froude's law: lengths with R/R₀, times with √(R/R₀), forces with m/m₀. Its motors
/// stay the default ones.
#[must_use]
pub fn in_proportion(mass_kg: f64, rotor_radius_m: f64, arm_m: Option<f64>) -> PlantSettings {
    let standard = PlantSettings::default();
    let (weight, size) = (
        mass_kg / standard.mass_kg,
        rotor_radius_m / standard.rotor_radius_m,
    );
    // Induced velocity, which a climb is damped in proportion to: √(T/A).
    let induced = weight.sqrt() / size;
    let pace = size.sqrt();
    PlantSettings {
        mass_kg,
        rotor_radius_m,
        // Opposite axes are √2 d apart.
        rotor_spacing_m: arm_m.map_or(standard.rotor_spacing_m * size, |arm| arm * SQRT_2),
        rotor_height_m: standard.rotor_height_m * size,
        plate_side_m: standard.plate_side_m * size,
        climb_damping_ns_per_m: standard.climb_damping_ns_per_m * weight / induced,
        rotor_lag_s: standard.rotor_lag_s * pace,
        fountain_lag_s: standard.fountain_lag_s * pace,
        turbulence_correlation_s: standard.turbulence_correlation_s * pace,
        ..standard
    }
}
