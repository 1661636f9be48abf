//! All arguments.

pub(crate) mod export;
pub(crate) mod fly;
pub(crate) mod identify;
pub(crate) mod land;
pub(crate) mod simulator;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use touchdown_terminal::{EXIT_STATUS, Output, Shell};

use export::ExportArgs;
use fly::FlyArgs;
use identify::{IdentifyArgs, ValidateArgs};
use land::{CampaignArgs, LandArgs};
use simulator::SimulatorArgs;

/// From a thrust log to a soft touchdown on a moving deck.
///
/// `touchdown` identifies thrust and ground-effect models from logs or from a virtual force rig. It validates them on logs
/// that they have not seen. Then it lands a simulated multirotor with them.
#[derive(Debug, Parser)]
#[command(name = "touchdown", version, after_help = format!("{EXAMPLES}\n\n{EXIT_STATUS}"))]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) output: Output,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
The paper, end to end:
  touchdown reproduce --quick

Your own log:
  touchdown inspect LOG.csv
  touchdown identify thrust LOG.csv --map MAP.toml --out thrust.toml
  touchdown validate thrust.toml OTHER.csv --map MAP.toml --out validation

From the virtual rig to landings:
  touchdown rig --out rig
  touchdown identify thrust rig/thrust_training/*.csv --out thrust.toml
  touchdown identify ground-effect rig/ground_effect_rich/*.csv --thrust thrust.toml --out models
  touchdown land --thrust thrust.toml --dynamic models/lag.toml --out landings

`touchdown COMMAND --help` explains each command and shows examples.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Reproduce the paper on the virtual rig and vehicle, and land at sea
    ///
    /// Identifies thrust and ground effect on the virtual rig, lands on the ground, on an oscillating deck and at sea, and
    /// shows each figure beside the published one.
    Reproduce(ReproduceArgs),
    /// Run the virtual force rig and write its trials
    ///
    /// The rig holds the simulated vehicle above a plate, drives its throttle and the height of the plate, and records what
    /// a load cell measures.
    Rig(RigArgs),
    /// Show channels, units, rates and gaps of logs, and suggest a map
    ///
    /// A map turns the columns of a foreign log into channels with units, such as `thrust_n`. Without --map this command
    /// prints one to start from.
    Inspect(InspectArgs),
    /// Identify a thrust or ground-effect model from logs and write its card
    ///
    /// A card is a TOML file with the model's terms, coefficients, standard errors, range of validity and origin. `touchdown
    /// validate` tests it, `touchdown land` flies it.
    Identify(IdentifyArgs),
    /// Simulate models over whole logs and print their errors
    ///
    /// Runs each model in free run: it starts from the log's initial conditions and gets the inputs alone. Errors are those of
    /// the predicted thrust or ground-effect force. Logs that a card was fitted to are marked.
    Validate(ValidateArgs),
    /// Write the flight models of cards as C or Rust for a flight computer
    ///
    /// The C code is C99 without dependencies and computes the bits of the simulation; `make test` beside it compares with
    /// recorded vectors.
    Export(ExportArgs),
    /// Land the simulated vehicle many times and compare controllers
    ///
    /// The vehicle moves vertically, as in the paper. With --space it moves in six degrees of freedom, with all its sensors.
    Land(LandArgs),
    /// Land in six degrees of freedom over grids and random draws of any setting
    ///
    /// A sweep file names a scenario, lists of values and distributions. The campaign flies all combinations on all cores.
    Campaign(CampaignArgs),
    /// Land a real vehicle: the companion beside PX4 or ArduPilot, over MAVLink
    ///
    /// Prints a checklist first. Control begins only when the pilot switches to OFFBOARD (PX4) or GUIDED (ArduPilot), and any
    /// other mode ends it. Parameters change only with --set-parameters. No real vehicle has been flown with it yet.
    Fly(FlyArgs),
    /// Put the simulated world under an unmodified PX4 or ArduPilot
    ///
    /// Deck, sea, wind, ground effect, faults and sensors are those of `touchdown land --space`; the autopilot is the real
    /// program. With --with the companion of `touchdown fly` lands it, and the truth says how.
    Simulator(SimulatorArgs),
    /// Print the default settings of a command as commented TOML
    Settings(SettingsArgs),
    /// Print the script that completes the command's arguments in a shell
    #[command(after_help = COMPLETIONS)]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write manual pages, one for each command
    #[command(after_help = MAN)]
    Man {
        /// Folder for the pages
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

const REPRODUCE: &str = "\
Examples:
  touchdown reproduce --quick                    fewer trials and landings
  touchdown reproduce --seed 2 --out out/seed2   other random numbers
  touchdown settings reproduce > settings.toml; touchdown reproduce --settings settings.toml

The folder of --out gets report.html, results.json, cards/, trials/, figures/, landings.csv, sea.csv and settings.toml.";

#[derive(Args, Debug)]
#[command(after_help = REPRODUCE)]
pub(crate) struct ReproduceArgs {
    /// Folder for report, results, figures, cards and trials
    #[arg(long, default_value = "out/reproduce")]
    pub(crate) out: PathBuf,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Landings by every controller in every experiment; half as many for every fault at sea [default: 40; with --quick 8]
    #[arg(long)]
    pub(crate) trials: Option<usize>,
    /// Use fewer rig trials and landings
    #[arg(long)]
    pub(crate) quick: bool,
    /// Settings that override the defaults (`touchdown settings reproduce` prints them)
    #[arg(long)]
    pub(crate) settings: Option<PathBuf>,
}

const RIG: &str = "\
Examples:
  touchdown rig --out rig
  touchdown rig examples/scenarios/rig.toml --seed 2 --out rig

The folder of --out gets a CSV file for each trial, in a folder for each set of trials, results.json and scenario.toml.";

#[derive(Args, Debug)]
#[command(after_help = RIG)]
pub(crate) struct RigArgs {
    /// Scenario with rig settings and trials (`touchdown settings rig` prints one) [default: the standard sets of trials]
    pub(crate) scenario: Option<PathBuf>,
    /// Folder for the trials
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
}

const INSPECT: &str = "\
Examples:
  touchdown inspect LOG.csv
  touchdown inspect LOG.ulg --map px4 --out inspected

Without --out nothing is written. The folder of --out gets report.html, figures/ and results.json.";

#[derive(Args, Debug)]
#[command(after_help = INSPECT)]
pub(crate) struct InspectArgs {
    /// Logs: CSV, Parquet, PX4 ULog, ArduPilot DataFlash, MCAP or ROS 1 bag; their content decides, not their name
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Map from columns to channels: a TOML file, or a built-in map (px4, ardupilot, ros, fly)
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Folder for plots of every channel and a report
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

const SETTINGS: &str = "\
Examples:
  touchdown settings land > scenario.toml; touchdown land scenario.toml --out landings
  touchdown settings campaign > sweep.toml; touchdown campaign sweep.toml --trials 10 --out campaign

A settings file needs only the keys that differ from the defaults.";

#[derive(Args, Debug)]
#[command(after_help = SETTINGS)]
pub(crate) struct SettingsArgs {
    /// The command that reads the settings
    #[arg(default_value = "reproduce")]
    pub(crate) of: SettingsOf,
}

#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub(crate) enum SettingsOf {
    /// All settings of `touchdown reproduce`
    Reproduce,
    /// A scenario of the virtual rig
    Rig,
    /// A scenario of vertical landings
    Land,
    /// A sweep, with every setting of a landing in six degrees of freedom
    Campaign,
    /// Settings of identification
    Identify,
    /// A flight beside an autopilot
    Fly,
}

const COMPLETIONS: &str = "\
Examples:
  touchdown completions bash > ~/.local/share/bash-completion/completions/touchdown
  touchdown completions fish > ~/.config/fish/completions/touchdown.fish";

const MAN: &str = "\
Examples:
  touchdown man --out ~/.local/share/man/man1
  man touchdown-identify";
