//! The trial: time, named channels with units, gaps and provenance.
//!
//! A [`Trial`] is what every stage hands to the next: a virtual force rig, a load cell's CSV and a
//! flight log all become the same value. It is one table, column by column:
//!
//! * `time_s`, strictly increasing and finite, in seconds;
//! * named channels of the same length, in SI units told by the end of the name ([`unit_of`]); a
//!   value is finite, or NaN where the source has a gap;
//! * a name and a [`Provenance`]: which file or which virtual rig it came from, and what was done
//!   to it since.
//!
//! The crate touches no files and no clock.
//!
//! ```
//! use touchdown_trial::{Trial, Unit, unit_of};
//!
//! let trial = Trial::new("hover", vec![0.0, 0.01, 0.02])?
//!     .with_channel("throttle", vec![0.5, 0.5, 0.6])?
//!     .with_channel("thrust_n", vec![5.0, f64::NAN, 5.4])?;
//! assert_eq!(trial.require("throttle")?[2], 0.6);
//! assert_eq!(unit_of("thrust_n"), Unit::Newton);
//! assert!((trial.period_s().unwrap() - 0.01).abs() < 1e-12);
//! assert!(trial.require("height_m").is_err());
//! # Ok::<(), touchdown_trial::TrialError>(())
//! ```

mod error;
mod provenance;
mod resample;
mod trial;
mod unit;

pub use error::TrialError;
pub use provenance::{Provenance, Source};
pub use trial::{TIME_CHANNEL, Trial};
pub use unit::{Unit, unit_of};
