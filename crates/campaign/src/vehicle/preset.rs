//! Vehicles by name.

use serde::{Deserialize, Serialize};

use super::layout::RotorLayout;

/// A vehicle of a size that is built, by a few numbers; all else follows by the scaling laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Its name in settings.
    pub name: &'static str,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Radius of a rotor, m.
    pub rotor_radius_m: f64,
    /// Distance of the rotors' axes from the centre, m.
    pub arm_m: f64,
    /// Greatest thrust of all rotors, N.
    pub greatest_thrust_n: f64,
    /// Number and arrangement of the rotors.
    pub layout: RotorLayout,
}

const fn preset(
    name: &'static str,
    [mass_kg, rotor_radius_m, arm_m, greatest_thrust_n]: [f64; 4],
    layout: RotorLayout,
) -> Preset {
    Preset {
        name,
        mass_kg,
        rotor_radius_m,
        arm_m,
        greatest_thrust_n,
        layout,
    }
}

/// All presets: mass, rotor radius, arm, greatest thrust. Radii are those of propellers that are sold (3, 13, 15, 18, 21,
/// 24, 28 and 32 inches), arms keep the discs apart, and the greatest thrust is twice the weight but for the standard
/// vehicle (1.52) and the one of 0.25 kg (2.5).
pub const PRESETS: [Preset; 12] = [
    preset(
        "quadrotor_0.03kg",
        [0.03, 0.0231, 0.046, 0.59],
        RotorLayout::flat(4),
    ),
    preset(
        "quadrotor_0.25kg",
        [0.25, 0.0381, 0.075, 6.1],
        RotorLayout::flat(4),
    ),
    preset("quadrotor_1.37kg", STANDARD, RotorLayout::flat(4)),
    preset(
        "quadrotor_4kg",
        [4.0, 0.19, 0.33, 78.5],
        RotorLayout::flat(4),
    ),
    preset(
        "quadrotor_15kg",
        [15.0, 0.356, 0.6, 294.0],
        RotorLayout::flat(4),
    ),
    preset(
        "quadrotor_25kg",
        [25.0, 0.406, 0.7, 490.0],
        RotorLayout::flat(4),
    ),
    preset(
        "hexarotor_4kg",
        [4.0, 0.165, 0.35, 78.5],
        RotorLayout::flat(6),
    ),
    preset(
        "hexarotor_15kg",
        [15.0, 0.267, 0.567, 294.0],
        RotorLayout::flat(6),
    ),
    preset(
        "octorotor_15kg",
        [15.0, 0.229, 0.62, 294.0],
        RotorLayout::flat(8),
    ),
    preset(
        "octorotor_25kg",
        [25.0, 0.305, 0.82, 490.0],
        RotorLayout::flat(8),
    ),
    preset("x8_4kg", [4.0, 0.152, 0.28, 78.5], RotorLayout::coaxial(8)),
    preset(
        "x8_25kg",
        [25.0, 0.356, 0.62, 490.0],
        RotorLayout::coaxial(8),
    ),
];

/// The default vehicle of the simulation: mass, rotor radius, arm (0.32 m/√2), thrust at full throttle.
pub(super) const STANDARD: [f64; 4] = [1.37, 0.12, 0.226_274_169_979_695_2, 20.476_4];

/// The name of a preset.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(try_from = "String", into = "String")]
pub struct PresetName(&'static Preset);

impl PresetName {
    /// The vehicle of this name.
    #[must_use]
    pub fn preset(self) -> &'static Preset {
        self.0
    }
}

impl TryFrom<String> for PresetName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        static ALL: [Preset; 12] = PRESETS;
        ALL.iter()
            .find(|p| p.name == name)
            .map(Self)
            .ok_or_else(|| {
                let names: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
                format!("expected one of {}, found {name}", names.join(", "))
            })
    }
}

impl From<PresetName> for String {
    fn from(name: PresetName) -> Self {
        name.0.name.to_string()
    }
}
