//! `touchdown simulator`.

mod launch;
mod process;
mod seat;
mod session;
mod truth;
mod world;

use std::path::Path;

use serde::Serialize;
use touchdown::settings;
use touchdown::{Error, Result};
use touchdown_campaign::csv::line;
use touchdown_campaign::sweep::{LandingRow, Sweep, SweepSettings};
use touchdown_flight::Method;
use touchdown_link::companion::Summary;
use touchdown_link::settings::FlightSettings;
use touchdown_link::simulator::ardupilot::ArduPilot;
use touchdown_link::simulator::{ardupilot, place, px4};
use touchdown_sim::landing::space::MotorLanding;
use touchdown_terminal::Done;

use super::args::simulator::{SimulatedAutopilot, SimulatorArgs};
use super::context::Context;
use super::{fly, output};
use launch::Wishes;
use process::{AutopilotProcess, free_udp};
use seat::Seat;
use session::{Crew, Flown, Lands, Limits, Link, Session, mavlink_port};

/// What is said of a landing.
#[derive(Serialize)]
struct Landed {
    trial: u64,
    outcome: String,
    why: Option<String>,
    t_l_s: Option<f64>,
    v_l_mps: Option<f64>,
    impact_mps: Option<f64>,
    descents: u32,
    /// Time from the touch to the motors' stop, s.
    stopped_after_s: Option<f64>,
    /// Simulated seconds in a second.
    speed: f64,
    missed_answers: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    companion: Option<Summary>,
}

/// What is said of all.
#[derive(Serialize)]
struct Results {
    autopilot: &'static str,
    /// The autopilot's threads run as the machine lets them.
    reproducible_to_the_bit: bool,
    seed: u64,
    landings: Vec<Landed>,
}

pub(crate) fn run(context: &Context, args: &SimulatorArgs) -> Result<Done> {
    if !(args.speed >= 0.0 && args.speed <= 1000.0) {
        return Err(Error::Arguments(format!(
            "--speed: expected 0 to 1000, found {}",
            args.speed
        )));
    }
    let sweep = load(args)?;
    let flight = args.with.as_deref().map(fly::load).transpose()?;
    let flight = match (&args.controller, flight) {
        (Some(name), Some(mut flight)) => {
            flight.control.method = method(name)?;
            Some(flight)
        }
        (_, flight) => flight,
    };
    output::results_folder(context, &args.out)?;
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
        let (landed, cells) = fly_one(context, args, &sweep, flight.as_ref(), trial)?;
        context.say(&landed.text());
        line(&mut table, cells);
        output::write(&args.out.join("landings.csv"), table.as_bytes())?;
        landings.push(landed);
    }
    let results = Results {
        autopilot: match args.autopilot_kind {
            SimulatedAutopilot::Px4 => "px4",
            SimulatedAutopilot::ArduPilot => "ardupilot",
        },
        reproducible_to_the_bit: false,
        seed: sweep.settings().seed,
        landings,
    };
    output::write(
        &args.out.join("sweep.toml"),
        settings::to_toml(sweep.settings())?.as_bytes(),
    )?;
    output::results(&args.out, &results)?;
    context.object(&results);
    Ok(Done::Whole)
}

fn load(args: &SimulatorArgs) -> Result<Sweep> {
    let path = &args.scenario;
    let mut settings: SweepSettings = settings::read(path)?;
    if !settings.grid.is_empty() {
        return Err(Error::Settings {
            file: path.display().to_string(),
            message: "`grid`: expected none under an autopilot, found some".to_string(),
        });
    }
    settings.trials = args.trials;
    settings.seed = args.seed.unwrap_or(settings.seed);
    let folder = path.parent().unwrap_or(Path::new("."));
    Ok(Sweep::new(settings, folder, path.display().to_string())?)
}

fn method(name: &str) -> Result<Method> {
    let found = Method::ALL.into_iter().find(|method| method.name() == name);
    found.ok_or_else(|| Error::Arguments(format!("--controller: `{name}` is none")))
}

/// Stops the autopilot at the end of its scope, also by an error or a panic.
struct Stopped(Option<AutopilotProcess>);

impl Drop for Stopped {
    fn drop(&mut self) {
        if let Some(process) = &self.0 {
            process.stop();
        }
    }
}

fn fly_one(
    context: &Context,
    args: &SimulatorArgs,
    sweep: &Sweep,
    flight: Option<&FlightSettings>,
    trial: u64,
) -> Result<(Landed, Vec<String>)> {
    let lander = sweep.lander(trial)?;
    let scenario = lander.scenario();
    let world = lander.motor_flight(trial, sweep.settings().seed, place::MAGNETIC_FIELD_GAUSS)?;
    let lands = match flight {
        Some(flight) => {
            let recording = session::file(&args.out, "flight", trial, "mcap");
            Lands::Companion(Box::new(Seat::new(flight, &recording)?))
        }
        None if args.own_landing => Lands::Autopilot,
        None => Lands::Anyone,
    };
    let crew = crew(args, scenario, lands)?;
    let _stopped = Stopped(crew.process.clone());
    if let Some(process) = crew.process.clone() {
        let folder = args.out.display().to_string();
        context.if_interrupted(move || {
            process.interrupt();
            output::missing(&folder)
        });
    }
    let limits = Limits {
        range_limits_m: [
            scenario.sensors.range.least_m,
            scenario.sensors.range.greatest_m,
        ],
        hold_height_m: scenario.start_m[2],
        timeout_s: scenario.timeout_s,
        speed: args.speed,
    };
    let kept = crew.process.clone();
    let flown = Session::new(context, world, crew, &limits).run();
    if let Some(process) = &kept {
        process.wait_if_interrupted();
    }
    let flown = flown?;
    if let Some(folder) = kept.as_ref().and_then(AutopilotProcess::kept) {
        context.say(&format!("the autopilot's folder: {}", folder.display()));
    }
    ended(args, trial, flown)
}

/// The links to the autopilot, which is started if its program is given.
fn crew(
    args: &SimulatorArgs,
    scenario: &touchdown_sim::landing::space::SpaceScenario,
    lands: Lands,
) -> Result<Crew> {
    let wishes = |program| Wishes {
        program,
        scenario,
        companion: matches!(lands, Lands::Companion(_)),
        parameters: &args.parameters,
        keep: args.keep,
    };
    let (link, launch, mavlink) = match (args.autopilot_kind, &args.autopilot) {
        (SimulatedAutopilot::Px4, Some(program)) => {
            let instance = launch::free_instance()?;
            let launch = launch::px4(&wishes(program), instance)?;
            let mavlink = mavlink_port(14_540 + instance)?;
            (
                Link::Px4Waiting(px4::listen(instance)?),
                Some(launch),
                Some(mavlink),
            )
        }
        (SimulatedAutopilot::Px4, None) => {
            (Link::Px4Waiting(px4::listen(args.instance)?), None, None)
        }
        (SimulatedAutopilot::ArduPilot, Some(program)) => {
            let ardupilot = ArduPilot::bind(0)?;
            let port = free_udp()?;
            let mavlink = mavlink_port(port)?;
            let launch = launch::ardupilot(&wishes(program), ardupilot.port()?, port)?;
            (Link::ArduPilot(ardupilot), Some(launch), Some(mavlink))
        }
        (SimulatedAutopilot::ArduPilot, None) => (
            Link::ArduPilot(ArduPilot::bind(ardupilot::PORT)?),
            None,
            None,
        ),
    };
    Ok(Crew {
        link,
        process: launch.map(AutopilotProcess::start).transpose()?,
        mavlink,
        lands,
    })
}

/// Writes the truth and says how it went.
fn ended(args: &SimulatorArgs, trial: u64, flown: Flown) -> Result<(Landed, Vec<String>)> {
    flown
        .truth
        .write(&session::file(&args.out, "truth", trial, "parquet"))?;
    let companion = flown.seat.map(|seat| seat.finish()).transpose()?;
    let MotorLanding { landing, stopped_s } = flown.landing;
    let row = LandingRow::of(trial, &landing);
    let touch = landing.touch;
    let stopped_after_s = stopped_s
        .zip(touch)
        .map(|(stopped_s, touch)| stopped_s - touch.time_s);
    let cells = [trial.to_string()]
        .into_iter()
        .chain(row.cells())
        .chain([stopped_after_s.map_or_else(String::new, |s| s.to_string())])
        .collect();
    let landed = Landed {
        trial,
        outcome: row.outcome,
        why: row.why,
        t_l_s: touch.map(|touch| touch.t_l_s),
        v_l_mps: touch.map(|touch| touch.v_l_mps),
        impact_mps: landing.impact.map(|impact| impact.speed_mps),
        descents: landing.descents,
        stopped_after_s,
        speed: flown.speed,
        missed_answers: flown.missed_answers,
        companion,
    };
    Ok((landed, cells))
}

impl Landed {
    fn text(&self) -> String {
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "–".to_string(), |value| format!("{value:.3} {unit}"))
        };
        let why = self
            .why
            .as_ref()
            .map_or_else(String::new, |why| format!(" ({why})"));
        format!(
            "landing {}: {}{why}, T_L {}, V_L {}, motors stopped {} after the touch; {:.2} times real time",
            self.trial,
            self.outcome.replace('_', " "),
            number(self.t_l_s, "s"),
            number(self.v_l_mps, "m/s"),
            number(self.stopped_after_s, "s"),
            self.speed,
        )
    }
}
