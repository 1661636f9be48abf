//! All families as one value.

use super::{Empirical, GroundEffect, GroundEffectInput, Lag, Lift, Polynomial, Ratio, StaticMap};
use crate::error::SettingsError;
use crate::real::Real;

/// A ground-effect model of any family.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum GroundEffectModel<R> {
    /// No ground effect.
    #[default]
    None,
    /// Eq. (2): the empirical law.
    Empirical(Empirical<R>),
    /// `y = h(z)`: a static map of height.
    StaticMap(StaticMap<R>),
    /// Eq. (9): the eleven-term polynomial.
    Polynomial(Polynomial<R>),
    /// `y' = Θ(y, z, v_p) ξ`: the derivative form of the ratio.
    Ratio(Ratio<R>),
    /// `y = G + k(z) v_p`, `G' = (h(z) - G) / τ`: the lag form of the ratio.
    Lag(Lag<R>),
}

/// State of a [`GroundEffectModel`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GroundEffectState<R> {
    /// Of a static model.
    #[default]
    Static,
    /// Force of a [`Polynomial`], N.
    Polynomial(R),
    /// Ratio of a [`Ratio`].
    Ratio(R),
    /// Lagged ratio of a [`Lag`].
    Lag(R),
}

/// Where a state belongs to another family, the model starts at rest.
impl<R: Real> GroundEffect<R> for GroundEffectModel<R> {
    type State = GroundEffectState<R>;

    fn rest(&self, input: &GroundEffectInput<R>) -> GroundEffectState<R> {
        match self {
            Self::None | Self::Empirical(_) | Self::StaticMap(_) => GroundEffectState::Static,
            Self::Polynomial(model) => GroundEffectState::Polynomial(model.rest(input)),
            Self::Ratio(model) => GroundEffectState::Ratio(model.rest(input)),
            Self::Lag(model) => GroundEffectState::Lag(model.rest(input)),
        }
    }

    fn lift(&self, state: &GroundEffectState<R>, input: &GroundEffectInput<R>) -> Lift<R> {
        match (self, state) {
            (Self::None, _) => Lift::default(),
            (Self::Empirical(model), _) => model.lift(&(), input),
            (Self::StaticMap(model), _) => model.lift(&(), input),
            (Self::Polynomial(model), GroundEffectState::Polynomial(f)) => model.lift(f, input),
            (Self::Ratio(model), GroundEffectState::Ratio(y)) => model.lift(y, input),
            (Self::Lag(model), GroundEffectState::Lag(g)) => model.lift(g, input),
            (Self::Polynomial(model), _) => model.lift(&model.rest(input), input),
            (Self::Ratio(model), _) => model.lift(&model.rest(input), input),
            (Self::Lag(model), _) => model.lift(&model.rest(input), input),
        }
    }

    fn advance(&self, state: &mut GroundEffectState<R>, input: &GroundEffectInput<R>, dt: R) {
        match (self, &mut *state) {
            (Self::None | Self::Empirical(_) | Self::StaticMap(_), _) => {}
            (Self::Polynomial(model), GroundEffectState::Polynomial(f)) => {
                model.advance(f, input, dt);
            }
            (Self::Ratio(model), GroundEffectState::Ratio(y)) => model.advance(y, input, dt),
            (Self::Lag(model), GroundEffectState::Lag(g)) => model.advance(g, input, dt),
            _ => *state = self.rest(input),
        }
    }

    fn limit(&self, state: &mut GroundEffectState<R>, thrust_n: R, ratio_min: R, ratio_max: R) {
        match (self, state) {
            (Self::Polynomial(model), GroundEffectState::Polynomial(f)) => {
                model.limit(f, thrust_n, ratio_min, ratio_max);
            }
            (Self::Ratio(model), GroundEffectState::Ratio(y)) => {
                model.limit(y, thrust_n, ratio_min, ratio_max);
            }
            (Self::Lag(model), GroundEffectState::Lag(g)) => {
                model.limit(g, thrust_n, ratio_min, ratio_max);
            }
            _ => {}
        }
    }

    fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::None => Ok(()),
            Self::Empirical(model) => model.validate(),
            Self::StaticMap(model) => model.validate(),
            Self::Polynomial(model) => model.validate(),
            Self::Ratio(model) => model.validate(),
            Self::Lag(model) => model.validate(),
        }
    }
}
