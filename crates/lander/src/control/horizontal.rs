//! Horizontal control: proportional, derivative, integral, within limits.

use crate::check::{not_negative, positive};
use touchdown_flight::error::{SettingsError, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// The horizontal part of `f_u = m v_r' - K_P s - K_I ∫ s dt`, as acceleration:
///
/// ```text
/// w = v_ref + limited(-(k_p/k_d) e)              velocity towards the target
/// a = limited(a_deck + a_ref - k_d (v - w)) + a_trim
/// a_trim = -d/m - k_i ∫ (v - w) dt               against the disturbance d
/// ```
///
/// with e the horizontal error of position. The limits hold for the manoeuvre, so that a
/// steady wind, which the trim balances, takes nothing from them; tilt and thrust limit
/// the sum. Within the speed limit v - w is the
/// sliding variable `s = (v - v_ref) + (k_p/k_d) e`, and without integral the law
/// is `a = a_deck + a_ref - k_d (v - v_ref) - k_p e`: the vector law with
/// `k_d = Γ + K_P/m`, `k_p = Γ K_P/m`. As s vanishes on the way to the target, the
/// integral does not wind up there. Poles should be slow against those of the
/// attitude control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct Horizontal<R> {
    /// Gain on position k_p, 1/s².
    pub position_per_s2: R,
    /// Gain on velocity k_d, 1/s.
    pub velocity_per_s: R,
    /// Gain on the integral k_i, 1/s².
    pub integral_per_s2: R,
    /// Factor on the rate of the poles in a descent: k_d grows with it, k_p and k_i with its
    /// square.
    #[cfg_attr(feature = "serde", serde(default = "descent_factor"))]
    pub descent_factor: R,
    /// Greatest contribution of the integral, m/s².
    pub integral_limit_mps2: R,
    /// Greatest speed towards the target, m/s.
    pub speed_limit_mps: R,
    /// Greatest demanded acceleration of a manoeuvre, m/s², beside the trim.
    pub acceleration_limit_mps2: R,
    /// Greatest demanded tilt, trim and manoeuvre together, rad, below 1. The thrust
    /// reserve may allow less.
    pub tilt_limit_rad: R,
}

/// State of [`Horizontal`] control.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HorizontalState<R> {
    /// `k_i ∫ (v - w) dt`, m/s².
    pub integral_mps2: Vector<R>,
}

/// Position and motion relative to the deck, horizontal components; z is not used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Errors<R> {
    pub(crate) position_m: Vector<R>,
    pub(crate) velocity_mps: Vector<R>,
    /// Acceleration of deck and reference, m/s².
    pub(crate) forward_mps2: Vector<R>,
    /// Acceleration against the disturbance, m/s².
    pub(crate) against_mps2: Vector<R>,
}

/// A demanded acceleration, and whether a limit has reduced it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AccelerationDemand<R> {
    pub(crate) acceleration_mps2: Vector<R>,
    pub(crate) limited: bool,
    /// v - w, m/s.
    pub(crate) sliding_mps: Vector<R>,
}

/// A hover must bear a latency that is still unknown, and its swing shows it; a descent begins
/// after. At 1 the vehicle lands 0.06 m from the centre at sea (median) instead of 0.04 m; at 2
/// the poles come near those of the attitude control.
fn descent_factor<R: Real>() -> R {
    r(1.5)
}

impl<R: Real> Default for Horizontal<R> {
    /// k_p 3.2 1/s², k_d 3.2 1/s (damping ratio 0.89), k_i 0.8 1/s² within 0.5 m/s²;
    /// 1 m/s, 3 m/s² (0.30 rad beside the trim), 0.7 rad in all: the trim tilt of 15 m/s of
    /// wind on the default airframe, 0.63 rad, and below the 0.785 rad of attitude controls.
    fn default() -> Self {
        Self {
            position_per_s2: r(3.2),
            velocity_per_s: r(3.2),
            integral_per_s2: r(0.8),
            descent_factor: descent_factor(),
            integral_limit_mps2: r(0.5),
            speed_limit_mps: R::ONE,
            acceleration_limit_mps2: r(3.0),
            tilt_limit_rad: r(0.7),
        }
    }
}

impl<R: Real> Horizontal<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Gains on position and velocity and all limits must be positive, the
    /// integral's gain and limit not negative; the tilt lies below 1 rad.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("horizontal.position_per_s2", self.position_per_s2)?;
        positive("horizontal.velocity_per_s", self.velocity_per_s)?;
        not_negative("horizontal.integral_per_s2", self.integral_per_s2)?;
        positive("horizontal.descent_factor", self.descent_factor)?;
        not_negative("horizontal.integral_limit_mps2", self.integral_limit_mps2)?;
        positive("horizontal.speed_limit_mps", self.speed_limit_mps)?;
        positive(
            "horizontal.acceleration_limit_mps2",
            self.acceleration_limit_mps2,
        )?;
        positive("horizontal.tilt_limit_rad", self.tilt_limit_rad)?;
        within(
            "horizontal.tilt_limit_rad",
            self.tilt_limit_rad,
            self.tilt_limit_rad < R::ONE,
            "a tilt below 1 rad",
        )
    }

    /// The same law with the poles of a descent, and at least faster by the share `haste`.
    pub(crate) fn hastened(&self, descending: bool, haste: R) -> Self {
        let factor = if descending {
            self.descent_factor
        } else {
            R::ONE
        };
        let factor = factor.max(R::ONE + haste);
        Self {
            position_per_s2: self.position_per_s2 * factor * factor,
            velocity_per_s: self.velocity_per_s * factor,
            integral_per_s2: self.integral_per_s2 * factor * factor,
            ..*self
        }
    }

    /// Acceleration that holds the vehicle still in its disturbance, m/s².
    pub(crate) fn trim_mps2(
        &self,
        state: &HorizontalState<R>,
        against_mps2: Vector<R>,
    ) -> Vector<R> {
        against_mps2.horizontal() - state.integral_mps2
    }

    /// The demanded acceleration.
    pub(crate) fn demand(
        &self,
        state: &HorizontalState<R>,
        errors: &Errors<R>,
    ) -> AccelerationDemand<R> {
        let towards = (errors.position_m.horizontal()
            * -(self.position_per_s2 / self.velocity_per_s))
            .limited(self.speed_limit_mps);
        let sliding_mps = errors.velocity_mps.horizontal() - towards;
        let wanted = errors.forward_mps2.horizontal() - sliding_mps * self.velocity_per_s;
        let maneuver_mps2 = wanted.limited(self.acceleration_limit_mps2);
        AccelerationDemand {
            acceleration_mps2: maneuver_mps2 + self.trim_mps2(state, errors.against_mps2),
            limited: maneuver_mps2 != wanted,
            sliding_mps,
        }
    }

    /// Integrates over `dt` seconds. While a limit acts, the integral may only decrease
    /// the demand (anti-windup).
    pub(crate) fn advance(
        &self,
        state: &mut HorizontalState<R>,
        asked: &AccelerationDemand<R>,
        limited: bool,
        dt: R,
    ) {
        let change = asked.sliding_mps * (self.integral_per_s2 * usable_dt(dt));
        if limited && change.dot(asked.acceleration_mps2) < R::ZERO {
            return;
        }
        state.integral_mps2 = (state.integral_mps2 + change)
            .limited(self.integral_limit_mps2)
            .finite_or(state.integral_mps2);
    }
}
