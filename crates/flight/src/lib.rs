//! Thrust and ground-effect models, references, control laws and a vertical controller
//! for multirotors that land on ground or on decks that move: for a flight computer.
//!
//! The landing computer, which flies in space, is `touchdown-lander`.
//!
//! `no_std`, no allocation, no clock, no output. Everything is generic over
//! `f32` and `f64` ([`Real`]). Models are immutable, `Copy` coefficients; states
//! are explicit and `Copy`; `step(&self, &mut state, input, dt)` advances a state
//! over `dt` seconds. Settings are checked once, by `validate`.
//!
//! z is up; z = height of the vehicle above the deck, `v = dz/dt = v_q - v_p`;
//! throttle σ lies in [0, 1]; SI units.
//!
//! Equation numbers, "eq. (10)", are those of *Data-Driven Modeling of Ground Effect For UAV
//! Landing on a Vertical Oscillating Platform*. A kernel without one is this project's own, or
//! names its source.
//!
//! | equation | what it is | where |
//! | --- | --- | --- |
//! | eq. (1) | vertical motion of the vehicle, `m v_q' = T + f - m g` | the controllers invert it |
//! | eq. (2) | empirical ground effect | [`ground_effect::Empirical`] |
//! | eq. (7) | thrust, first-order lag | [`thrust::FirstOrder`] |
//! | eq. (8), eq. (11) | thrust, sparse library; its printed coefficients | [`thrust::Library`] |
//! | eq. (9), eq. (12) | ground effect, derivative form; its printed coefficients | [`ground_effect::Polynomial`] |
//! | eq. (10) | composite law | [`control::Composite`] |
//! | eq. (13) | exponential descent | [`reference::Exponential`] |
//! | Section IV-D | T_L, V_L, S_L | [`metrics`] |
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`thrust`] | throttle to free-air thrust, and back |
//! | [`ground_effect`] | ground effect above a deck that may move |
//! | [`mod@reference`] | descents |
//! | [`deck`] | estimate of the deck's heave, of known frequency |
//! | [`control`] | vertical control laws |
//! | [`vertical_controller`] | all of these: measurement in, command out |
//! | [`method`] | the methods of landing by name, with their tuned defaults |
//! | [`touchdown`], [`metrics`] | touchdown and the figures of a landing |
//! | [`touch`] | landed, landed hard or crashed, by the speed of the touch |
//! | [`space`] | vectors and attitudes in space |
//! | [`kernel`] | lags, sums, delays, and the root of a cubic |
//! | [`types`], [`error`], [`real`] | measurements and commands, refused settings, scalars |
//!
//! ```
//! use touchdown_flight::vertical_controller::VerticalController;
//! use touchdown_flight::control::{Composite, Law};
//! use touchdown_flight::ground_effect::{Empirical, GroundEffectModel, Guarded, Validity};
//! use touchdown_flight::reference::{Exponential, Reference};
//! use touchdown_flight::thrust::ThrustModel;
//! use touchdown_flight::{Limits, Measurement};
//!
//! let controller = VerticalController::<f32> {
//!     mass_kg: 1.37,
//!     gravity_mps2: 9.81,
//!     law: Law::Composite(Composite::default()),
//!     reference: Reference::Exponential(Exponential {
//!         c_per_s: 0.7073,
//!         start_height_m: 0.8,
//!         end_height_m: 0.0,
//!     }),
//!     thrust: ThrustModel::published(),
//!     ground_effect: Guarded::new(
//!         GroundEffectModel::Empirical(Empirical {
//!             mu: 1.9,
//!             rotor_radius_m: 0.12,
//!             rotor_offset_m: 0.0,
//!         }),
//!         Validity::default(),
//!     ),
//!     deck: None,
//!     limits: Limits::default(),
//! };
//! controller.validate()?;
//!
//! let hover = controller.thrust.throttle_for(1.37 * 9.81);
//! let measurement = Measurement { height_m: 0.8, ..Measurement::default() };
//! let mut state = controller.initial(&measurement, hover);
//! let command = controller.step(&mut state, &measurement, 0.01);
//! assert!((0.05..=1.0).contains(&command.throttle));
//! # Ok::<(), touchdown_flight::SettingsError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod control;
pub mod deck;
pub mod error;
pub mod ground_effect;
pub mod kernel;
pub mod method;
pub mod metrics;
pub mod real;
pub mod reference;
pub mod space;
pub mod thrust;
pub mod touch;
pub mod touchdown;
pub mod types;
pub mod vertical_controller;

pub use error::SettingsError;
pub use method::Method;
pub use real::Real;
pub use space::{Attitude, Vector};
pub use types::{Command, Limits, Measurement};
