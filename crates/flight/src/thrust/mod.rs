//! Free-air thrust of the rotors from throttle: eq. (7), eq. (8), a static map with a lag, and a cubic of
//! lagged throttle.
//!
//! The state is `x = √T` (T in N); throttle is σ (`s`) in [0, 1].

mod first_order;
mod lagged_throttle;
mod library;
mod library_of_rotors;
mod lift;
mod static_map;

pub use first_order::FirstOrder;
pub use lagged_throttle::LaggedThrottle;
pub use library::Library;
pub use library_of_rotors::LibraryOfRotors;
pub use lift::{LEAST_THRUST_TO_WEIGHT, THRUST_ERROR};
pub use static_map::StaticThrust;

use crate::error::SettingsError;
use crate::kernel::usable_dt;
use crate::real::{Real, r};

/// Least `√T` that a state takes, √N: keeps clear of the unstable branch that
/// fitted models can have near zero thrust.
pub const ROOT_THRUST_MIN: f64 = 0.3;

/// Greatest `√T` that a state takes, √N (900 N).
pub const ROOT_THRUST_MAX: f64 = 30.0;

/// State of a thrust model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustState<R> {
    /// `√T`, √N.
    pub x: R,
}

impl<R: Real> ThrustState<R> {
    /// The thrust `T = x²`, N.
    pub fn thrust_n(&self) -> R {
        self.x * self.x
    }
}

/// A thrust model: throttle to free-air thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ThrustModel<R> {
    /// Eq. (7): first-order lag to a line in throttle.
    FirstOrder(FirstOrder<R>),
    /// Eq. (8): sparse library of eight terms.
    Library(Library<R>),
    /// Cubic static map with a first-order lag.
    Static(StaticThrust<R>),
    /// Cubic of lagged throttle for the thrust itself.
    LaggedThrottle(LaggedThrottle<R>),
    /// Eq. (8) of other than all rotors.
    LibraryOfRotors(LibraryOfRotors<R>),
}

impl<R: Real> ThrustModel<R> {
    /// Eq. (11): the eight-term model with the published coefficients.
    #[must_use]
    pub fn published() -> Self {
        Self::Library(Library::published())
    }

    /// The model of a vehicle with `factor` times as many of the same rotors: as much more thrust at the same throttle.
    #[must_use]
    pub fn of_rotors(self, factor: R) -> Self {
        if factor == R::ONE {
            return self;
        }
        let root = factor.sqrt();
        match self {
            Self::FirstOrder(model) => Self::FirstOrder(FirstOrder {
                c0: root * model.c0,
                c1: root * model.c1,
                ..model
            }),
            Self::Static(model) => Self::Static(StaticThrust {
                coefficients: model.coefficients.map(|c| root * c),
                ..model
            }),
            Self::LaggedThrottle(model) => Self::LaggedThrottle(LaggedThrottle {
                coefficients: model.coefficients.map(|c| factor * c),
                ..model
            }),
            Self::Library(library) => Self::LibraryOfRotors(LibraryOfRotors {
                library,
                root_factor: root,
            }),
            Self::LibraryOfRotors(model) => Self::LibraryOfRotors(LibraryOfRotors {
                root_factor: root * model.root_factor,
                ..model
            }),
        }
    }

    /// Checks the coefficients.
    ///
    /// # Errors
    /// Every coefficient must be finite and time constants positive.
    pub fn validate(&self) -> Result<(), SettingsError> {
        match self {
            Self::FirstOrder(model) => model.validate(),
            Self::Library(model) => model.validate(),
            Self::Static(model) => model.validate(),
            Self::LaggedThrottle(model) => model.validate(),
            Self::LibraryOfRotors(model) => model.validate(),
        }
    }

    /// `dx/dt` at state `x` (√N) and throttle `s`, √N/s; not limited.
    pub fn derivative(&self, x: R, s: R) -> R {
        match self {
            Self::FirstOrder(model) => model.derivative(x, s),
            Self::Library(model) => model.derivative(x, s),
            Self::Static(model) => model.derivative(x, s),
            Self::LaggedThrottle(model) => model.derivative(x, s),
            Self::LibraryOfRotors(model) => model.derivative(x, s),
        }
    }

    /// Advances the state over `dt` seconds at constant throttle.
    ///
    /// The linear families take an exact exponential step; the library takes
    /// fourth-order Runge-Kutta steps of at most 20 ms. `s` is limited to
    /// [0, 1] and `x` to [[`ROOT_THRUST_MIN`], [`ROOT_THRUST_MAX`]]. A throttle
    /// or `dt` that is not finite, or a negative `dt`, leaves the state as it is.
    pub fn step(&self, state: &mut ThrustState<R>, s: R, dt: R) {
        let dt = usable_dt(dt);
        if !s.is_finite() || dt == R::ZERO {
            return;
        }
        let s = s.clamp(R::ZERO, R::ONE);
        let x = match self {
            Self::FirstOrder(model) => model.step(state.x, s, dt),
            Self::Library(model) => model.step(state.x, s, dt),
            Self::Static(model) => model.step(state.x, s, dt),
            Self::LaggedThrottle(model) => model.step(state.x, s, dt),
            Self::LibraryOfRotors(model) => model.step(state.x, s, dt),
        };
        state.x = limit(x.finite_or(state.x));
    }

    /// The state at rest (stable branch) for a throttle, √N, within the limits
    /// that [`ThrustModel::step`] keeps.
    pub fn rest(&self, s: R) -> R {
        let s = s.finite_or(R::ZERO).clamp(R::ZERO, R::ONE);
        limit(match self {
            Self::FirstOrder(model) => model.rest(s),
            Self::Library(model) => model.rest(s),
            Self::Static(model) => model.rest(s),
            Self::LaggedThrottle(model) => model.rest(s),
            Self::LibraryOfRotors(model) => model.rest(s),
        })
    }

    /// The least throttle in [0, 1] whose thrust at rest is `thrust_n`; where
    /// no throttle gives so much, the one that gives most. A thrust below zero
    /// or not a number counts as zero.
    pub fn throttle_for(&self, thrust_n: R) -> R {
        self.throttle_near(thrust_n, r(0.5))
    }

    /// [`Self::throttle_for`], found the sooner the nearer it is to `near`.
    pub(crate) fn throttle_near(&self, thrust_n: R, near: R) -> R {
        let x = limit(thrust_n.max(R::ZERO).sqrt());
        match self {
            Self::FirstOrder(model) => model.throttle_for(x, near),
            Self::Library(model) => model.throttle_for(x, near),
            Self::Static(model) => model.throttle_for(x, near),
            Self::LaggedThrottle(model) => model.throttle_for(x, near),
            Self::LibraryOfRotors(model) => model.throttle_for(x, near),
        }
    }
}

/// `x` within the limits of a state.
fn limit<R: Real>(x: R) -> R {
    x.clamp(r(ROOT_THRUST_MIN), r(ROOT_THRUST_MAX))
}
