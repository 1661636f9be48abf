//! `touchdown simulator`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::csv::line;
use touchdown_campaign::sweep::{AutopilotProgram, LandingRow, SWEEP, Sweep, SweepSettings};
use touchdown_flight::Method;
use touchdown_link::companion::Summary;
use touchdown_link::settings::FlightSettings;
use touchdown_sim::sensors::CameraMode;
use touchdown_terminal::Done;

use super::args::simulator::{SimulatedCamera, SimulatorArgs};
use super::context::Context;
use super::software_in_the_loop::{Autopilots, Failure, Flown, Lands, LoopConfiguration, land};
use super::{fly, output};

/// Share by which the mass of a scenario's vehicle may differ from that of the companion's settings: a payload that one
/// forgets, not another size.
const SAME_MASS: f64 = 0.2;

/// Results of a landing.
#[derive(Serialize)]
struct LandingResult {
    trial: u64,
    outcome: String,
    why: Option<String>,
    t_l_s: Option<f64>,
    v_l_mps: Option<f64>,
    impact_mps: Option<f64>,
    descents: u64,
    /// Time from the touch to the motors' stop, s.
    stopped_after_s: Option<f64>,
    /// Simulated seconds in a second.
    speed: Option<f64>,
    missed_answers: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    companion: Option<Summary>,
}

/// What `touchdown simulator` writes as `results.json`.
#[derive(Serialize)]
struct Results {
    autopilot: &'static str,
    /// The autopilot's threads run as the machine lets them.
    reproducible_to_the_bit: bool,
    seed: u64,
    landings: Vec<LandingResult>,
}

pub(crate) fn run(context: &Context, args: &SimulatorArgs) -> Result<Done> {
    if !(args.speed >= 0.0 && args.speed <= 1000.0) {
        return Err(Error::Arguments(format!(
            "--speed: expected 0 to 1000, found {}",
            args.speed
        )));
    }
    if args.autopilot.is_some() && args.with.is_none() && !args.own_landing {
        return Err(Error::Arguments(
            "--autopilot: expected --with FLY.toml or --own-landing, found neither: nobody would land the vehicle".to_string(),
        ));
    }
    let sweep = load(args)?;
    let flight = args.with.as_deref().map(fly::load).transpose()?;
    let flight = flight.map(|loaded| loaded.settings);
    let flight = match (&args.controller, flight) {
        (Some(name), Some(mut flight)) => {
            flight.control.method = method(name)?;
            Some(flight)
        }
        (_, flight) => flight,
    };
    let named = args.with.iter().map(|with| ("settings", with));
    for (what, input) in std::iter::once(("scenario", &args.scenario)).chain(named) {
        output::replaces_not(&args.out.join(SWEEP), what, input)?;
    }
    let other = flight.as_ref().map(|flight| other_vehicle(&sweep, flight));
    if let Some(text) = other.transpose()?.flatten() {
        context.warn(&text);
    }
    output::results_folder(context, &args.out)?;
    let autopilots = Autopilots::default();
    let ended = Arc::new(AtomicU64::new(0));
    let (out, stopped, so_far) = (args.out.clone(), autopilots.clone(), Arc::clone(&ended));
    context.if_interrupted(move || {
        stopped.interrupt();
        interrupted(&out, so_far.load(Ordering::Relaxed))
    });
    let mut table = String::new();
    line(
        &mut table,
        ["trial"]
            .into_iter()
            .chain(LandingRow::header())
            .chain(["stopped_after_s"]),
    );
    let mut landings = Vec::new();
    for trial in 0..sweep.landings() {
        let (row, result) = fly_trial(context, args, &autopilots, &sweep, flight.as_ref(), trial)?;
        context.say(&result.text());
        let stopped_after = result.stopped_after_s;
        let stopped_after = stopped_after.map_or_else(String::new, |s| s.to_string());
        let cells = [trial.to_string()].into_iter().chain(row.cells());
        line(&mut table, cells.chain([stopped_after]));
        output::write(&args.out.join("landings.csv"), table.as_bytes())?;
        landings.push(result);
        ended.store(trial + 1, Ordering::Relaxed);
    }
    let results = Results {
        autopilot: AutopilotProgram::from(args.autopilot_kind).name(),
        reproducible_to_the_bit: false,
        seed: sweep.settings().seed,
        landings,
    };
    output::write(
        &args.out.join(SWEEP),
        settings::to_toml(sweep.settings())?.as_bytes(),
    )?;
    output::results(&args.out, &results)?;
    context.object(&results);
    Ok(Done::Whole)
}

/// Which files an interrupted command leaves after that many landings.
fn interrupted(out: &Path, ended: u64) -> String {
    let folder = out.display();
    let files = match ended {
        0 => format!("no landing has ended, and {folder} has no results"),
        1 => format!("{folder} has the files of one landing that ended; results.json is missing"),
        _ => format!(
            "{folder} has the files of {ended} landings that ended; results.json is missing"
        ),
    };
    let recording = file(out, "flight", ended, "mcap");
    if recording.exists() {
        format!(
            "{files}; the recording {} ends where it was stopped",
            recording.display()
        )
    } else {
        files
    }
}

fn load(args: &SimulatorArgs) -> Result<Sweep> {
    let path = &args.scenario;
    let mut settings = SweepSettings::read(path)?;
    for (key, found) in [
        ("grid", !settings.grid.is_empty()),
        ("autopilot", settings.autopilot.is_some()),
    ] {
        if found {
            return Err(Error::Settings {
                file: path.display().to_string(),
                message: format!(
                    "`{key}`: expected none, found some; `touchdown campaign` flies it"
                ),
            });
        }
    }
    settings.trials = args.trials;
    let sensors = &mut settings.scenario.sensors;
    sensors.camera = match args.camera {
        Some(SimulatedCamera::Fast) => CameraMode::Fast,
        Some(SimulatedCamera::Rendered) => CameraMode::Rendered,
        None if args.frames.is_some() => CameraMode::Rendered,
        None => sensors.camera,
    };
    if args.frames.is_some() && sensors.camera == CameraMode::Fast {
        return Err(Error::Arguments(
            "--frames: expected `--camera rendered`, found a camera without images".to_string(),
        ));
    }
    settings.seed = args.seed.unwrap_or(settings.seed);
    let folder = path.parent().unwrap_or(Path::new("."));
    let sweep = Sweep::new(settings, folder, path.display().to_string())?;
    sweep.check_in_the_loop()?;
    Ok(sweep)
}

/// What is wrong with a companion whose vehicle is not that of the scenario.
fn other_vehicle(sweep: &Sweep, flight: &FlightSettings) -> Result<Option<String>> {
    let (flown, stated) = (sweep.scenario(0)?.plant.mass_kg, flight.vehicle.mass_kg);
    let other = (flown / stated - 1.0).abs() > SAME_MASS;
    Ok(other.then(|| {
        format!(
            "the companion's settings are of a vehicle of {stated} kg (`vehicle.mass_kg`), and the scenario's has {flown} kg: the limits and times of \
             its `control` follow the vehicle's size, see \"Vehicles\" in the documentation"
        )
    }))
}

fn method(name: &str) -> Result<Method> {
    let found = Method::ALL.into_iter().find(|method| method.name() == name);
    found.ok_or_else(|| Error::Arguments(format!("--controller: `{name}` is none")))
}

/// Flies a trial. A vehicle that does not come to hold above the deck is a result; an autopilot that fails is an error.
fn fly_trial(
    context: &Context,
    args: &SimulatorArgs,
    autopilots: &Autopilots,
    sweep: &Sweep,
    flight: Option<&FlightSettings>,
    trial: u64,
) -> Result<(LandingRow, LandingResult)> {
    let lands = match flight {
        Some(flight) => Lands::Companion(flight, Some(file(&args.out, "flight", trial, "mcap"))),
        None if args.own_landing => Lands::AutopilotMode,
        None => Lands::GroundStation,
    };
    let settings = LoopConfiguration {
        autopilot: args.autopilot_kind.into(),
        program: args.autopilot.as_deref(),
        instance: args.instance,
        parameters: &args.parameters,
        speed: args.speed,
        keep: args.keep,
        frames: args.frames.as_deref(),
        verbose: true,
    };
    match land(context, autopilots, &settings, lands, sweep, trial) {
        Ok(flown) => judged(context, &args.out, trial, flown),
        Err(Failure::NotFlown(cause)) => {
            let row = LandingRow::not_flown(trial, cause.name());
            let result = LandingResult::of(&row);
            Ok((row, result))
        }
        Err(Failure::Autopilot { error, .. } | Failure::Command(error)) => Err(error),
    }
}

/// Writes the truth of a landing; returns its results.
fn judged(
    context: &Context,
    out: &Path,
    trial: u64,
    flown: Flown,
) -> Result<(LandingRow, LandingResult)> {
    if let Some(folder) = &flown.kept {
        context.say(&format!("the autopilot's folder: {}", folder.display()));
    }
    flown.truth.write(&file(out, "truth", trial, "parquet"))?;
    let row = LandingRow::of(trial, &flown.landing.landing);
    let stopped_s = flown.landing.stopped_s;
    let result = LandingResult {
        stopped_after_s: stopped_s
            .zip(flown.landing.landing.touch)
            .map(|(stopped_s, touch)| stopped_s - touch.time_s),
        speed: Some(flown.speed),
        missed_answers: Some(flown.missed_answers),
        companion: flown.companion,
        ..LandingResult::of(&row)
    };
    Ok((row, result))
}

/// The file of a trial in the folder of results.
fn file(out: &Path, stem: &str, trial: u64, ending: &str) -> PathBuf {
    out.join(format!("{stem}-{trial}.{ending}"))
}

impl LandingResult {
    /// The results that a row holds.
    fn of(row: &LandingRow) -> Self {
        Self {
            trial: row.landing,
            outcome: row.outcome.clone(),
            why: row.why.clone(),
            t_l_s: row.number("t_l_s"),
            v_l_mps: row.number("v_l_mps"),
            impact_mps: row.number("impact_mps"),
            descents: row.counts[0],
            stopped_after_s: None,
            speed: None,
            missed_answers: None,
            companion: None,
        }
    }

    fn text(&self) -> String {
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "–".to_string(), |value| format!("{value:.3} {unit}"))
        };
        let why = self.why.as_ref();
        let why = why.map_or_else(String::new, |why| format!(" ({})", why.replace('_', " ")));
        let outcome = format!(
            "landing {}: {}{why}",
            self.trial,
            self.outcome.replace('_', " ")
        );
        let Some(speed) = self.speed else {
            return outcome;
        };
        format!(
            "{outcome}, T_L {}, V_L {}, motors stopped {} after the touch; {speed:.2} times real time",
            number(self.t_l_s, "s"),
            number(self.v_l_mps, "m/s"),
            number(self.stopped_after_s, "s"),
        )
    }
}
