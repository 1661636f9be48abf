//! Limits of validity, obeyed in flight.

use super::{GroundEffect, GroundEffectInput, GroundEffectModel, Lift};
use crate::error::{SettingsError, ordered, within};
use crate::real::{Real, r};

/// What happens to the lift above the greatest height of the data. Below the
/// least height the model is always used at the least height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Outside {
    /// The model is used at the greatest height.
    #[default]
    Clamp,
    /// As `Clamp`, and the lift falls linearly to zero over one further range
    /// of heights.
    Fade,
}

/// What a model is given as the velocity of the deck.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum VelocityInput {
    /// The velocity of the deck v_p and of the vehicle v_q, apart.
    #[default]
    Deck,
    /// `-v = v_p - v_q` for v_p, and zero for v_q: an approximation for models
    /// identified under a vehicle at rest. The two velocities do not act in the
    /// same way (the deck's upwash decays with height, the damping of the
    /// vehicle's own climb does not).
    NegativeRelative,
}

/// The range in which a model may be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Validity<R> {
    /// Least height of the data, m.
    pub height_min_m: R,
    /// Greatest height of the data, m.
    pub height_max_m: R,
    /// Least `f / T`.
    pub ratio_min: R,
    /// Greatest `f / T`.
    pub ratio_max: R,
    /// Behaviour above the greatest height.
    pub outside: Outside,
}

impl<R: Real> Default for Validity<R> {
    /// Heights 0.10 to 0.85 m, ratio -0.1 to 0.6, clamped.
    fn default() -> Self {
        Self {
            height_min_m: r(0.10),
            height_max_m: r(0.85),
            ratio_min: r(-0.1),
            ratio_max: r(0.6),
            outside: Outside::Clamp,
        }
    }
}

impl<R: Real> Validity<R> {
    /// Checks the limits.
    ///
    /// # Errors
    /// Minima must lie below maxima, and the least ratio above -1 (a feed-forward
    /// divides by one plus the ratio).
    pub fn validate(&self) -> Result<(), SettingsError> {
        ordered(
            "validity.height_min_m",
            self.height_min_m,
            "validity.height_max_m",
            self.height_max_m,
        )?;
        ordered(
            "validity.ratio_min",
            self.ratio_min,
            "validity.ratio_max",
            self.ratio_max,
        )?;
        within(
            "validity.ratio_min",
            self.ratio_min,
            self.ratio_min > -R::ONE,
            "a ratio above -1",
        )
    }

    /// The part of the lift that remains at a height, 0 to 1.
    fn remaining(&self, height_m: R) -> R {
        match self.outside {
            Outside::Clamp => R::ONE,
            Outside::Fade => {
                let beyond =
                    (height_m - self.height_max_m) / (self.height_max_m - self.height_min_m);
                (R::ONE - beyond).clamp(R::ZERO, R::ONE)
            }
        }
    }
}

/// A ground-effect model with its limits of validity.
///
/// Heights enter the model within the range of the data; states and lift stay
/// within the range of ratios, so that a long stay outside cannot wind a state
/// up; values that are not finite are replaced by the last ones that were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize, M: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>, M: serde::Deserialize<'de>"
    ))
)]
pub struct Guarded<R: Real, M = GroundEffectModel<R>> {
    /// The model.
    pub model: M,
    /// Its limits.
    #[cfg_attr(feature = "serde", serde(default))]
    pub validity: Validity<R>,
    /// What it is given as velocities.
    #[cfg_attr(feature = "serde", serde(default))]
    pub velocity: VelocityInput,
}

/// State of a [`Guarded`] model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardedState<R, S> {
    /// State of the model.
    pub model: S,
    /// The last input, with every value finite.
    pub input: GroundEffectInput<R>,
}

impl<R: Real, M: GroundEffect<R>> Guarded<R, M> {
    /// A model within limits, given the velocities of deck and vehicle apart.
    pub fn new(model: M, validity: Validity<R>) -> Self {
        Self {
            model,
            validity,
            velocity: VelocityInput::Deck,
        }
    }

    /// What the model is given for a finite input.
    fn inner(&self, input: &GroundEffectInput<R>) -> GroundEffectInput<R> {
        let height_m = input
            .height_m
            .clamp(self.validity.height_min_m, self.validity.height_max_m);
        let shift = height_m - input.height_m;
        let (vehicle_velocity_mps, deck_velocity_mps) = match self.velocity {
            VelocityInput::Deck => (input.vehicle_velocity_mps, input.deck_velocity_mps),
            VelocityInput::NegativeRelative => (
                R::ZERO,
                input.deck_velocity_mps - input.vehicle_velocity_mps,
            ),
        };
        GroundEffectInput {
            thrust_n: input.thrust_n.max(R::ZERO),
            throttle: input.throttle.clamp(R::ZERO, R::ONE),
            height_m,
            vehicle_velocity_mps,
            deck_velocity_mps,
            rotor_heights_m: input.rotor_heights_m.map(|zs| zs.map(|z| z + shift)),
        }
    }

    /// A lift of the model within the limits, for a height that is not brought within them.
    fn limited(&self, lift: Lift<R>, thrust_n: R, height_m: R) -> Lift<R> {
        let Validity {
            ratio_min,
            ratio_max,
            ..
        } = self.validity;
        let remaining = self.validity.remaining(height_m);
        let force_n = lift
            .force_n
            .clamp(ratio_min * thrust_n, ratio_max * thrust_n);
        Lift {
            ratio: (remaining * lift.ratio.clamp(ratio_min, ratio_max)).finite_or(R::ZERO),
            force_n: (remaining * force_n).finite_or(R::ZERO),
        }
    }

    fn limit_inner(&self, state: &mut M::State, inner: &GroundEffectInput<R>) {
        self.model.limit(
            state,
            inner.thrust_n,
            self.validity.ratio_min,
            self.validity.ratio_max,
        );
    }
}

impl<R: Real, M: GroundEffect<R>> GroundEffect<R> for Guarded<R, M> {
    type State = GuardedState<R, M::State>;

    fn rest(&self, input: &GroundEffectInput<R>) -> Self::State {
        let unknown = GroundEffectInput {
            height_m: self.validity.height_max_m,
            ..GroundEffectInput::default()
        };
        let input = input.or_previous(&unknown);
        let inner = self.inner(&input);
        let mut model = self.model.rest(&inner);
        self.limit_inner(&mut model, &inner);
        GuardedState { model, input }
    }

    fn lift(&self, state: &Self::State, input: &GroundEffectInput<R>) -> Lift<R> {
        let input = input.or_previous(&state.input);
        let inner = self.inner(&input);
        let lift = self.model.lift(&state.model, &inner);
        self.limited(lift, inner.thrust_n, input.height_m)
    }

    fn advance(&self, state: &mut Self::State, input: &GroundEffectInput<R>, dt: R) {
        state.input = input.or_previous(&state.input);
        let inner = self.inner(&state.input);
        self.model.advance(&mut state.model, &inner, dt);
        self.limit_inner(&mut state.model, &inner);
    }

    /// As [`advance`](GroundEffect::advance) and [`lift`](GroundEffect::lift), with the input
    /// brought within the limits once.
    fn step(&self, state: &mut Self::State, input: &GroundEffectInput<R>, dt: R) -> Lift<R> {
        state.input = input.or_previous(&state.input);
        let inner = self.inner(&state.input);
        let Validity {
            ratio_min,
            ratio_max,
            ..
        } = self.validity;
        let lift = self
            .model
            .step_within(&mut state.model, &inner, dt, ratio_min, ratio_max);
        self.limited(lift, inner.thrust_n, state.input.height_m)
    }

    fn validate(&self) -> Result<(), SettingsError> {
        self.validity.validate()?;
        self.model.validate()
    }
}
