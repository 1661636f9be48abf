//! Whole landings in six degrees of freedom: the true vehicle over a true deck,
//! sensors that are late and wrong, and the flight crate's landing computer.
//!
//! ```text
//! deck, wind ─> vehicle (1 kHz) ─> sensors ─> landing computer (100 Hz) ─> cascade (500 Hz) ─> throttles ─┐
//!                 ^                                                                                  │
//!                 └──────────────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! The computer is the one that flies ([`touchdown_lander::computer`]); it knows of the
//! world what the sensors say, the vehicle's mass, mounting places and nominal
//! delays, and models that were identified before. The camera is the fast one, whose
//! errors were fitted to the detector ([`crate::sensors::camera::fast`]), or a renderer and a detector
//! that are plugged in ([`crate::sensors::camera::pipeline`]). Outcome, touchdown and crash
//! are judged by the true state in the deck's frame.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `sensors`, `tags`, `faults`, `computer`, `scenario`, `fits` | settings, and whether they fit each other |
//! | `case` | scenarios by name |
//! | `landing`, `flight`, `track` | a landing, its steps, its deck |
//! | `drawn` | in what trials differ |
//! | `outcome`, `account`, `touching` | what is said of it |
//! | `logged` | what an autopilot would log of it |
//! | `batch` | many landings side by side, with ideal sensors |

mod account;
mod batch;
mod case;
mod computer;
mod drawn;
mod faults;
mod fits;
mod flight;
mod landing;
mod logged;
mod outcome;
mod scenario;
mod touching;
mod track;

pub use crate::sensors::RangeRow;
pub use batch::Batch;
pub use case::Case;
pub use faults::{FaultGust, FaultSettings, NanBurst, Since, Span, Struck, WeakRotor};
pub use landing::{SpaceLander, land};
pub use logged::{FlightLog, ImuRow};
pub use outcome::{
    Abort, CrashCause, Impact, SpaceLanding, SpaceOutcome, SpaceTrace, Touch, TraceRow,
};
pub use scenario::{CrashSettings, SpaceScenario};
