//! The landing lab's calculations, behind one function: [`answer`] takes a request as JSON and returns an answer as JSON.
//!
//! ```text
//! page ──request, files──> worker ──standard input, folder──> answer ──standard output──> worker ──> page
//! ```
//!
//! A request names files by their paths. In a browser these are the files that a person has dropped: the worker's file system
//! reads slices of them, so that a log is never in memory as a whole unless a reader holds it. Nothing stays between two
//! requests, so a log that stops one of them harms no other.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`request`] | requests, and what an answer is when it is an error |
//! | `inspect` | what is in a log, the map that fits or a map to start from, and its channels |
//! | `identify` | thrust and ground effect as model cards, with curves and residuals |
//! | `logs` | the logs of an identification, with its settings |
//! | `land` | landings of a scenario: rows of a campaign, and the frames of one landing |
//! | `example` | logs of the virtual rig and of simulated flights |
//! | `plot` | curves and points, few enough for a screen |

mod example;
mod identify;
mod inspect;
mod land;
mod logs;
mod plot;
pub mod request;

use request::{Error, Request};
use serde::Serialize;
use serde_json::{Value, json};

/// Takes what a calculation is doing, in words for people, each time that it begins something else.
pub type Stages<'a> = &'a (dyn Fn(&str) + Sync);

/// The answer to a request: `{"result": …}`, or `{"error": "…"}` with a sentence for people. Identifications pass their stages on.
#[must_use]
pub fn answer(request: &str, stages: Stages<'_>) -> String {
    let result = serde_json::from_str(request)
        .map_err(|e| Error::Request(e.to_string()))
        .and_then(|request| calculate(&request, stages));
    let answer = match result {
        Ok(result) => json!({ "result": result }),
        Err(error) => json!({ "error": error.to_string() }),
    };
    answer.to_string()
}

fn calculate(request: &Request, stages: Stages<'_>) -> Result<Value, Error> {
    match request {
        Request::Inspect { log, map } => value(&inspect::inspect(log, map.as_deref())?),
        Request::IdentifyThrust(data) => value(&identify::thrust(data, stages)?),
        Request::IdentifyGroundEffect { data, thrust } => {
            value(&identify::ground_effect(data, thrust.as_deref(), stages)?)
        }
        Request::Land { sweep, landing } => value(&land::one(sweep, *landing)?),
        Request::Landings { sweep, from, to } => value(&land::rows(sweep, *from..*to)?),
        Request::Record {
            sweep,
            landing,
            out,
        } => value(&land::record(sweep, *landing, out)?),
        Request::Card { card } => value(&touchdown_model::Card::read(card)?),
        Request::Example { name, out } => value(&example::write(*name, out)?),
    }
}

fn value<T: Serialize>(of: &T) -> Result<Value, Error> {
    serde_json::to_value(of).map_err(|e| Error::Request(e.to_string()))
}
