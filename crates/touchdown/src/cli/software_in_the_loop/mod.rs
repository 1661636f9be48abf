//! A landing under a real autopilot: `touchdown simulator`, and campaigns with an autopilot in the loop.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `launch`, `process`, `instances` | how autopilots are started, stopped, and kept apart |
//! | `link`, `world` | samples of the simulated world for the autopilot, its motor signals back |
//! | `session` | one landing, with pilot and companion, in simulated time |
//! | `companion`, `truth` | the companion of `touchdown fly`, and the table of the truth |
//! | `frames` | rendered frames of the camera, to the companion or to files |
//! | `failure` | why a landing has no result |
//! | `backend` | the landings of a campaign, several side by side |

mod backend;
mod companion;
mod failure;
mod frames;
mod instances;
mod launch;
mod link;
mod process;
mod session;
mod truth;
mod world;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use touchdown::{Error, Result};
use touchdown_campaign::camera::Film;
use touchdown_campaign::sweep::{AutopilotProgram, Sweep};
use touchdown_link::companion::Summary;
use touchdown_link::settings::FlightSettings;
use touchdown_link::simulator::ardupilot::{self, ArduPilot};
use touchdown_link::simulator::{place, px4};
use touchdown_sim::landing::space::{MotorLanding, SpaceLander, SpaceScenario};
use touchdown_sim::sensors::CameraMode;

use super::context::Context;
pub(crate) use backend::AutopilotBackend;
pub(crate) use failure::{Attempt, Failure};
pub(crate) use instances::Autopilots;

use companion::SimulatedCompanion;
use frames::RenderedFrames;
use instances::{Instance, free_udp, mavlink_port};
use launch::LaunchSettings;
use link::Opening;
use session::{LandedBy, Limits, Participants, Session};
use truth::TruthTable;

/// A landing that was flown to its end.
pub(crate) struct Flown {
    /// The landing, judged by the truth.
    pub(crate) landing: MotorLanding,
    /// The truth, 100 times a second.
    pub(crate) truth: TruthTable,
    /// Summary of the companion, if one landed.
    pub(crate) companion: Option<Summary>,
    /// Simulated seconds in a second.
    pub(crate) speed: f64,
    /// Answers that PX4 did not give, or lines that ArduPilot asked for again.
    pub(crate) missed_answers: u64,
    /// The autopilot's scratch folder, if it is kept.
    pub(crate) kept: Option<PathBuf>,
}

/// How landings are flown under an autopilot.
pub(crate) struct LoopConfiguration<'a> {
    /// Which autopilot.
    pub(crate) autopilot: AutopilotProgram,
    /// Its program; without it, an autopilot is awaited at the ports of [`Self::instance`].
    pub(crate) program: Option<&'a Path>,
    /// PX4's instance, where no program is given.
    pub(crate) instance: u16,
    /// Parameters of the autopilot, beside those that are always set.
    pub(crate) parameters: &'a [(String, f64)],
    /// Simulated seconds in a second; 0 is as fast as possible.
    pub(crate) speed: f64,
    /// Whether scratch folders are kept.
    pub(crate) keep: bool,
    /// A folder or a named pipe for the frames of a camera that renders them.
    pub(crate) frames: Option<&'a Path>,
    /// Whether the steps of a landing are reported on the terminal.
    pub(crate) verbose: bool,
}

/// Who lands the vehicle of a trial.
pub(crate) enum Lands<'a> {
    /// The user's own ground station.
    GroundStation,
    /// The autopilot's own landing mode.
    AutopilotMode,
    /// The companion, with a file for its recording if it is to be kept.
    Companion(&'a FlightSettings, Option<PathBuf>),
}

/// Flies a landing of a sweep under an autopilot.
pub(crate) fn land(
    context: &Context,
    autopilots: &Autopilots,
    settings: &LoopConfiguration<'_>,
    lands: Lands<'_>,
    sweep: &Sweep,
    landing: u64,
) -> Attempt<Flown> {
    let lander = sweep.lander(landing)?;
    let rendered = lander.scenario().sensors.camera == CameraMode::Rendered;
    let (lander, camera) = if rendered {
        let film = Film::default();
        let lander = SpaceLander::clone(&lander).with_camera_pipelines(film.pipelines());
        let camera = RenderedFrames::new(film, settings.frames, landing)?;
        (Arc::new(lander.map_err(Error::from)?), Some(camera))
    } else {
        (lander, None)
    };
    let scenario = lander.scenario();
    let trial = landing % sweep.trials();
    let world = lander.motor_flight(trial, sweep.settings().seed, place::MAGNETIC_FIELD_GAUSS)?;
    let landed_by = match lands {
        Lands::GroundStation => LandedBy::GroundStation,
        Lands::AutopilotMode => LandedBy::AutopilotMode,
        Lands::Companion(flight, recording) => LandedBy::Companion(Box::new(
            SimulatedCompanion::new(flight, recording.as_deref(), rendered)?,
        )),
    };
    let with_companion = matches!(landed_by, LandedBy::Companion(_));
    let (instance, opening, mavlink) = open(autopilots, settings, scenario, with_companion)?;
    let process = instance.as_ref().and_then(Instance::process);
    let range = &scenario.sensors.range;
    let limits = Limits {
        range_limits_m: [range.least_m, range.greatest_m],
        hold_height_m: scenario.start_m[2],
        timeout_s: scenario.timeout_s,
        speed: settings.speed,
        verbose: settings.verbose,
    };
    let participants = Participants {
        process,
        mavlink,
        landed_by,
        camera,
    };
    let flown = Session::connect(
        context,
        world,
        opening,
        participants,
        limits,
        settings.parameters,
    )
    .and_then(Session::run)
    .map(|flown| Flown {
        kept: process.and_then(|process| process.kept().map(Path::to_owned)),
        ..flown
    });
    autopilots.wait_if_interrupted();
    flown
}

/// Starts the autopilot if its program is given, and opens the ports at which it arrives.
fn open(
    autopilots: &Autopilots,
    settings: &LoopConfiguration<'_>,
    scenario: &SpaceScenario,
    with_companion: bool,
) -> Result<(Option<Instance>, Opening, Option<std::net::UdpSocket>)> {
    let launch_settings = |program| LaunchSettings {
        program,
        scenario,
        with_companion,
        parameters: settings.parameters,
        keep: settings.keep,
    };
    Ok(match (settings.autopilot, settings.program) {
        (AutopilotProgram::Px4, Some(program)) => {
            let (mut instance, ports) = autopilots.px4()?;
            instance.start(launch::px4(&launch_settings(program), instance.number)?)?;
            let opening = Opening::Px4(ports.simulator);
            (Some(instance), opening, Some(ports.mavlink))
        }
        (AutopilotProgram::Px4, None) => {
            let listener = px4::listen(settings.instance)?;
            (None, Opening::Px4(listener), None)
        }
        (AutopilotProgram::ArduPilot, Some(program)) => {
            let mut instance = autopilots.ardupilot()?;
            let ardupilot = ArduPilot::bind(0)?;
            let mavlink = mavlink_port(0)?;
            let address = mavlink.local_addr();
            let port = address.map_err(|e| Error::Arguments(format!("no free UDP port: {e}")))?;
            let ports = launch::ArduPilotPorts {
                simulator: ardupilot.port()?,
                mavlink: port.port(),
                remote_control: free_udp()?,
            };
            let launch = launch::ardupilot(&launch_settings(program), instance.number, &ports)?;
            instance.start(launch)?;
            (Some(instance), Opening::ArduPilot(ardupilot), Some(mavlink))
        }
        (AutopilotProgram::ArduPilot, None) => {
            let opening = Opening::ArduPilot(ArduPilot::bind(ardupilot::PORT)?);
            (None, opening, None)
        }
    })
}
