//! Number and arrangement of rotors, and the four rotors that replace them in the simulation.

use std::f64::consts::{PI, TAU};

/// Thrust of a coaxial pair over that of two rotors apart, at the same power. The lower rotor works in the wake of the
/// upper one, which raises the induced power by 1.28 (Leishman, Principles of Helicopter Aerodynamics, 2.15):
/// 1.28^(-2/3).
pub(super) const COAXIAL_SHARE: f64 = 0.85;

/// Rotors on equal arms, alone or in coaxial pairs. The forward direction lies between two arms.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct RotorLayout {
    /// Number of rotors.
    pub rotors: u32,
    /// Whether each arm carries two, one above the other.
    pub coaxial: bool,
}

impl RotorLayout {
    /// One rotor on each arm.
    #[must_use]
    pub const fn flat(rotors: u32) -> Self {
        Self {
            rotors,
            coaxial: false,
        }
    }

    /// Two rotors on each arm.
    #[must_use]
    pub const fn coaxial(rotors: u32) -> Self {
        Self {
            rotors,
            coaxial: true,
        }
    }

    /// Arms.
    #[must_use]
    pub fn arms(self) -> u32 {
        if self.coaxial {
            self.rotors.div_ceil(2)
        } else {
            self.rotors
        }
    }

    /// Distance of neighbouring rotors' axes over the arm: 2 sin(π/n) of n arms, where there are at least three.
    #[must_use]
    pub fn spacing_of_arm(self) -> f64 {
        2.0 * (PI / f64::from(self.arms().max(3))).sin()
    }

    /// Arm of the four rotors that roll and pitch as well with the same thrust in all, over the arm of these:
    /// the mean of |sin θ| over the arms' angles θ, over that of four, sin 45°.
    #[must_use]
    pub fn lever_of_four(self) -> f64 {
        let lever = |arms: u32| {
            let angle = |i: u32| TAU * (f64::from(i) + 0.5) / f64::from(arms);
            (0..arms).map(|i| angle(i).sin().abs()).sum::<f64>() / f64::from(arms)
        };
        match self.arms() {
            0..=4 => 1.0,
            arms => lever(arms) / lever(4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_levers_of_six_and_eight_arms() {
        // |sin| of 30°, 90°, 150°, …: 1/2, 1, 1/2; of 22.5° and 67.5°: 0.3827, 0.9239; of four: 1/√2. Rounding only.
        let root = 0.5_f64.sqrt();
        for (layout, expected) in [
            (RotorLayout::flat(4), 1.0),
            (RotorLayout::flat(6), 2.0 / 3.0 / root),
            (
                RotorLayout::flat(8),
                0.5 * (0.382_683_432_365 + 0.923_879_532_511) / root,
            ),
            (RotorLayout::coaxial(8), 1.0),
        ] {
            assert!(
                (layout.lever_of_four() - expected).abs() < 1e-11,
                "{layout:?}"
            );
        }
    }
}
