//! Ground effect above a deck that may move: families behind one trait.
//!
//! The vertical aerodynamic force is `T + f` with `T` the free-air thrust and
//! `f = ratio · T + force_n` the ground effect. A ratio lets a controller solve
//! its feed-forward exactly: `T_cmd = (base - force_n) / (1 + ratio)`.
//!
//! | family | equation | state | law |
//! | --- | --- | --- | --- |
//! | [`Empirical`] | (2) | – | `ratio = q / (1 - q)`, `q = μ (R / 4z)²` |
//! | [`StaticMap`] | own | – | `y = h(z)`, bounded functions of height |
//! | [`Polynomial`] | (9), (12) | force | eleven-term polynomial `f'` |
//! | [`Ratio`] | own | ratio | sparse `y'`, `y = f / T` |
//! | [`Lag`] | own | ratio | `y = G + k(z) v_p`, first-order lag `G` |
//!
//! Families extrapolate as their formulas do. Fly them inside a [`Guarded`],
//! which keeps heights and results within the range of the data.

mod empirical;
mod guard;
mod lag;
mod polynomial;
mod ratio;
mod static_map;

pub use empirical::Empirical;
pub use guard::{Guarded, GuardedState, Outside, Validity, VelocityInput};
pub use lag::Lag;
pub use polynomial::Polynomial;
pub use ratio::Ratio;
pub use static_map::StaticMap;

use crate::error::SettingsError;
use crate::real::{Real, r};

/// Input of a ground-effect model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundEffectInput<R> {
    /// Free-air thrust T, N.
    pub thrust_n: R,
    /// Throttle σ in [0, 1].
    pub throttle: R,
    /// Height of the vehicle's reference point above the deck z, m.
    pub height_m: R,
    /// Velocity of the vehicle v_q, up, m/s.
    pub vehicle_velocity_mps: R,
    /// Velocity of the deck v_p, up, m/s.
    pub deck_velocity_mps: R,
    /// Heights of the four rotor planes above the deck, m, where known.
    pub rotor_heights_m: Option<[R; 4]>,
}

impl<R: Real> GroundEffectInput<R> {
    /// `self` with every value that is not finite taken from `previous`.
    #[must_use]
    pub fn or_previous(&self, previous: &Self) -> Self {
        // A number times zero is zero, but not of an infinite one or NaN: one comparison for
        // all instead of one each.
        let mut zeros = self.thrust_n * R::ZERO;
        for x in [
            self.throttle,
            self.height_m,
            self.vehicle_velocity_mps,
            self.deck_velocity_mps,
        ] {
            zeros += x * R::ZERO;
        }
        if zeros == R::ZERO && self.rotor_heights_m.is_none() {
            return Self {
                rotor_heights_m: None,
                ..*self
            };
        }
        self.finite_or_previous(previous)
    }

    #[cold]
    fn finite_or_previous(&self, previous: &Self) -> Self {
        Self {
            thrust_n: self.thrust_n.finite_or(previous.thrust_n),
            throttle: self.throttle.finite_or(previous.throttle),
            height_m: self.height_m.finite_or(previous.height_m),
            vehicle_velocity_mps: self
                .vehicle_velocity_mps
                .finite_or(previous.vehicle_velocity_mps),
            deck_velocity_mps: self.deck_velocity_mps.finite_or(previous.deck_velocity_mps),
            rotor_heights_m: self
                .rotor_heights_m
                .filter(|heights| heights.iter().all(|z| z.is_finite())),
        }
    }
}

/// Ground effect as `f = ratio · T + force_n`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lift<R> {
    /// The part that is proportional to thrust.
    pub ratio: R,
    /// The part that is a force, N.
    pub force_n: R,
}

impl<R: Real> Lift<R> {
    /// A lift that is a ratio of thrust.
    #[must_use]
    pub fn from_ratio(ratio: R) -> Self {
        Self {
            ratio,
            force_n: R::ZERO,
        }
    }

    /// A lift that is a force, N.
    #[must_use]
    pub fn from_force(force_n: R) -> Self {
        Self {
            ratio: R::ZERO,
            force_n,
        }
    }

    /// The ground-effect force at a free-air thrust, N.
    pub fn total_n(&self, thrust_n: R) -> R {
        self.ratio * thrust_n + self.force_n
    }
}

/// A model of the ground effect: immutable coefficients, explicit state.
pub trait GroundEffect<R: Real> {
    /// The dynamic state; `()` for a static model.
    type State: Copy;

    /// The state at rest under a constant input; zero where there is no rest.
    fn rest(&self, input: &GroundEffectInput<R>) -> Self::State;

    /// The lift for a state and an input.
    fn lift(&self, state: &Self::State, input: &GroundEffectInput<R>) -> Lift<R>;

    /// Advances the state over `dt` seconds under a constant input.
    ///
    /// A result that is not finite, or a `dt` that is not positive, leaves the
    /// state as it is.
    fn advance(&self, state: &mut Self::State, input: &GroundEffectInput<R>, dt: R);

    /// Advances the state over `dt` seconds and gives the lift at its end.
    fn step(&self, state: &mut Self::State, input: &GroundEffectInput<R>, dt: R) -> Lift<R> {
        self.advance(state, input, dt);
        self.lift(state, input)
    }

    /// [`step`](GroundEffect::step) with the state brought within the limits of
    /// [`limit`](GroundEffect::limit) before the lift is taken.
    fn step_within(
        &self,
        state: &mut Self::State,
        input: &GroundEffectInput<R>,
        dt: R,
        ratio_min: R,
        ratio_max: R,
    ) -> Lift<R> {
        self.advance(state, input, dt);
        self.limit(state, input.thrust_n, ratio_min, ratio_max);
        self.lift(state, input)
    }

    /// Brings a state back to where its lift is within `[ratio_min, ratio_max]`
    /// times `thrust_n`.
    fn limit(&self, _state: &mut Self::State, _thrust_n: R, _ratio_min: R, _ratio_max: R) {}

    /// Checks the coefficients.
    ///
    /// # Errors
    /// Names the first coefficient that is not usable.
    fn validate(&self) -> Result<(), SettingsError> {
        Ok(())
    }
}

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

impl<R: Copy> GroundEffectState<R> {
    /// The force or ratio that the state holds; none of a static model.
    pub fn value(&self) -> Option<R> {
        match *self {
            Self::Static => None,
            Self::Polynomial(value) | Self::Ratio(value) | Self::Lag(value) => Some(value),
        }
    }
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

    fn step_within(
        &self,
        state: &mut GroundEffectState<R>,
        input: &GroundEffectInput<R>,
        dt: R,
        ratio_min: R,
        ratio_max: R,
    ) -> Lift<R> {
        match (self, &mut *state) {
            (Self::Polynomial(model), GroundEffectState::Polynomial(f)) => {
                model.step_within(f, input, dt, ratio_min, ratio_max)
            }
            (Self::Ratio(model), GroundEffectState::Ratio(y)) => {
                model.step_within(y, input, dt, ratio_min, ratio_max)
            }
            (Self::Lag(model), GroundEffectState::Lag(g)) => {
                model.step_within(g, input, dt, ratio_min, ratio_max)
            }
            _ => {
                self.advance(state, input, dt);
                self.limit(state, input.thrust_n, ratio_min, ratio_max);
                self.lift(state, input)
            }
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

/// `ψ_i(z) = 1 / (1 + (z / L_i)²)`: bounded at every height.
fn psi<R: Real>(height_m: R, length_m: [R; 3]) -> [R; 3] {
    length_m.map(|length| {
        let u = height_m / length;
        R::ONE / (R::ONE + u * u)
    })
}

/// The default lengths L of ψ, m.
fn default_lengths<R: Real>() -> [R; 3] {
    [r(0.08), r(0.20), r(0.45)]
}
