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
mod law;
mod ssc;

pub use channel::VerticalState;
pub use composite::{Composite, CompositeState, Gains};
pub use imbc::{Imbc, ImbcState};
pub use law::{Law, LawState};
pub use ssc::{Ssc, SscState};

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
