//! The landings of a campaign with an autopilot in the loop.

use std::path::{Path, PathBuf};

use touchdown::settings::parse;
use touchdown::{Error, Result};
use touchdown_campaign::sweep::{
    AutopilotProgram, CompanionSource, LandingBackend, LandingRow, LoopSettings, Sweep,
};
use touchdown_link::LinkError;
use touchdown_link::settings::FlightSettings;

use super::{Autopilots, Failure, Flown, Lands, LoopConfiguration, land, launch};
use crate::cli::context::Context;
use crate::cli::output;

/// Folder of the truth and the recordings of landings, in a campaign's folder.
const RECORDS: &str = "records";
/// Folder of what failed autopilots printed last.
const FAILURES: &str = "failures";

/// Flies landings under an autopilot, as many at a time as there are threads.
pub(crate) struct AutopilotBackend<'a> {
    context: &'a Context,
    autopilots: Autopilots,
    autopilot: AutopilotProgram,
    settings: &'a LoopSettings,
    parameters: Vec<(String, f64)>,
    /// Settings of the companion, but for its landing computer, which is the scenario's.
    companion: Option<FlightSettings>,
    out: PathBuf,
}

impl<'a> AutopilotBackend<'a> {
    /// The backend of a sweep with an autopilot in the loop; none for others. Records and failures go to the folder `out`.
    pub(crate) fn of(context: &'a Context, sweep: &'a Sweep, out: &Path) -> Result<Option<Self>> {
        let settings = sweep.settings();
        let (Some(autopilot), Some(of_loop)) = (settings.autopilot, &settings.software_in_the_loop)
        else {
            return Ok(None);
        };
        launch::absolute(&of_loop.program)?;
        let backend = Self {
            context,
            autopilots: Autopilots::default(),
            autopilot,
            settings: of_loop,
            parameters: of_loop.parameters.clone().into_iter().collect(),
            companion: companion(of_loop)?,
            out: out.to_owned(),
        };
        if of_loop.record {
            output::folder(&backend.out.join(RECORDS))?;
        }
        Ok(Some(backend))
    }

    /// The autopilots that run. Ctrl-C ends them.
    pub(crate) fn autopilots(&self) -> Autopilots {
        self.autopilots.clone()
    }

    /// The file of a landing in a folder of the campaign.
    fn file(&self, folder: &str, landing: u64, ending: &str) -> PathBuf {
        let name = format!("landing-{landing:06}.{ending}");
        self.out.join(folder).join(name)
    }

    /// Writes the truth if it is to be kept; returns the row.
    fn judged(&self, landing: u64, flown: Flown) -> Result<LandingRow> {
        if self.settings.record {
            flown.truth.write(&self.file(RECORDS, landing, "parquet"))?;
        }
        Ok(LandingRow::of(landing, &flown.landing.landing))
    }

    /// Keeps what is known of an autopilot that failed.
    fn keep(&self, landing: u64, error: &Error) -> Result<()> {
        output::folder(&self.out.join(FAILURES))?;
        let path = self.file(FAILURES, landing, "txt");
        output::write(&path, format!("{error}\n").as_bytes())?;
        let shown = format!(
            "landing {landing}: the autopilot failed: {}",
            path.display()
        );
        self.context.warn(&shown);
        Ok(())
    }
}

/// The companion's settings, checked.
fn companion(settings: &LoopSettings) -> Result<Option<FlightSettings>> {
    let Some(CompanionSource::Table(table)) = &settings.companion else {
        return Ok(None);
    };
    let flight: FlightSettings = parse(&table.to_string(), "software_in_the_loop.companion")?;
    flight.computer().map_err(LinkError::from)?;
    Ok(Some(flight))
}

impl LandingBackend for AutopilotBackend<'_> {
    type Error = Error;

    fn land(&self, sweep: &Sweep, landing: u64) -> Result<LandingRow> {
        let configuration = LoopConfiguration {
            autopilot: self.autopilot,
            program: Some(&self.settings.program),
            instance: 0,
            parameters: &self.parameters,
            speed: self.settings.speed,
            keep: false,
            frames: None,
            verbose: false,
        };
        let flight = match &self.companion {
            None => None,
            Some(companion) => {
                let lander = sweep.lander(landing)?;
                Some(FlightSettings {
                    control: lander.scenario().control.clone(),
                    models: lander.scenario().models,
                    ..companion.clone()
                })
            }
        };
        let lands = match &flight {
            None => Lands::AutopilotMode,
            Some(flight) => {
                let recording = self.settings.record;
                let recording = recording.then(|| self.file(RECORDS, landing, "mcap"));
                Lands::Companion(flight, recording)
            }
        };
        match land(
            self.context,
            &self.autopilots,
            &configuration,
            lands,
            sweep,
            landing,
        ) {
            Ok(flown) => self.judged(landing, flown),
            Err(Failure::NotFlown(cause)) => Ok(LandingRow::not_flown(landing, cause.name())),
            Err(Failure::Autopilot {
                cause,
                flying,
                error,
            }) => {
                self.keep(landing, &error)?;
                Ok(match flying {
                    true => LandingRow::autopilot_failed(landing, cause.name()),
                    false => LandingRow::not_flown(landing, cause.name()),
                })
            }
            Err(Failure::Command(error)) => Err(error),
        }
    }
}
