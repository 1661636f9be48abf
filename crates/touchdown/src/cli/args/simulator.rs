//! Arguments of `touchdown simulator`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use touchdown_campaign::sweep::AutopilotProgram;
use touchdown_flight::Method;

const SIMULATOR: &str = "\
Examples:
  touchdown settings campaign > deck.toml; touchdown settings fly > fly.toml     then delete [grid] from deck.toml
  touchdown simulator px4 deck.toml                                     your own PX4 and ground station
  touchdown simulator px4 deck.toml --with fly.toml --autopilot ~/PX4-Autopilot/build/px4_sitl_default/bin/px4
  touchdown simulator ardupilot deck.toml --own-landing --autopilot ~/ardupilot/build/sitl/bin/arducopter --trials 20

With --autopilot the command starts the autopilot in a scratch folder, arms, takes off, and holds above a deck that stands.
Then the deck moves, and the companion of --with (or the autopilot's own landing mode) lands. At the end the autopilot is
stopped and its folder removed. The folder of --out gets landings.csv, results.json, and for each landing the truth
(truth-0.parquet) and the companion's recording (flight-0.mcap, for `touchdown fly --replay`).

Without --autopilot the command waits for an autopilot that you start:
  PX4:       PX4_SYS_AUTOSTART=10016 ./bin/px4               connects to TCP port 4560
  ArduPilot: arducopter --model JSON:127.0.0.1 --defaults ... sends to UDP port 9002
The deck then moves as soon as the vehicle is half a metre above it. Ctrl-C ends the command.

The autopilot is not part of the simulation's clockwork: its threads run as the machine lets them. Landings repeat to about
a hundredth, not to the bit.";

/// The autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SimulatedAutopilot {
    /// PX4 (tried with v1.17)
    Px4,
    /// ArduCopter (tried with 4.7-dev)
    #[value(name = "ardupilot")]
    ArduPilot,
}

impl From<SimulatedAutopilot> for AutopilotProgram {
    fn from(autopilot: SimulatedAutopilot) -> Self {
        match autopilot {
            SimulatedAutopilot::Px4 => Self::Px4,
            SimulatedAutopilot::ArduPilot => Self::ArduPilot,
        }
    }
}

/// The simulated camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SimulatedCamera {
    /// Positions with the measured errors of a detector
    Fast,
    /// Rendered images
    Rendered,
}

/// A parameter's name and value.
fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| format!("expected NAME=VALUE, found `{text}`"))?;
    if name.is_empty() || name.len() > 16 {
        return Err(format!(
            "expected a name of 1 to 16 characters, found `{name}`"
        ));
    }
    let number = value.parse::<f64>().ok().filter(|value| value.is_finite());
    let number = number.ok_or_else(|| format!("{name}: expected a number, found `{value}`"))?;
    Ok((name.to_string(), number))
}

#[derive(Args, Debug)]
#[command(after_help = SIMULATOR)]
pub(crate) struct SimulatorArgs {
    /// Which autopilot
    #[arg(value_name = "AUTOPILOT")]
    pub(crate) autopilot_kind: SimulatedAutopilot,
    /// Scenario: a sweep as of `touchdown land --space`, without `[grid]` (`touchdown settings campaign` prints all keys)
    pub(crate) scenario: PathBuf,
    /// The autopilot's program, which this command starts and stops
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) autopilot: Option<PathBuf>,
    /// Land with the companion of `touchdown fly` and these settings, whose `link` is not used
    #[arg(long, value_name = "FLY.toml", requires = "autopilot")]
    pub(crate) with: Option<PathBuf>,
    /// Controller of the companion [default: that of --with]
    #[arg(long, value_name = "NAME", requires = "with", conflicts_with = "own_landing",
          value_parser = PossibleValuesParser::new(Method::ALL.map(Method::name)))]
    pub(crate) controller: Option<String>,
    /// The simulated camera: `fast` gives positions with a detector's errors; `rendered` gives images, in which the
    /// companion looks for the pad by its own settings `[camera]`, whose source is not used [default: that of the scenario]
    #[arg(long, value_enum, conflicts_with = "own_landing")]
    pub(crate) camera: Option<SimulatedCamera>,
    /// Write the rendered images into this folder, or as PGM stream into this named pipe
    #[arg(long, value_name = "FOLDER", conflicts_with = "own_landing")]
    pub(crate) frames: Option<PathBuf>,
    /// Land in the autopilot's own mode
    #[arg(long, conflicts_with = "with", requires = "autopilot")]
    pub(crate) own_landing: bool,
    /// A parameter of the autopilot; repeatable
    #[arg(long = "parameter", value_name = "NAME=VALUE", requires = "autopilot", value_parser = parameter)]
    pub(crate) parameters: Vec<(String, f64)>,
    /// Simulated seconds in a second; 0 is as fast as the machine can
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub(crate) speed: f64,
    /// Landings, one after the other, each with a fresh autopilot
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) trials: u64,
    /// Seed of all random numbers [default: that of the scenario]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// PX4's instance, whose ports are used where no --autopilot is given
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..10))]
    pub(crate) instance: u16,
    /// Keep the autopilot's scratch folder, with its console and logs
    #[arg(long)]
    pub(crate) keep: bool,
    /// Folder for results
    #[arg(long, default_value = "out/simulator")]
    pub(crate) out: PathBuf,
}
