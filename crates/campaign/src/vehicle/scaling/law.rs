//! Scaling laws as products of powers of the vehicle's ratios.

/// Ratios of a vehicle to the standard one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratios {
    /// λ: ratio of the rotor radius.
    pub radius: f64,
    /// Ratio of the mass.
    pub mass: f64,
    /// Ratio of the rotors' distance from the centre.
    pub arm: f64,
    /// Ratio of the greatest thrust.
    pub thrust: f64,
}

impl Ratios {
    /// The standard vehicle.
    pub const STANDARD: Self = Self {
        radius: 1.0,
        mass: 1.0,
        arm: 1.0,
        thrust: 1.0,
    };

    /// A vehicle of the same density and shape: mass and thrust with λ³.
    #[must_use]
    pub fn similar(radius: f64) -> Self {
        let cube = radius.powi(3);
        Self {
            radius,
            mass: cube,
            arm: radius,
            thrust: cube,
        }
    }
}

/// A product of powers of the ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Law {
    radius: f64,
    mass: f64,
    arm: f64,
    thrust: f64,
}

/// What limits a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scale {
    /// Follows the vehicle.
    Vehicle,
    /// Follows smaller values only: errors of sensors, limits of what a body withstands.
    AtMost,
    /// Follows the lesser of the law and this one, but no less than this share of the law.
    AtMostAs(Law, f64),
    /// Follows larger values only: times and speeds that the deck sets, which is not smaller for a small vehicle.
    AtLeast,
    /// Follows a smaller vehicle by half of the law's power of λ: gains of the vertical loop, in which the delays of the
    /// electronics do not shrink. By the full power, the vehicle of 30 g does not settle in 12 of 12 landings with 1.5 times the
    /// thrust per mass that it believes.
    Delayed,
    /// Rates, delays and noise of electronics, which do not follow the vehicle. Similar landings need them scaled.
    Electronics,
}

/// A key of the scenario with its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) key: &'static str,
    law: Law,
    scale: Scale,
}

pub(super) const fn entry(key: &'static str, law: Law, scale: Scale) -> Entry {
    Entry { key, law, scale }
}

/// A law of radius and mass.
const fn of(radius: f64, mass: f64) -> Law {
    Law {
        radius,
        mass,
        arm: 0.0,
        thrust: 0.0,
    }
}

/// λ.
pub(super) const LENGTH: Law = of(1.0, 0.0);
/// √λ.
pub(super) const TIME: Law = of(0.5, 0.0);
/// √λ, as lengths over times.
pub(super) const SPEED: Law = of(0.5, 0.0);
/// 1/√λ.
pub(super) const RATE: Law = of(-0.5, 0.0);
/// 1/λ, as rates squared.
pub(super) const RATE_SQUARED: Law = of(-1.0, 0.0);
/// 1/λ, as rates squared.
pub(super) const ANGULAR_ACCELERATION: Law = RATE_SQUARED;
/// 1/λ.
pub(super) const PER_LENGTH: Law = of(-1.0, 0.0);
/// Metres per root of a second: λ over the fourth root of λ.
pub(super) const POSITION_WALK: Law = of(0.75, 0.0);
/// Metres per second per root of a second.
pub(super) const SPEED_WALK: Law = of(0.25, 0.0);
/// Metres per second squared per root of a second.
pub(super) const ACCELERATION_WALK: Law = of(-0.25, 0.0);
/// m.
pub(super) const MASS: Law = of(0.0, 1.0);
/// m, as weights.
pub(super) const FORCE: Law = of(0.0, 1.0);
/// m².
pub(super) const FORCE_SQUARED: Law = of(0.0, 2.0);
/// m/λ.
pub(super) const FORCE_PER_LENGTH: Law = of(-1.0, 1.0);
/// m/√λ.
pub(super) const FORCE_PER_SPEED: Law = of(-0.5, 1.0);
/// m/√λ.
pub(super) const FORCE_PER_TIME: Law = of(-0.5, 1.0);
/// m/a²: how fast the thrust may decrease on one foot, so that the others come down at a speed that does not grow with the vehicle,
/// as what legs withstand does not. A deficit of force that grows by `ṡ` per mass moves them by `h = ṡ t³/6`, so they come down
/// at `v = ṡ t²/2 = (9/2 ṡ h²)^(1/3)`, and h is as the arm. By similarity alone, 67 of 200 landings of the 15 kg vehicle crash in
/// a wind of 10 m/s, with this law 2.
pub(super) const FORCE_PER_TIME_ON_ONE_FOOT: Law = Law {
    arm: -2.0,
    ..of(0.0, 1.0)
};
/// Least share of the similar decrease of the thrust. Arms that are long for the rotors would keep the thrust for seconds, and a wind
/// moves the vehicle meanwhile: of 200 landings of 4 kg with arms of 0.8 m and rotors of 0.12 m in a wind of 7 m/s 114 crash without
/// it, 48 with it. No preset is below it. With a sixth, 66 in place of 41 of 120 landings of the octorotor of 25 kg are hard.
pub(super) const LEAST_OF_SIMILAR: f64 = 0.12;
/// m^1.5: rotors of the vehicle's density, m λ², at the speed of the hover, √m/λ².
pub(super) const MOMENTUM: Law = of(0.0, 1.5);
/// Weight over the induced velocity √(m)/λ: damping of a climb, flapping and induced drag.
pub(super) const LINEAR_DRAG: Law = of(1.0, 0.5);
/// Damping of a climb over the weight.
pub(super) const PER_SPEED: Law = of(1.0, -0.5);
/// a.
pub(super) const ARM: Law = Law {
    arm: 1.0,
    ..of(0.0, 0.0)
};
/// m a².
pub(super) const INERTIA: Law = Law {
    arm: 2.0,
    ..of(0.0, 1.0)
};
/// a², as the area of the frame.
pub(super) const QUADRATIC_DRAG: Law = Law {
    arm: 2.0,
    ..of(0.0, 0.0)
};
/// 1/√T of the greatest thrust T.
pub(super) const LINEAR_LOSS: Law = Law {
    thrust: -0.5,
    ..of(0.0, 0.0)
};
/// 1/T.
pub(super) const QUADRATIC_LOSS: Law = Law {
    thrust: -1.0,
    ..of(0.0, 0.0)
};

impl Law {
    pub(super) fn factor(&self, of: &Ratios) -> f64 {
        of.radius.powf(self.radius)
            * of.mass.powf(self.mass)
            * of.arm.powf(self.arm)
            * of.thrust.powf(self.thrust)
    }

    /// The law in words of λ (rotor radius), m (mass), a (arm) and T (greatest thrust).
    pub(super) fn text(&self) -> String {
        let powers = [
            ("λ", self.radius),
            ("m", self.mass),
            ("a", self.arm),
            ("T", self.thrust),
        ];
        let parts: Vec<String> = powers
            .iter()
            .filter(|(_, power)| *power != 0.0)
            .map(|(name, power)| match power {
                1.0 => (*name).to_string(),
                power => format!("{name}^{power}"),
            })
            .collect();
        parts.join(" ")
    }
}

impl Entry {
    /// The factor of the setting for a vehicle with the standard electronics.
    pub(super) fn factor(&self, of: &Ratios) -> f64 {
        let factor = self.law.factor(of);
        match self.scale {
            Scale::Vehicle => factor,
            Scale::AtMost => factor.min(1.0),
            Scale::AtMostAs(law, least) => factor.min(law.factor(of)).max(least * factor),
            Scale::AtLeast => factor.max(1.0),
            Scale::Delayed if of.radius < 1.0 => factor * of.radius.powf(-0.5 * self.law.radius),
            Scale::Delayed => factor,
            Scale::Electronics => 1.0,
        }
    }

    /// The factor of the setting where electronics and deck are similar as well.
    pub(super) fn similar(&self, of: &Ratios) -> f64 {
        self.law.factor(of)
    }

    /// The law with its limit, as text.
    pub(super) fn text(&self) -> String {
        let law = self.law.text();
        match self.scale {
            Scale::Vehicle => law,
            Scale::AtMost => format!("{law}, at most 1"),
            Scale::AtMostAs(other, least) => {
                format!("{law}, at most {}, at least {least} {law}", other.text())
            }
            Scale::AtLeast => format!("{law}, at least 1"),
            Scale::Delayed => format!("{law}, with half the power of λ below 1"),
            Scale::Electronics => format!("1 (electronics; {law} where they are similar)"),
        }
    }
}
