//! Arguments of `touchdown land` and `touchdown campaign`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use touchdown_campaign::sweep::{BlockRange, CampaignPart, Shard};
use touchdown_flight::Method;

const LAND: &str = "\
Examples:
  touchdown land --controller feedback --controller dynamic --out landings
  touchdown land examples/scenarios/yours.toml --out landings            a scenario to edit
  touchdown land --space --trials 20 --out landings                      six degrees of freedom, the same deck
  touchdown land --space --controller observer --mcap mcap --out landings
  touchdown land --space --policy policy.json --out landings             a learned policy beside the scenario's controller

The folder of --out gets report.html, results.json, landings.csv (a row for each landing), figures/, and the scenario with the
files that it names.
Vertical landings have the columns controller, trial, outcome (landed, crashed, timed_out or diverged), t_l_s (landing time T_L),
v_l_mps (relative speed at landing V_L), s_l_m (total variation of the relative height S_L) and final_height_m. A touch
above 0.6 m/s is a crash. A landing is hard if its touch (with --space any of its touches) is above 0.3 m/s (`crash_speed_mps`,
with --space `crash.speed_mps`, and half of it).
A vehicle that does not land is a result: the last lines say how often and why.";

#[derive(Args, Debug)]
#[command(after_help = LAND)]
pub(crate) struct LandArgs {
    /// Scenario (`touchdown settings land` prints one) [default: the paper's oscillating deck]
    ///
    /// With --space it is a sweep, as of `touchdown campaign`; `touchdown settings campaign` prints one with every key. A sweep
    /// without `[scenario.deck]` has a deck that does not move.
    pub(crate) scenario: Option<PathBuf>,
    /// Simulate the whole vehicle in six degrees of freedom, with all its sensors
    #[arg(long)]
    pub(crate) space: bool,
    /// Folder for every landing as an MCAP file, for Foxglove and PlotJuggler
    #[arg(long, value_name = "DIR", requires = "space")]
    pub(crate) mcap: Option<PathBuf>,
    /// Folder for every landing as a ULog, as PX4 would log it; `touchdown identify` reads them as flights
    #[arg(long, value_name = "DIR", requires = "space")]
    pub(crate) ulog: Option<PathBuf>,
    /// Controllers; repeatable [default: all five; with --space the scenario's, or `dynamic+observer`]
    #[arg(long = "controller", value_name = "NAME", value_parser = controllers())]
    pub(crate) controllers: Vec<String>,
    /// Learned policy (JSON) that lands beside the controllers, with the name `policy`
    ///
    /// `touchdown.Policy` of the Python package writes it, and `python/examples/land_ppo.py` trains one. It sees what the landing
    /// computer estimates, and flies the descents only. Approach, hover, go-arounds and touchdown remain the computer's, with
    /// the controller of the scenario (`scenario.control.controller`), whatever --controller says.
    #[arg(long, value_name = "FILE", requires = "space")]
    pub(crate) policy: Option<PathBuf>,
    /// Landings by every controller [default: 40]
    #[arg(long)]
    pub(crate) trials: Option<usize>,
    /// Seed of all random numbers [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Thrust card [default: identified on the virtual rig first; with --space the built-in one]
    ///
    /// If the thrust card and the ground-effect card have a mass and a rotor radius, and the scenario has no vehicle of its
    /// own, that vehicle flies: the default one scaled in proportion, with the motors of the thrust card. With --space the
    /// scenario's vehicle flies, and a card of another vehicle is warned about.
    #[arg(long)]
    pub(crate) thrust: Option<PathBuf>,
    /// Ground-effect card for `dynamic` [default: as for --thrust]
    #[arg(long)]
    pub(crate) dynamic: Option<PathBuf>,
    /// Card of eq. (2) for `empirical` [default: mu is identified on the virtual rig first]
    #[arg(long)]
    pub(crate) empirical: Option<PathBuf>,
    /// Do not feed the deck's acceleration forward
    #[arg(long)]
    pub(crate) no_acceleration: bool,
    /// Folder for results, figures and report
    #[arg(long)]
    pub(crate) out: PathBuf,
}

const CAMPAIGN: &str = "\
Examples:
  touchdown settings campaign > sweep.toml
  touchdown campaign sweep.toml --trials 10 --out campaign
  touchdown campaign sweep.toml --trials 10 --out campaign --resume       after an interruption
  touchdown campaign block sweep.toml --seconds 30                        the `block` whose landings take half a minute
  touchdown campaign sweep.toml --shard 1/2 --out a                       half of it on one machine
  touchdown campaign sweep.toml --shard 2/2 --out b                       half of it on another
  touchdown campaign merge a b --out whole
  touchdown campaign sweep.toml --blocks 3..5 --resume --out campaign     blocks 3 and 4, beside other runs in the same folder
  touchdown campaign status campaign                                      what is there, and what is missing
  touchdown campaign replay campaign/sweep.toml --landing 17 --mcap replays

--out can be an address in object storage: s3://bucket/name, gs://bucket/name or az://container/name. Keys and endpoints are those
of the environment: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION, AWS_ENDPOINT_URL (of another server than Amazon's);
GOOGLE_APPLICATION_CREDENTIALS; AZURE_STORAGE_ACCOUNT_NAME, AZURE_STORAGE_ACCOUNT_KEY.

The folder of --out gets landings/ (Parquet, a file for each block of landings, written as soon as the block is flown),
sweep.toml, summary.csv, results.json, figures/ and report.html. An interruption loses the running block only. The files
are the same for any number of cores, any split into shards and any interruption. A part (--shard, --blocks) writes
landings/ and sweep.toml only; `touchdown campaign merge DIR --out DIR` writes the rest in a folder that parts have shared.

With `autopilot = \"px4\"` or `\"ardupilot\"` in the sweep, the real autopilot flies every landing,
in --threads instances side by side. Such landings repeat to about a hundredth, not to the bit.
An autopilot that fails is the outcome of its landing.";

#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, after_help = CAMPAIGN)]
pub(crate) struct CampaignArgs {
    #[command(subcommand)]
    pub(crate) command: Option<CampaignCommand>,
    /// Sweep: a scenario, lists of values, distributions (`touchdown settings campaign` prints one to start from)
    #[arg(required = true, value_name = "SWEEP")]
    pub(crate) sweep: Option<PathBuf>,
    /// Fly only part I of N: every N-th block of landings, from the I-th on
    ///
    /// A part writes its blocks and no report; `touchdown campaign merge` does. Parts may share a folder, each with --resume.
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Fly only the blocks from A to before B, counted from 0; a part as of --shard
    #[arg(long, value_name = "A..B", conflicts_with = "shard")]
    pub(crate) blocks: Option<BlockRange>,
    /// Fly the landings that are missing in the folder
    #[arg(long)]
    pub(crate) resume: bool,
    /// Landings at a time, with an autopilot in the loop also instances of it [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=200))]
    pub(crate) threads: Option<u16>,
    /// Landings at every point [default: the sweep's]
    #[arg(long)]
    pub(crate) trials: Option<u64>,
    /// Seed of all random numbers [default: the sweep's]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Folder for the worst landings as MCAP files, for Foxglove and PlotJuggler
    #[arg(long, value_name = "DIR")]
    pub(crate) mcap: Option<PathBuf>,
    /// Folder for landings, results, figures and report, or an address in object storage
    #[arg(long, default_value = "out/campaign")]
    pub(crate) out: PathBuf,
}

impl CampaignArgs {
    /// What of the campaign is asked for.
    pub(crate) fn part(&self) -> CampaignPart {
        match (self.shard, self.blocks) {
            (Some(shard), _) => CampaignPart::Shard(shard),
            (None, Some(blocks)) => CampaignPart::Blocks(blocks),
            (None, None) => CampaignPart::Whole,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum CampaignCommand {
    /// Say what of a campaign is there: blocks, landings, and what is missing or broken (then the exit status is 3)
    Status {
        /// Folder or address of the campaign, or of a part of it
        folder: PathBuf,
    },
    /// Put shards together
    ///
    /// The files are the same as those of a campaign that was flown whole.
    Merge {
        /// Folders or addresses of shards
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// Folder or address for the whole campaign
        #[arg(long)]
        out: PathBuf,
        /// Folder for the worst landings as MCAP files, for Foxglove and PlotJuggler
        #[arg(long, value_name = "DIR")]
        mcap: Option<PathBuf>,
    },
    /// Time some landings and print the `block` of a sweep that takes so many seconds
    Block(BlockArgs),
    /// Print a job script for Slurm: an array of tasks, each a part of the campaign, and behind them the job that merges
    Slurm(SlurmArgs),
    /// Fly landings of a campaign again and record all their signals as MCAP files, for Foxglove and PlotJuggler
    Replay {
        /// Sweep, such as the `sweep.toml` in a campaign's folder
        sweep: PathBuf,
        /// Number of the landing, as the report and the column `landing` of the blocks have it: trials per point times the point's number from
        /// 0, plus the trial; repeatable
        #[arg(long = "landing", value_name = "N", required = true)]
        landings: Vec<u64>,
        /// Folder for the files
        #[arg(long)]
        mcap: PathBuf,
    },
}

const SLURM: &str = "\
Examples:
  touchdown campaign slurm sweep.toml --tasks 200 --cpus 4 --time 02:00:00 --out /shared/campaign > campaign.sh
  bash campaign.sh                                  submits; further options are those of sbatch
  bash campaign.sh --partition=long --account=me
  touchdown campaign status /shared/campaign        while it runs

Nodes need the program, the sweep and the folder at the same paths; the variable TOUCHDOWN names another program.
A task that is preempted, loses its node or runs out of time is queued again and flies only the blocks that are missing.
What is written has the same bytes as a campaign on one machine. Logs of the tasks are in the folder slurm/ of --out.";

/// Arguments of `touchdown campaign block`.
#[derive(Args, Debug)]
pub(crate) struct BlockArgs {
    /// Sweep
    pub(crate) sweep: PathBuf,
    /// Time of a block on one core, in seconds: what is lost at most where a run is killed
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = seconds)]
    pub(crate) seconds: f64,
    /// Landings at every point [default: the sweep's]
    #[arg(long)]
    pub(crate) trials: Option<u64>,
    /// Seed of all random numbers [default: the sweep's]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
}

/// A time above zero.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(s) if s > 0.0 && s.is_finite() => Ok(s),
        _ => Err("expected seconds, a number above 0".into()),
    }
}

/// Arguments of `touchdown campaign slurm`.
#[derive(Args, Debug)]
#[command(after_help = SLURM)]
pub(crate) struct SlurmArgs {
    /// Sweep
    pub(crate) sweep: PathBuf,
    /// Tasks of the array, at most one for each block of landings; many clusters allow 1000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) tasks: u64,
    /// Cores of each task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub(crate) cpus: u16,
    /// Time limit of a task, as sbatch takes it [default: the cluster's]
    #[arg(long, value_parser = super::super::slurm::time_limit)]
    pub(crate) time: Option<String>,
    /// Landings at every point [default: the sweep's]
    #[arg(long)]
    pub(crate) trials: Option<u64>,
    /// Seed of all random numbers [default: the sweep's]
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Folder of the campaign, on a disk that all nodes see
    #[arg(long, default_value = "out/campaign")]
    pub(crate) out: PathBuf,
}

/// Names of controllers; the last two fly in six degrees of freedom only.
fn controllers() -> PossibleValuesParser {
    PossibleValuesParser::new(Method::ALL.map(Method::name))
}
