//! What enters and leaves a controller: measurement, command, limits.

use crate::error::{SettingsError, not_negative, ordered, within};
use crate::real::{Real, r};

/// One set of vertical measurements, as sensed: older than now by the latency of the sensors.
///
/// z is up. Height is that of the vehicle's reference point above the deck,
/// `z = z_q - z_p`, and `v = dz/dt = v_q - v_p`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Measurement<R> {
    /// Height above the deck z, m.
    pub height_m: R,
    /// Velocity relative to the deck v, m/s.
    pub relative_velocity_mps: R,
    /// Velocity of the vehicle v_q, m/s.
    pub vehicle_velocity_mps: R,
    /// Acceleration of the vehicle dv_q/dt (gravity removed), m/s².
    pub acceleration_mps2: R,
}

impl<R: Real> Measurement<R> {
    /// Velocity of the deck, `v_p = v_q - v`, m/s.
    #[must_use]
    pub fn deck_velocity_mps(&self) -> R {
        self.vehicle_velocity_mps - self.relative_velocity_mps
    }

    /// Every value is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.height_m.is_finite()
            && self.relative_velocity_mps.is_finite()
            && self.vehicle_velocity_mps.is_finite()
            && self.acceleration_mps2.is_finite()
    }

    /// `self` with every value that is not finite taken from `previous`.
    #[must_use]
    pub fn or_previous(&self, previous: &Self) -> Self {
        Self {
            height_m: self.height_m.finite_or(previous.height_m),
            relative_velocity_mps: self
                .relative_velocity_mps
                .finite_or(previous.relative_velocity_mps),
            vehicle_velocity_mps: self
                .vehicle_velocity_mps
                .finite_or(previous.vehicle_velocity_mps),
            acceleration_mps2: self.acceleration_mps2.finite_or(previous.acceleration_mps2),
        }
    }
}

/// What a controller asks of the rotors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Command<R> {
    /// Free-air thrust of the throttle at rest, within the limits, N.
    pub thrust_n: R,
    /// Throttle σ to send, in [0, 1].
    pub throttle: R,
    /// The ground-effect force now, as estimated and used by the law, N (0 for a
    /// law that uses none).
    pub ground_effect_n: R,
}

/// Limits of the actuators.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Limits<R> {
    /// Least thrust, N.
    pub thrust_min_n: R,
    /// Greatest thrust, N.
    pub thrust_max_n: R,
    /// Least throttle.
    pub throttle_min: R,
    /// Greatest throttle.
    pub throttle_max: R,
}

impl<R: Real> Default for Limits<R> {
    /// 0.5 to 20.4 N, throttle 0.05 to 1.
    fn default() -> Self {
        Self {
            thrust_min_n: r(0.5),
            thrust_max_n: r(20.4),
            throttle_min: r(0.05),
            throttle_max: R::ONE,
        }
    }
}

impl<R: Real> Limits<R> {
    /// Checks the limits.
    ///
    /// # Errors
    /// Thrusts must not be negative, throttles lie in [0, 1], and each
    /// minimum lies below its maximum.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("limits.thrust_min_n", self.thrust_min_n)?;
        ordered(
            "limits.thrust_min_n",
            self.thrust_min_n,
            "limits.thrust_max_n",
            self.thrust_max_n,
        )?;
        not_negative("limits.throttle_min", self.throttle_min)?;
        within(
            "limits.throttle_max",
            self.throttle_max,
            self.throttle_max <= R::ONE,
            "a throttle not above 1",
        )?;
        ordered(
            "limits.throttle_min",
            self.throttle_min,
            "limits.throttle_max",
            self.throttle_max,
        )
    }

    /// `thrust_n` within the thrust limits.
    #[must_use]
    pub fn thrust(&self, thrust_n: R) -> R {
        thrust_n.clamp(self.thrust_min_n, self.thrust_max_n)
    }

    /// `throttle` within the throttle limits.
    #[must_use]
    pub fn throttle(&self, throttle: R) -> R {
        throttle.clamp(self.throttle_min, self.throttle_max)
    }
}
