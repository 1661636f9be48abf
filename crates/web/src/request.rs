//! Requests, and why one has no result.

use std::path::PathBuf;

use serde::Deserialize;
use thiserror::Error;
use touchdown_identify::settings::VehicleSettings;

/// What the page asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "task", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// What is in a log.
    Inspect {
        /// The log.
        log: PathBuf,
        /// A map's text; without it, the built-in map that fits.
        map: Option<String>,
    },
    /// The thrust card of logs.
    IdentifyThrust(Data),
    /// The ground effect of logs of flights, or of a force rig.
    IdentifyGroundEffect {
        /// Logs, map and settings.
        data: Data,
        /// The card of the thrust out of ground effect, which logs of a force rig need.
        thrust: Option<String>,
    },
    /// One landing with its frames.
    Land {
        /// The file of the scenario, as `touchdown campaign` reads it. Cards stand beside it.
        sweep: PathBuf,
        /// Which landing.
        landing: u64,
    },
    /// Landings as rows, without frames.
    Landings {
        /// The file of the scenario.
        sweep: PathBuf,
        /// The first landing.
        from: u64,
        /// The one after the last.
        to: u64,
    },
    /// A landing as an MCAP file.
    Record {
        /// The file of the scenario.
        sweep: PathBuf,
        /// Which landing.
        landing: u64,
        /// The folder of the file.
        out: PathBuf,
    },
    /// What a file of a model card says of itself.
    Card {
        /// The file.
        card: PathBuf,
    },
    /// Logs to try the lab with, made by the simulator.
    Example {
        /// Which.
        name: ExampleName,
        /// Their folder.
        out: PathBuf,
    },
}

/// What an identification is of.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Data {
    /// The logs.
    pub logs: Vec<PathBuf>,
    /// The text of the map of all logs; without it, the built-in map that fits, or none.
    #[serde(default)]
    pub map: Option<String>,
    /// Settings of `touchdown identify` as TOML; keys that are absent have their defaults.
    #[serde(default)]
    pub settings: String,
    /// What the page's fields state of the vehicle.
    #[serde(default)]
    pub vehicle: VehicleSettings,
}

/// Logs to try the lab with.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExampleName {
    /// Throttle and thrust of the virtual rig.
    Rig,
    /// Simulated landings as an autopilot logs them.
    Flights,
}

/// Why a request has no result.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// A log that cannot be read or mapped.
    #[error(transparent)]
    Log(#[from] touchdown_log::LogError),
    /// A trial that lacks a channel.
    #[error(transparent)]
    Trial(#[from] touchdown_trial::TrialError),
    /// A fit that cannot be made.
    #[error("{}", of_fields(.0))]
    Identification(#[from] touchdown_identify::Error),
    /// A card that cannot be read.
    #[error(transparent)]
    Card(#[from] touchdown_model::CardError),
    /// Landings that cannot be flown.
    #[error(transparent)]
    Campaign(#[from] touchdown_campaign::Error),
    /// A simulation whose settings make no sense.
    #[error(transparent)]
    Simulation(#[from] touchdown_sim::SimError),
    /// A report that cannot be made.
    #[error(transparent)]
    Page(#[from] touchdown_pages::Error),
    /// A file that cannot be written.
    #[error("{0}: {1}")]
    Write(PathBuf, std::io::Error),
    /// A request that is none.
    #[error("the request is not understood: {0}")]
    Request(String),
    /// Data that do not fit what was asked.
    #[error("{0}")]
    Data(String),
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a fit cannot be made, in the page's words: it has fields for what the command takes from files.
fn of_fields(error: &touchdown_identify::Error) -> String {
    use touchdown_identify::{Error, VehicleNumber};
    match error {
        Error::Unstated(VehicleNumber::Mass) => {
            "thrust from flight needs the mass: expected a number in the field Mass (kg), or `mass_kg` in the table [vehicle] of \
             the map; found neither"
        }
        Error::Unstated(VehicleNumber::RotorRadius) => {
            "the ground effect scales with the rotor radius: expected a number in the field Rotor radius (m), or \
             `rotor_radius_m` in the table [vehicle] of the map; found neither"
        }
        other => return other.to_string(),
    }
    .to_string()
}
