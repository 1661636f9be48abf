//! Landings in six degrees of freedom: vehicle, deck, sensors with noise and latency, and the
//! landing computer.
//!
//! ```text
//! deck, wind ─> vehicle (1 kHz) ─> sensors ─> landing computer (100 Hz) ─> cascade (500 Hz) ─> throttles ─┐
//!                 ^                                                                                  │
//!                 └──────────────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! The landing computer is the one that flies ([`touchdown_lander::computer`]). It knows readings,
//! the vehicle's mass, the places of its sensors, their nominal latencies, and models that were
//! identified before. The camera is an error model fitted to the detector
//! ([`crate::sensors::camera::fast`]), or a renderer with a detector
//! ([`crate::sensors::camera::pipeline`]). The true state in the deck's axes decides on outcome,
//! touchdown and crash.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `scenario`, `faults`, `consistency` | settings, and checks across them |
//! | `airspeed` | the air in which a vehicle can land, and that of a scenario |
//! | `belief` | what the flight software believes of the vehicle, and how the true one differs |
//! | `case` | scenarios by name |
//! | `computer` | the landing computer of a scenario |
//! | `landing`, `flight`, `track` | a landing, its steps, the deck over its time |
//! | `trial` | random differences between trials |
//! | `outcome`, `record`, `touchdown` | the result of a landing, and how the true state decides on it |
//! | `flight_log` | the log that an autopilot would write |
//! | `motor_flight` | the world under an autopilot that is not simulated |
//! | `batch` | many landings in SIMD lanes, with ideal sensors |
//! | `policy` | learned policies, and how they fly |

mod airspeed;
mod batch;
mod belief;
mod case;
mod computer;
mod consistency;
mod faults;
mod flight;
mod flight_log;
mod landing;
mod motor_flight;
mod outcome;
mod policy;
mod record;
mod scenario;
mod touchdown;
mod track;
mod trial;
mod waits;

pub use crate::sensors::RangeRow;
pub use airspeed::{Airspeeds, THRUST_SHARE};
pub use batch::{Batch, Commanded, LaneEnd};
pub use belief::{BelievedSettings, TruthSettings, thrust_to_weight};
pub use case::Case;
pub use computer::replaced_by;
pub use faults::{
    FaultClock, FaultGust, FaultSettings, FaultySensor, NanBurst, TimeSpan, WeakRotor,
};
pub use flight::StepHook;
pub use flight_log::{FlightLog, ImuRow, TagRow};
pub use landing::{SpaceLander, land};
pub use motor_flight::{
    AutopilotReadings, DeckSighting, GnssFix, MotorFlight, MotorLanding, MotorSignals, VehicleTruth,
};
pub use outcome::{
    Abort, CrashCause, Impact, SensorRow, SpaceLanding, SpaceOutcome, SpaceTrace, Touch, TraceRow,
};
pub use policy::{
    ActionKind, ActionSettings, Activation, CommandKind, InputSettings, LayerSettings, Observation,
    Policy, PolicySettings,
};
pub use scenario::{CrashSettings, SpaceScenario};
pub use waits::Waits;
