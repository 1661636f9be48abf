//! All control laws as one value.

use super::{
    Composite, CompositeState, ControlInput, Demand, Imbc, ImbcState, Saturation, Ssc, SscState,
};
use crate::error::SettingsError;
use crate::ground_effect::Lift;
use crate::real::Real;

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
