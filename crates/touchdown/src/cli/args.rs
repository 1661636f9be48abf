//! All arguments.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use touchdown_campaign::sweep::Shard;
use touchdown_flight::Method;
use touchdown_identify::settings::{GroundEffectForm, ThrustForm};
use touchdown_terminal::{EXIT_STATUS, Output, Shell};

/// From a thrust log to a soft touchdown on a moving deck.
///
/// Identifies throttle-to-thrust and ground-effect models from force-rig data or logs, proves them on unseen
/// trials, and lands a simulated vehicle with them.
#[derive(Debug, Parser)]
#[command(name = "touchdown", version, after_help = format!("{EXAMPLES}\n\n{EXIT_STATUS}"))]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) output: Output,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  touchdown reproduce                                    the paper end to end; writes out/reproduce/report.html
  touchdown inspect LOG                                  what is in a log, and a map to start from
  touchdown identify thrust LOG.csv --map MAP.toml --out thrust.toml
  touchdown validate thrust.toml OTHER.csv --map MAP.toml
  touchdown rig --out rig
  touchdown identify thrust rig/thrust_training/*.csv --out thrust.toml
  touchdown identify ground-effect rig/ground_effect_rich/*.csv --thrust thrust.toml --out models
  touchdown land examples/scenarios/deck.toml --out landings
  touchdown land --space --mcap landings/mcap --out landings
  touchdown settings campaign > sweep.toml; touchdown campaign sweep.toml --out campaign";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Redo the paper end to end on the virtual rig and vehicle, ours beside published, and land at sea
    Reproduce(ReproduceArgs),
    /// Run the virtual force rig and write its trials
    Rig(RigArgs),
    /// Show channels, units, rates and gaps of logs, and suggest a map
    Inspect(InspectArgs),
    /// Fit a thrust or ground-effect model to logs and write its card
    Identify(IdentifyArgs),
    /// Run models freely over logs that they have not seen, and judge them
    Validate(ValidateArgs),
    /// Land the simulated vehicle many times: vertically, or with --space in six degrees of freedom
    Land(LandArgs),
    /// Land in six degrees of freedom over grids and draws of any setting
    Campaign(CampaignArgs),
    /// Print the default settings as commented TOML
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

const COMPLETIONS: &str = "\
Examples:
  touchdown completions bash > ~/.local/share/bash-completion/completions/touchdown
  touchdown completions fish > ~/.config/fish/completions/touchdown.fish";

const MAN: &str = "\
Examples:
  touchdown man --out ~/.local/share/man/man1
  man touchdown-identify";

#[derive(Args, Debug)]
pub(crate) struct ReproduceArgs {
    /// Folder for results, report, figures, cards and trials
    #[arg(long, default_value = "out/reproduce")]
    pub(crate) out: PathBuf,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Landings of every method in every experiment, of every fault at sea half as many [default: 40; with --quick 8]
    #[arg(long)]
    pub(crate) trials: Option<usize>,
    /// A fast look: fewer rig trials and landings
    #[arg(long)]
    pub(crate) quick: bool,
    /// Settings that override the defaults (see `touchdown settings reproduce`)
    #[arg(long)]
    pub(crate) settings: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct RigArgs {
    /// Scenario with rig settings and trials; without it, the standard trial sets (see `touchdown settings rig`)
    pub(crate) scenario: Option<PathBuf>,
    /// Folder for the trials, one CSV each
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
}

#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// Logs, told by their content: CSV, Parquet, PX4 ULog, ArduPilot DataFlash, MCAP, ROS 1 bag
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Map the columns first, and show the channels: a file, or a built-in map (px4, ardupilot, ros)
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Folder for plots of every channel and a report
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct IdentifyArgs {
    #[command(subcommand)]
    pub(crate) what: Identify,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Identify {
    /// Throttle to thrust
    ///
    /// Needs the channels `time_s`, `thrust_n` and `throttle` (or `throttle_1`, `throttle_2`, ...); uses
    /// `rotor_rpm` and `battery_v` where they are. Logs of flights may have `specific_force_mps2` (or quick poses) in place
    /// of `thrust_n`, with the vehicle's mass in --map or --settings: they give the thrust by throttle with the lag and dead
    /// time of the motors, or say why not; and of every run of the motors, when they went on and off and the throttle of its
    /// steady hover.
    Thrust {
        #[command(flatten)]
        common: IdentifyCommon,
        /// Form of the model; without it, the data decide
        #[arg(long, value_parser = thrust_form())]
        form: Option<ThrustForm>,
        /// Degree of polynomials in throttle [default: 2]
        #[arg(long)]
        degree: Option<usize>,
        /// Give static maps a battery-voltage term
        #[arg(long)]
        battery: bool,
    },
    /// Ground-effect force
    ///
    /// Needs the channels `time_s`, `throttle`, `thrust_n` and `height_m`; uses `deck_velocity_mps` and
    /// `vehicle_velocity_mps` where they are. The logs are fitted together.
    ///
    /// Logs of flights have no `thrust_n`. They need no thrust card, but `rotor_radius_m` in the table [flight] of
    /// --settings, `height_m` with hover both below two rotor radii and above four without landing in between, and
    /// `throttle` or `rotor_rpm`. With `specific_force_mps2` (the accelerometer along the rotor axis, 9.81 in hover) they
    /// give curve, lags and effect of climb; poses at 40 Hz or more give the curve; slower ones, the ratio of thrusts at
    /// each hover at rest, by `rotor_rpm`, by --thrust CARD, or roughly by throttle. What the logs do not carry is refused,
    /// with what to record. Every run of the motors is told with its hover and its extra lift near the ground.
    #[command(after_help = FLIGHTS)]
    GroundEffect {
        #[command(flatten)]
        common: IdentifyCommon,
        /// Card of the thrust model that gives the free-air thrust; for logs of flights only where they have neither
        /// accelerometer nor rotor speed
        #[arg(long)]
        thrust: Option<PathBuf>,
        /// Forms; repeatable [default: all five; into a single file `lag`]
        #[arg(long, value_parser = ground_effect_form())]
        form: Vec<GroundEffectForm>,
    },
}

const FLIGHTS: &str = "\
Flights, with `[flight] mass_kg = 1.4` and `rotor_radius_m = 0.12` in vehicle.toml:
  PX4             touchdown identify ground-effect *.ulg --settings vehicle.toml --out vehicle
  ArduPilot       touchdown identify ground-effect *.BIN --settings vehicle.toml --out vehicle
  motion capture  touchdown identify ground-effect *.csv --map mocap.toml --settings vehicle.toml --out vehicle";

#[derive(Args, Debug)]
pub(crate) struct IdentifyCommon {
    /// Logs: CSV, Parquet, PX4 ULog, ArduPilot DataFlash, MCAP, ROS 1 bag
    #[arg(required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// Map from the logs' columns to channels: a file, or a built-in map (px4, ardupilot, ros); not needed where the columns are
    /// channels already, nor for logs of PX4 and ArduPilot
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Settings that override the defaults (`touchdown settings identify` prints them all, with comments)
    ///
    /// A TOML file with any of these sections and keys:
    ///
    ///   [smoothing]      window, degree, thrust_window
    ///   [choice]         solver, criterion, folds, seed, effective_rows
    ///   [sr3]            thresholds, nus; or one lambda, one nu
    ///   [published]      threshold, nu (the published procedure to the letter)
    ///   [weak]           half_width_s, spacing, power, generalised
    ///   [shooting]       window_s, stride_s, every, noise_n, max_iterations
    ///   [thrust]         form, degree, battery, settle_s, min_thrust_n, library, refine, max_lag_s, dead_time
    ///   [ground_effect]  rotor_radius_m, lengths_m, library, lag_bounds_s, ratio_limits, velocity_input
    ///   [flight]         mass_kg, rotor_radius_m, gravity_mps2, idle_throttle, reference_radii, height_bias_radii,
    ///                    least_rate_hz, resamples, seed (logs of flights, without a force sensor)
    #[arg(long, verbatim_doc_comment)]
    pub(crate) settings: Option<PathBuf>,
    /// A file MODEL.toml: one card from all logs together. A folder: a card for each log (or form), a summary table
    /// and a report. Without it, nothing is written
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct ValidateArgs {
    /// Model cards (.toml) and logs (.csv), in any order
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Map from the logs' columns to channels
    #[arg(long)]
    pub(crate) map: Option<PathBuf>,
    /// Card of the thrust model that gives the free-air thrust, for ground-effect cards
    #[arg(long)]
    pub(crate) thrust: Option<PathBuf>,
    /// Folder for error tables, plots and a report
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Debug)]
#[command(after_help = LAND)]
pub(crate) struct LandArgs {
    /// Scenario; without it, the landing on the oscillating deck (see `touchdown settings land`)
    ///
    /// With --space it is a sweep, as of `touchdown campaign`; `touchdown settings campaign` prints one with every key. A sweep
    /// without `[scenario.deck]` has a deck that lies still; without any sweep it is the paper's.
    pub(crate) scenario: Option<PathBuf>,
    /// The whole vehicle in six degrees of freedom, with all its sensors
    #[arg(long)]
    pub(crate) space: bool,
    /// Folder for every landing as an MCAP file (Foxglove, PlotJuggler)
    #[arg(long, value_name = "DIR", requires = "space")]
    pub(crate) mcap: Option<PathBuf>,
    /// Folder for every landing as a ULog, as PX4 would have logged it; `touchdown identify` takes them as any flight's
    #[arg(long, value_name = "DIR", requires = "space")]
    pub(crate) ulog: Option<PathBuf>,
    /// Controllers; repeatable [default: all five; with --space the scenario's, `dynamic+observer` without one]
    #[arg(long = "controller", value_name = "NAME", value_parser = controllers())]
    pub(crate) controllers: Vec<String>,
    /// Landings of every method [default: 40]
    #[arg(long)]
    pub(crate) trials: Option<usize>,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Thrust card; without one, a model is identified on the virtual rig first (with --space: the built-in one)
    ///
    /// A thrust and a ground-effect card with their vehicle's mass and rotor radius fly that vehicle, unless the scenario has
    /// one of its own: the default one in proportion, with the motors of the thrust card. Not with --space, where the
    /// scenario's vehicle is flown, and a card of another one is warned of.
    #[arg(long)]
    pub(crate) thrust: Option<PathBuf>,
    /// Ground-effect card for `dynamic`; without one, a model is identified on the virtual rig first; vehicle as for --thrust
    #[arg(long)]
    pub(crate) dynamic: Option<PathBuf>,
    /// Card of eq. (2) for `empirical`; without one, mu is identified on the virtual rig first
    #[arg(long)]
    pub(crate) empirical: Option<PathBuf>,
    /// Do not feed the deck's acceleration forward
    #[arg(long)]
    pub(crate) no_acceleration: bool,
    /// Folder for results, figures and report
    #[arg(long)]
    pub(crate) out: PathBuf,
}

#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, after_help = CAMPAIGN)]
pub(crate) struct CampaignArgs {
    #[command(subcommand)]
    pub(crate) command: Option<CampaignCommand>,
    /// Sweep: a scenario, lists of values, distributions (`touchdown settings campaign` prints one to start from)
    #[arg(required = true, value_name = "SWEEP")]
    pub(crate) sweep: Option<PathBuf>,
    /// Fly only part I of N
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Complete the campaign that is in the folder
    #[arg(long)]
    pub(crate) resume: bool,
    /// Landings at every point, in place of the sweep's
    #[arg(long)]
    pub(crate) trials: Option<u64>,
    /// Seed of all random numbers, in place of the sweep's
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Folder for the worst landings as MCAP files (Foxglove, PlotJuggler)
    #[arg(long, value_name = "DIR")]
    pub(crate) mcap: Option<PathBuf>,
    /// Folder for landings, results, figures and report
    #[arg(long, default_value = "out/campaign")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Subcommand)]
pub(crate) enum CampaignCommand {
    /// Put shards together: the same files as of a campaign that was flown whole
    Merge {
        /// Folders of shards
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// Folder for the whole campaign
        #[arg(long)]
        out: PathBuf,
        /// Folder for the worst landings as MCAP files (Foxglove, PlotJuggler)
        #[arg(long, value_name = "DIR")]
        mcap: Option<PathBuf>,
    },
    /// Fly landings of a campaign once more, and write all their signals as MCAP files (Foxglove, PlotJuggler)
    Replay {
        /// Sweep, such as the `sweep.toml` in a campaign's folder
        sweep: PathBuf,
        /// Which landing, by its column `landing`; repeatable
        #[arg(long = "landing", value_name = "N", required = true)]
        landings: Vec<u64>,
        /// Folder for the files
        #[arg(long)]
        mcap: PathBuf,
    },
}

/// Names of methods; the last two fly in six degrees of freedom only.
fn controllers() -> PossibleValuesParser {
    PossibleValuesParser::new(Method::ALL.map(Method::name))
}

/// Forms of thrust models, by name.
fn thrust_form() -> impl TypedValueParser<Value = ThrustForm> {
    let described = |form: ThrustForm| PossibleValue::new(form.name()).help(form.description());
    PossibleValuesParser::new(ThrustForm::ALL.map(described))
        .try_map(|name| name.parse::<ThrustForm>())
}

/// Forms of ground-effect models, by name.
fn ground_effect_form() -> impl TypedValueParser<Value = GroundEffectForm> {
    let described =
        |form: GroundEffectForm| PossibleValue::new(form.name()).help(form.description());
    PossibleValuesParser::new(GroundEffectForm::ALL.map(described))
        .try_map(|name| name.parse::<GroundEffectForm>())
}

const LAND: &str = "\
Examples:
  touchdown land --controller dynamic --out landings             on the paper's deck, vertically
  touchdown land --space --trials 20 --out landings              the same deck, the whole vehicle
  touchdown land --space --controller observer --mcap mcap --out landings
  touchdown land --space scenario.toml --out landings            for example with camera = \"rendered\" under [scenario.sensors]";

const CAMPAIGN: &str = "\
Landings are written as they come, in blocks of one Parquet file each (`landings/block-000000.parquet`); a kill loses
at most the running block. Files are the same for any number of cores, any split into shards and any interruption.

Examples:
  touchdown campaign sweep.toml --out campaign               killed? the same with --resume completes it
  touchdown campaign sweep.toml --shard 1/2 --out a          on one machine
  touchdown campaign sweep.toml --shard 2/2 --out b          on another
  touchdown campaign merge a b --out campaign
  touchdown campaign replay campaign/sweep.toml --landing 17 --mcap replays";

#[derive(Args, Debug)]
pub(crate) struct SettingsArgs {
    /// Of which command
    #[arg(default_value = "reproduce")]
    pub(crate) of: SettingsOf,
}

#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub(crate) enum SettingsOf {
    /// Everything that `reproduce` depends on
    Reproduce,
    /// A rig scenario
    Rig,
    /// A landing scenario
    Land,
    /// A sweep, with every setting of a landing in space
    Campaign,
    /// Identification
    Identify,
}
