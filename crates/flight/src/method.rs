//! The methods of landing by name, and the tuned defaults of those that fly vertically.
//!
//! | method | law | fed forward | disturbance observer |
//! | --- | --- | --- | --- |
//! | `feedback` (Method I) | composite, eq. (10) | – | – |
//! | `empirical` (Method II) | composite, eq. (10) | eq. (2) | – |
//! | `dynamic` (Method III) | composite, eq. (10) | identified model | – |
//! | `imbc` | internal model | – | – |
//! | `ssc` | smooth sliding control | – | – |
//! | `observer` | composite, eq. (10) | – | yes |
//! | `dynamic+observer` | composite, eq. (10) | identified model | yes |
//!
//! The last two need an inertial unit and fly in space only.

use core::f64::consts::PI;

use crate::control::{Composite, Gains, Imbc, Law, Ssc};
use crate::deck::HarmonicFilter;
use crate::error::SettingsError;
use crate::ground_effect::Guarded;
use crate::real::{Real, r};
use crate::reference::{Exponential, Reference};
use crate::thrust::ThrustModel;
use crate::types::Limits;
use crate::vertical_controller::VerticalController;

/// Rate C of eq. (13) at which the reference reaches 0.1 m at the published landing time on
/// the ground, 5.1 s from 0.8 m, 1/s. Twice the rate halves the landing time.
pub const C_GROUND_PER_S: f64 = 0.7073;
/// Rate C of eq. (13) at which the reference reaches 0.1 m at the published landing time on
/// the oscillating deck, 5.38 s from 0.5 m, 1/s. Twice the rate halves the landing time.
pub const C_DECK_PER_S: f64 = 0.5566;

/// A method of landing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Method {
    /// Method I: eq. (10) without feedforward.
    Feedback,
    /// Method II: eq. (10) with eq. (2) fed forward.
    Empirical,
    /// Method III: eq. (10) with the identified dynamic model fed forward.
    Dynamic,
    /// Internal-model-based control for a deck of known period, reconstructed.
    Imbc,
    /// Smooth sliding control, reconstructed.
    Ssc,
    /// Eq. (10) with a disturbance observer in place of a model.
    Observer,
    /// Method III with a disturbance observer.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "dynamic+observer"))]
    DynamicObserver,
}

/// The ground-effect model that a method feeds forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedforward {
    /// None.
    None,
    /// Eq. (2).
    Empirical,
    /// The identified model.
    Dynamic,
}

/// The laws that methods choose from, with their gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws<R: Real> {
    /// Eq. (10).
    pub composite: Composite<R>,
    /// Internal-model-based control.
    pub imbc: Imbc<R>,
    /// Smooth sliding control.
    pub ssc: Ssc<R>,
}

impl Method {
    /// All methods, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Feedback,
        Self::Empirical,
        Self::Dynamic,
        Self::Imbc,
        Self::Ssc,
        Self::Observer,
        Self::DynamicObserver,
    ];

    /// The methods that fly vertically: the paper's, and those that it compares with.
    pub const VERTICAL: [Self; 5] = [
        Self::Feedback,
        Self::Empirical,
        Self::Dynamic,
        Self::Imbc,
        Self::Ssc,
    ];

    /// The name in settings, results and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Feedback => "feedback",
            Self::Empirical => "empirical",
            Self::Dynamic => "dynamic",
            Self::Imbc => "imbc",
            Self::Ssc => "ssc",
            Self::Observer => "observer",
            Self::DynamicObserver => "dynamic+observer",
        }
    }

    /// The method's law.
    #[must_use]
    pub fn law<R: Real>(self, laws: &Laws<R>) -> Law<R> {
        match self {
            Self::Imbc => Law::Imbc(laws.imbc),
            Self::Ssc => Law::Ssc(laws.ssc),
            _ => Law::Composite(laws.composite),
        }
    }

    /// The model that the method feeds forward.
    #[must_use]
    pub fn feedforward(self) -> Feedforward {
        match self {
            Self::Empirical => Feedforward::Empirical,
            Self::Dynamic | Self::DynamicObserver => Feedforward::Dynamic,
            _ => Feedforward::None,
        }
    }

    /// Whether the method has a disturbance observer.
    #[must_use]
    pub fn has_observer(self) -> bool {
        matches!(self, Self::Observer | Self::DynamicObserver)
    }

    /// Whether the deck's estimated acceleration can be fed forward: the law of `imbc` has no
    /// such term.
    #[must_use]
    pub fn uses_deck_acceleration(self) -> bool {
        self != Self::Imbc
    }
}

/// Settings of the methods that fly vertically. Their defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize",
        deserialize = "R: Real + serde::Deserialize<'de>"
    ))
)]
pub struct VerticalSettings<R: Real> {
    /// Rate C of the descent, eq. (13), 1/s.
    pub c_per_s: R,
    /// Height h_d that the descent ends at, m.
    pub end_height_m: R,
    /// Gains of eq. (10).
    pub gains: Gains<R>,
    /// Poles of the internal model, 1/s (`imbc`, reconstructed).
    pub imbc_poles_per_s: [R; 3],
    /// Amplitude of the sliding term, N (`ssc`, reconstructed).
    pub ssc_rho_n: R,
    /// Width of the sliding term, m/s.
    pub ssc_phi_mps: R,
    /// Time constant of the smoothing filter, s.
    pub ssc_filter_s: R,
    /// Time by which the deck's motion is predicted ahead, s: latency of the sensors, delay of
    /// the command, lag of the rotors.
    pub deck_lead_s: R,
    /// Limits of the actuators.
    pub limits: Limits<R>,
}

impl<R: Real> Default for VerticalSettings<R> {
    fn default() -> Self {
        let (imbc, ssc) = (Imbc::new(r(PI)), Ssc::default());
        Self {
            c_per_s: r(C_GROUND_PER_S),
            end_height_m: R::ZERO,
            gains: Gains::default(),
            imbc_poles_per_s: imbc.poles_per_s,
            ssc_rho_n: ssc.rho_n,
            ssc_phi_mps: ssc.phi_mps,
            ssc_filter_s: ssc.filter_s,
            // 20 ms of sensing, 10 ms of command and 60 ms of the rotors.
            deck_lead_s: r(0.09),
            limits: Limits::default(),
        }
    }
}

/// A vertical landing: vehicle, start and deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalLanding<R> {
    /// Mass of the vehicle, kg.
    pub mass_kg: R,
    /// Acceleration of gravity, m/s².
    pub gravity_mps2: R,
    /// Height at which the descent begins, m.
    pub start_height_m: R,
    /// Angular frequency of the deck's heave, rad/s; none for a deck at rest.
    pub deck_angular_frequency: Option<R>,
    /// Whether the deck's acceleration is estimated and fed forward.
    pub deck_acceleration: bool,
}

impl<R: Real> VerticalSettings<R> {
    /// The laws with these gains, for a deck that heaves at `angular_frequency`.
    fn laws(&self, angular_frequency: R) -> Laws<R> {
        let Gains { k_p, gamma, .. } = self.gains;
        Laws {
            composite: Composite { gains: self.gains },
            imbc: Imbc {
                k_p,
                gamma,
                angular_frequency,
                poles_per_s: self.imbc_poles_per_s,
            },
            ssc: Ssc {
                k_p,
                gamma,
                rho_n: self.ssc_rho_n,
                phi_mps: self.ssc_phi_mps,
                filter_s: self.ssc_filter_s,
            },
        }
    }

    /// The controller of a method with its [feedforward model](Method::feedforward).
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn controller(
        &self,
        method: Method,
        landing: &VerticalLanding<R>,
        thrust: ThrustModel<R>,
        ground_effect: Guarded<R>,
    ) -> Result<VerticalController<R>, SettingsError> {
        // Over a deck at rest the internal model still needs a frequency: half a hertz, the
        // paper's deck.
        let heave = landing.deck_angular_frequency.unwrap_or(r(PI));
        let filters = landing.deck_acceleration && method.uses_deck_acceleration();
        let controller = VerticalController {
            mass_kg: landing.mass_kg,
            gravity_mps2: landing.gravity_mps2,
            law: method.law(&self.laws(heave)),
            reference: Reference::Exponential(Exponential {
                c_per_s: self.c_per_s,
                start_height_m: landing.start_height_m,
                end_height_m: self.end_height_m,
            }),
            thrust,
            ground_effect,
            deck: landing
                .deck_angular_frequency
                .filter(|_| filters)
                .map(|w| HarmonicFilter {
                    lead_s: self.deck_lead_s,
                    ..HarmonicFilter::new(w)
                }),
            limits: self.limits,
        };
        controller.validate()?;
        Ok(controller)
    }
}
