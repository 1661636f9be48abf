//! Disturbance observer on the IMU, and the record of model forces that it shares with
//! the adaptation.

use crate::check::{not_negative, positive};
use touchdown_flight::error::{SettingsError, within};
use touchdown_flight::ground_effect::Lift;
use touchdown_flight::kernel::{Delay, lag_share, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Length of the record of forces, in control steps: 0.31 s at 100 Hz, more than the sum
/// of delays in any loop that flies.
const STEPS: usize = 32;

/// Delays of the control loop.
///
/// The record covers 31 control steps, so a longer sum of delays counts as 31 steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Delays<R> {
    /// Age of the acceleration when the controller gets it, s. It counts from the middle
    /// of the averaging interval.
    pub sensing_s: R,
    /// Age of the attitude when the controller gets it, s; at most `sensing_s`. It equals
    /// `sensing_s` if this attitude turned the acceleration into world axes.
    pub attitude_s: R,
    /// Time from a command to its start at the rotors, s.
    pub command_s: R,
}

impl<R: Real> Default for Delays<R> {
    /// Acceleration 20 ms, attitude without delay, commands 10 ms.
    fn default() -> Self {
        Self {
            sensing_s: r(0.02),
            attitude_s: R::ZERO,
            command_s: r(0.01),
        }
    }
}

impl<R: Real> Delays<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Delays must not be negative, and the attitude not older than the acceleration.
    pub fn validate(&self) -> Result<(), SettingsError> {
        not_negative("delays.sensing_s", self.sensing_s)?;
        not_negative("delays.attitude_s", self.attitude_s)?;
        within(
            "delays.attitude_s",
            self.attitude_s,
            self.attitude_s <= self.sensing_s,
            "not more than sensing_s",
        )?;
        not_negative("delays.command_s", self.command_s)
    }
}

/// Forces along the rotors' axis at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axial<R> {
    thrust_n: R,
    /// Ground effect of the model, N.
    model_n: R,
    /// Ground effect scaled by the adaptation, N.
    used_n: R,
}

/// Record of the last modelled forces and thrust directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Record<R> {
    axial: Delay<R, Axial<R>, STEPS>,
    up: Delay<R, Vector<R>, STEPS>,
}

/// Force measured by the IMU, compared with the models at the time of measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Felt<R> {
    /// `m (a + g e_z)` less thrust and used ground effect, world axes, N.
    pub(crate) unexplained_n: Vector<R>,
    /// Force along the rotors' axis less thrust alone, N.
    pub(crate) beyond_thrust_n: R,
    /// Ground effect of the model, N.
    pub(crate) model_n: R,
    /// Thrust, N.
    pub(crate) thrust_n: R,
}

impl<R: Real> Record<R> {
    pub(crate) fn new(thrust_n: R, lift: Lift<R>, up: Vector<R>) -> Self {
        Self {
            axial: Delay::new(axial(thrust_n, lift, R::ONE)),
            up: Delay::new(up),
        }
    }

    pub(crate) fn push(&mut self, thrust_n: R, lift: Lift<R>, strength: R, up: Vector<R>, dt: R) {
        self.axial.push(axial(thrust_n, lift, strength), dt);
        self.up.push(up, dt);
    }

    /// Compares an acceleration that arrives now with the models.
    pub(crate) fn felt(
        &self,
        delays: &Delays<R>,
        acceleration_mps2: Vector<R>,
        mass_kg: R,
        gravity_mps2: R,
    ) -> Felt<R> {
        let (a, b, share) = self.axial.around(delays.sensing_s + delays.command_s);
        let between = |of: fn(&Axial<R>) -> R| of(&a) + (of(&b) - of(&a)) * share;
        let thrust_n = between(|axial| axial.thrust_n);
        let model_n = between(|axial| axial.model_n);
        let used_n = between(|axial| axial.used_n);
        let (a, b, share) = self.up.around(delays.sensing_s - delays.attitude_s);
        // The axis turns little between two steps, so a linear interpolation suffices.
        let up = a + (b - a) * share;
        let force_n = (acceleration_mps2 + Vector::UP * gravity_mps2) * mass_kg;
        Felt {
            unexplained_n: force_n - up * (thrust_n + used_n),
            beyond_thrust_n: force_n.dot(up) - thrust_n,
            model_n,
            thrust_n,
        }
    }
}

fn axial<R: Real>(thrust_n: R, lift: Lift<R>, strength: R) -> Axial<R> {
    let model_n = lift.total_n(thrust_n).finite_or(R::ZERO);
    Axial {
        thrust_n,
        model_n,
        used_n: strength * model_n,
    }
}

/// Disturbance observer: measured force less modelled force, through a low-pass filter,
///
/// ```text
/// d' = (m (a + g e_z) - b_z (T^ + f^) - d) / τ
/// ```
///
/// with thrust T^, ground effect f^ and direction b_z at the time when the acceleration a
/// was measured ([`Delays`]). The length of the estimate is limited.
///
/// A law that subtracts the estimate from its demanded force cancels constant
/// disturbances (wind, a wrong thrust scale, ground effect beyond the model) without an
/// integral of the tracking error. On the deck the observer would mistake the legs' force
/// for lift, so it must be held there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Observer<R> {
    /// Time constant τ, s. It should be several times the error of the delays.
    pub filter_s: R,
    /// Greatest disturbance, N.
    pub limit_n: R,
}

impl<R: Real> Default for Observer<R> {
    /// 0.1 s, 12 N: what the default airframe's thrust reserve balances,
    /// √((0.9 · 20.4 N)² - W²). At 4 N the trim ended at 8 m/s of wind.
    fn default() -> Self {
        Self {
            filter_s: r(0.1),
            limit_n: r(12.0),
        }
    }
}

impl<R: Real> Observer<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Both must be positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        positive("observer.filter_s", self.filter_s)?;
        positive("observer.limit_n", self.limit_n)
    }

    /// Advances the estimate `disturbance_n` over `dt` seconds.
    pub(crate) fn step(&self, disturbance_n: &mut Vector<R>, felt: &Felt<R>, dt: R) {
        let d = *disturbance_n;
        let share = lag_share(self.filter_s, usable_dt(dt));
        *disturbance_n = (d + (felt.unexplained_n - d) * share)
            .limited(self.limit_n)
            .finite_or(d);
    }
}
