//! All arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use touchdown_terminal::{EXIT_STATUS, Output, Shell};

use crate::fit::args::FitArgs;

/// Finds the differential equations behind measured trajectories, with few terms, and runs them.
///
/// `sindy fit` reads tables of measurements and chooses smoothing, terms and coefficients by itself. `sindy simulate` runs
/// the model that it found.
#[derive(Debug, Parser)]
#[command(name = "sindy", version, after_help = format!("{EXAMPLES}\n\n{EXIT_STATUS}"))]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) output: Output,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  sindy fit measured.csv --states x,y,z
  sindy fit run1.csv run2.csv --states x,y --inputs u --library 'poly(3)' --test run3.csv --model model.json
  sindy simulate model.json --start x=1,y=0 --until 10 --step 0.01 --output run.csv
  sindy simulate model.json --data measured.csv --figure compare.svg";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Find the equations behind measured trajectories
    Fit(Box<FitArgs>),
    /// Run a model, from a start of your own or beside measured trajectories
    Simulate(Box<SimulateArgs>),
    /// Print the default settings of `fit` as commented TOML
    Settings,
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
  sindy completions bash > ~/.local/share/bash-completion/completions/sindy
  sindy completions fish > ~/.config/fish/completions/sindy.fish";

const MAN: &str = "\
Examples:
  sindy man --out ~/.local/share/man/man1
  man sindy-fit";

/// How tables are read.
#[derive(Args, Debug)]
pub(crate) struct TableArgs {
    /// Column of times [default: the column `t`, `time` or `time_s`, else `t_s`, `timestamp` or `timestamp_s`]
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) time: Option<String>,
    /// Time from row to row, for tables without a column of times
    #[arg(long, value_name = "STEP", conflicts_with = "time", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) dt: Option<f64>,
    /// Column whose values separate trajectories; without it, each file is one trajectory
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) trajectory: Option<String>,
    /// Names of the columns of NumPy arrays, in order
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) columns: Vec<String>,
}

/// Run a model.
///
/// Beside measured trajectories (`--data`), each run starts at a trajectory's first row and has its times and inputs.
/// From a start of your own (`--start`), it lasts from 0 until `--until`.
#[derive(Args, Debug)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub(crate) struct SimulateArgs {
    /// Model as `sindy fit --model` writes it
    pub(crate) model: PathBuf,
    /// Measured trajectories to run beside: CSV, Parquet or NumPy array
    #[arg(long, value_name = "FILE", required_unless_present = "start", conflicts_with_all = ["start", "until", "step"])]
    pub(crate) data: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
    /// Start of the run: a value for each state
    #[arg(long, value_name = "x=1,y=2", value_delimiter = ',')]
    pub(crate) start: Vec<String>,
    /// End of the run, which begins at time 0, or with the inputs of a table [default: the last time of that table]
    #[arg(long, value_name = "TIME", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) until: Option<f64>,
    /// Time from row to row of the result [default: a thousandth of the run, or the period of a discrete model]
    #[arg(long, value_name = "TIME", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// An input as an expression of the time t; repeatable
    #[arg(long = "input", value_name = "u=EXPRESSION", conflicts_with = "data")]
    pub(crate) inputs: Vec<String>,
    /// Table with times and the model's inputs
    #[arg(long, value_name = "FILE", conflicts_with_all = ["inputs", "data"])]
    pub(crate) inputs_from: Option<PathBuf>,
    /// What inputs are between their samples
    #[arg(long, value_name = "HOW", default_value = "linear")]
    pub(crate) between: Between,
    /// Integrate by Runge-Kutta of order 4 in steps of at most this, instead of adaptively
    #[arg(long, value_name = "TIME", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fixed_step: Option<f64>,
    /// CSV for the runs; `-` is standard output
    #[arg(long, value_name = "OUT.csv")]
    pub(crate) output: Option<PathBuf>,
    /// Figure of the runs (.svg, .png or .html)
    #[arg(long, value_name = "OUT")]
    pub(crate) figure: Option<PathBuf>,
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  sindy simulate model.json --start x=1,y=0 --until 10 --step 0.01 --output run.csv
  sindy simulate model.json --start x=1 --until 10 --input 'u=0.5*sin(2*t)' --output -
  sindy simulate model.json --start x=1 --until 10 --inputs-from inputs.csv --figure run.svg
  sindy simulate model.json --data test.csv --trajectory run --figure compare.html --json";

/// What inputs are between their samples.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub(crate) enum Between {
    /// The value of the sample before
    Hold,
    /// A straight line
    Linear,
    /// A cubic spline
    Cubic,
}

/// The name of a column, without spaces around it.
pub(crate) fn name(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("expected the name of a column, found nothing".to_owned()),
        name => Ok(name.to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number".to_owned()),
    }
}
