//! Vertical control laws, and the channel that carries them out.
//!
//! Eq. (10) is [`Composite`]; [`Imbc`] and [`Ssc`] are reconstructions of the laws that the
//! paper compares with. Every law turns tracking errors into the free-air thrust that it asks for
//! ([`Demand`]), without limits; once the actuators' limits are known, the state
//! is advanced with what was really sent. With reference z_r, `e = z - z_r`:
//!
//! ```text
//! s = (v - z_r') + Γ e                               sliding variable, m/s
//! a = z_p''^ + z_r'' - Γ (v - z_r')                  reference acceleration v_r'
//! ```

pub mod channel;
mod composite;
mod imbc;
mod ssc;

pub use channel::VerticalState;
pub use composite::{Composite, CompositeState, Gains};
pub use imbc::{Imbc, ImbcState};
pub use ssc::{Ssc, SscState};

use crate::error::SettingsError;
use crate::ground_effect::Lift;
use crate::real::Real;
use crate::reference::ReferencePoint;

/// Input of a control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlInput<R> {
    /// Height above the deck z, m.
    pub height_m: R,
    /// Velocity relative to the deck v, m/s.
    pub relative_velocity_mps: R,
    /// The reference at this time.
    pub reference: ReferencePoint<R>,
    /// Estimated acceleration of the deck z_p''^, m/s²; zero where it is not
    /// fed forward.
    pub deck_acceleration_mps2: R,
    /// Mass of the vehicle m, kg.
    pub mass_kg: R,
    /// Acceleration of gravity g, m/s².
    pub gravity_mps2: R,
}

impl<R: Real> ControlInput<R> {
    /// `s = (v - z_r') + Γ (z - z_r)`, m/s.
    pub fn sliding(&self, gamma: R) -> R {
        (self.relative_velocity_mps - self.reference.velocity_mps)
            + gamma * (self.height_m - self.reference.height_m)
    }

    /// `z_r'' - Γ (v - z_r')`, m/s²: the reference acceleration relative to the deck.
    pub fn relative_acceleration_mps2(&self, gamma: R) -> R {
        self.reference.acceleration_mps2
            - gamma * (self.relative_velocity_mps - self.reference.velocity_mps)
    }

    /// `W = m g`, N.
    pub fn weight_n(&self) -> R {
        self.mass_kg * self.gravity_mps2
    }
}

/// Output of a control law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand<R> {
    /// Free-air thrust, N, without limits.
    pub thrust_n: R,
    /// The sliding variable s, m/s.
    pub sliding_mps: R,
}

/// How a demand met the limits of the actuators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Saturation {
    /// Sent as asked for.
    #[default]
    No,
    /// More was sent than asked for.
    Low,
    /// Less was sent than asked for.
    High,
}

impl Saturation {
    /// Thrust that pushes further into the limit: upward at `High`.
    fn resists<R: Real>(self, push_n: R) -> bool {
        match self {
            Self::No => false,
            Self::Low => push_n < R::ZERO,
            Self::High => push_n > R::ZERO,
        }
    }
}

/// A control law of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub enum Law<R: Real> {
    /// Composite tracking with ground-effect feed-forward.
    Composite(Composite<R>),
    /// Internal-model control; uses neither ground effect nor deck acceleration.
    Imbc(Imbc<R>),
    /// Smooth sliding control; uses no ground effect.
    Ssc(Ssc<R>),
}

/// State of a [`Law`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawState<R> {
    /// Of the composite law.
    Composite(CompositeState<R>),
    /// Of the internal-model law.
    Imbc(ImbcState<R>),
    /// Of the sliding law.
    Ssc(SscState<R>),
}

impl<R: Real> Law<R> {
    /// Checks the gains.
    ///
    /// # Errors
    /// See the law.
    pub fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::Composite(law) => law.validate(),
            Self::Imbc(law) => law.validate(),
            Self::Ssc(law) => law.validate(),
        }
    }

    /// Whether the law counts on an estimate of the ground effect.
    #[must_use]
    pub fn uses_ground_effect(&self) -> bool {
        matches!(self, Self::Composite(_))
    }

    /// The state at the start, where `thrust_n` is being sent.
    #[must_use]
    pub fn initial(&self, thrust_n: R) -> LawState<R> {
        match self {
            Self::Composite(_) => LawState::Composite(CompositeState::default()),
            Self::Imbc(_) => LawState::Imbc(ImbcState::default()),
            Self::Ssc(_) => LawState::Ssc(SscState { thrust_n }),
        }
    }

    /// The thrust asked for. A state of another law counts as that law's start
    /// at the vehicle's weight.
    pub fn demand(
        &self,
        state: &LawState<R>,
        input: &ControlInput<R>,
        lift: Lift<R>,
        dt: R,
    ) -> Demand<R> {
        match (self, state) {
            (Self::Composite(law), LawState::Composite(state)) => law.demand(state, input, lift),
            (Self::Composite(law), _) => law.demand(&CompositeState::default(), input, lift),
            (Self::Imbc(law), LawState::Imbc(state)) => law.demand(state, input),
            (Self::Imbc(law), _) => law.demand(&ImbcState::default(), input),
            (Self::Ssc(law), LawState::Ssc(state)) => law.demand(state, input, dt),
            (Self::Ssc(law), _) => {
                let thrust_n = input.weight_n();
                law.demand(&SscState { thrust_n }, input, dt)
            }
        }
    }

    /// Advances the state over `dt` seconds, given what was sent.
    pub fn advance(
        &self,
        state: &mut LawState<R>,
        demand: &Demand<R>,
        sent_thrust_n: R,
        saturation: Saturation,
        dt: R,
    ) {
        match (self, &mut *state) {
            (Self::Composite(law), LawState::Composite(state)) => {
                law.advance(state, demand, saturation, dt);
            }
            (Self::Imbc(law), LawState::Imbc(state)) => law.advance(state, demand, saturation, dt),
            (Self::Ssc(law), LawState::Ssc(state)) => law.advance(state, sent_thrust_n),
            _ => *state = self.initial(sent_thrust_n),
        }
    }
}
