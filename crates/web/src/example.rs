//! Logs to try the lab with. They are simulated, and say so in their names.

use std::path::Path;

use touchdown_campaign::recording;
use touchdown_campaign::sweep::{Sweep, SweepSettings, replay};
use touchdown_sim::landing::space::Case;
use touchdown_sim::rig::sets::{Extent, thrust_training};
use touchdown_sim::rig::{self, RigSettings};

use crate::request::{Error, ExampleName, Result};

/// Landings of the example of flights. From three flights on, intervals are those of whole flights.
const FLIGHTS: u64 = 4;
/// Seed of both examples.
const SEED: u64 = 1;

/// Writes the logs of an example and returns their names.
pub(crate) fn write(name: ExampleName, out: &Path) -> Result<Vec<String>> {
    let files = match name {
        ExampleName::Rig => rig_logs()?,
        ExampleName::Flights => flight_logs()?,
    };
    for (name, bytes) in &files {
        let file = out.join(name);
        std::fs::write(&file, bytes).map_err(|e| Error::Write(file, e))?;
    }
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

/// Throttle and thrust of the virtual rig, the plate removed.
fn rig_logs() -> Result<Vec<(String, Vec<u8>)>> {
    let settings = RigSettings::default();
    thrust_training(false, Extent::Quick)
        .iter()
        .map(|trial| {
            let recorded = rig::run(&settings, trial, SEED)?;
            let name = format!("simulated-rig-{}.csv", recorded.name());
            Ok((name, touchdown_log::to_csv(&recorded)))
        })
        .collect()
}

/// Landings on the paper's deck, as an autopilot logs them.
fn flight_logs() -> Result<Vec<(String, Vec<u8>)>> {
    let settings = SweepSettings {
        seed: SEED,
        trials: FLIGHTS,
        scenario: Case::Paper.scenario(),
        ..SweepSettings::default()
    };
    let sweep = Sweep::new(settings, Path::new("."), "the example".to_string())?;
    let landings: Vec<u64> = (0..FLIGHTS).collect();
    replay(&sweep, &landings)?
        .iter()
        .enumerate()
        .map(|(k, trace)| {
            let name = format!("simulated-landing-{k}.ulg");
            Ok((name, recording::ulog(trace)?))
        })
        .collect()
}
