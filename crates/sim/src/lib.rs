//! The truth: rotors, air, deck, force rig, sensors and landings.
//!
//! This crate is the world that identification and control are tried in. It
//! contains no model that is fitted anywhere else: [`plant`] is a wake model
//! with image rotors, a fountain, a finite plate and two lags ([`ground`]), or
//! a second and different plant with an exponential law and one lag
//! ([`exponential`]). Both run through the same virtual force rig ([`rig`])
//! and the same landings ([`landing`]).
//!
//! * z is up; the height z is that of the vehicle's reference point above the
//!   deck, `z = z_q - z_p`, and `v = v_q - v_p`. SI units; throttle in [0, 1].
//! * Every run is a pure function of its settings, the seed and, for landings,
//!   the trial's index: the same bits for any order and any number of threads.
//! * Integration is classical Runge–Kutta of order four with a fixed step of
//!   [`STEP_S`]; turbulence is an exactly discretised Ornstein–Uhlenbeck process.
//!
//! ```
//! use touchdown_sim::rig::{RigSettings, run};
//! use touchdown_sim::rig_sets::{Extent, ground_effect_paper};
//!
//! let settings = RigSettings::default();
//! let trial = &ground_effect_paper(Extent::Quick)[0];
//! let recorded = run(&settings, trial, 1)?;
//! assert!(recorded.require("thrust_n")?.len() > 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
pub mod deck;
pub mod error;
pub mod exponential;
pub mod ground;
pub mod landing;
pub mod motor;
pub mod noise;
pub mod plant;
pub mod profile;
pub mod rig;
pub mod rig_sets;
mod rk4;
pub mod scenario;
pub mod sensor;
pub mod vehicle;

pub use error::SimError;

/// Step of the integration, s.
pub const STEP_S: f64 = 0.001;
