//! The arguments of `sindy simulate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::table::TableArgs;
use crate::table::args::positive;

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
