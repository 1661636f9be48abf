//! Disturbance observer on the IMU, and what both it and the adaptation read.

use touchdown_flight::error::{SettingsError, not_negative, positive, within};
use touchdown_flight::ground_effect::Lift;
use touchdown_flight::kernel::{Delay, lag_share, usable_dt};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::Vector;

/// Steps that the record of forces reaches back.
const STEPS: usize = 32;

/// How late the parts of the loop are.
///
/// The record reaches back 31 control steps; a longer sum of delays than that
/// is read as 31 steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Delays<R> {
    /// Age of the acceleration when the controller gets it (of the middle of the time
    /// over which it is a mean), s.
    pub sensing_s: R,
    /// Age of the attitude when the controller gets it, s; not more than `sensing_s`.
    /// An attitude by which the acceleration was turned into the world's axes is as old
    /// as that.
    pub attitude_s: R,
    /// Time from a command to the rotors taking it up, s.
    pub command_s: R,
}

impl<R: Real> Default for Delays<R> {
    /// Acceleration 20 ms, attitude of now, commands 10 ms.
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
    /// Ground effect as the model says.
    model_n: R,
    /// Ground effect as it was used, scaled by the adaptation.
    used_n: R,
}

/// The last forces and directions of thrust, as the models have them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Record<R> {
    axial: Delay<R, Axial<R>, STEPS>,
    up: Delay<R, Vector<R>, STEPS>,
}

/// What the IMU felt, beside what the models explain of that time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Felt<R> {
    /// `m (a + g e_z)` less thrust and used ground effect, world axes, N.
    pub(crate) unexplained_n: Vector<R>,
    /// Force along the rotors' axis less thrust alone, N.
    pub(crate) beyond_thrust_n: R,
    /// Ground effect as the model says, N.
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

    /// For an acceleration that comes now.
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
        // Between two steps the axis turns by little: the chord is the arc.
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

/// Disturbance observer: force felt less force explained, through a low-pass,
///
/// ```text
/// d' = (m (a + g e_z) - b_z (T^ + f^) - d) / τ
/// ```
///
/// with thrust T^, ground effect f^ and direction b_z those of the time at which
/// the acceleration a was sensed ([`Delays`]). The estimate is limited in
/// length. Laws subtract it from the force they ask for; one that does cancels
/// constant disturbances (wind, a wrong thrust scale, ground effect beyond the
/// model) without an integral of the tracking error. On the deck it would take
/// the legs' force for lift: hold it there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Observer<R> {
    /// Time constant τ, s. Several times the time by which the delays may be
    /// wrong.
    pub filter_s: R,
    /// Greatest disturbance, N.
    pub limit_n: R,
}

impl<R: Real> Default for Observer<R> {
    /// 0.1 s, 4 N.
    fn default() -> Self {
        Self {
            filter_s: r(0.1),
            limit_n: r(4.0),
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
