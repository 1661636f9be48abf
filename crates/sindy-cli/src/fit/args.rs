//! The arguments of `sindy fit`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use sindy::identify::NoiseSource;

use super::stream::Shard;
use crate::error::{Error, Result};
use crate::table::TableArgs;
use crate::table::args::name;

/// Find the equations behind measured trajectories.
///
/// Each state's rate of change is written as a sum of few candidate terms. Smoothing, terms and coefficients are chosen
/// from the data; no option but --states is needed. Each file is a trajectory, unless --trajectory splits it.
///
/// Columns may have rates of their own: a cell is empty where its column was not measured. Each state is smoothed at its own times and
/// compared where it was measured, and inputs are interpolated. Up to three lost values in succession are bridged, and more where
/// values are often lost. Longer gaps split the trajectory, and so does every empty cell with --discrete or --stream.
#[derive(Args, Debug)]
#[command(after_help = FIT_EXAMPLES)]
pub(crate) struct FitArgs {
    /// Training data: CSV with a header, Parquet or NumPy arrays (.npy)
    #[arg(required = true, value_name = "TRAIN")]
    pub(crate) train: Vec<PathBuf>,
    /// Columns that are states: what the equations are for
    #[arg(long, required = true, value_name = "x,y,z", value_delimiter = ',', value_parser = name)]
    pub(crate) states: Vec<String>,
    /// Columns that act on the states from outside; the column of times among them lets time stand in candidate terms
    #[arg(long, value_name = "u,v", value_delimiter = ',', value_parser = name)]
    pub(crate) inputs: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
    /// Column of weights, at least 0: rows do not count alike
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) weights: Option<String>,
    /// Candidate terms; repeatable, they add up [default: poly(3)]
    ///
    /// `poly(3)`: all monomials up to degree 3; `fourier(2)`: sines and cosines of two frequencies; `exp(1)`;
    /// `rational(0.5)`; of some variables only: `poly(2, x, y)`; products and sums: `poly(2)*fourier(1) + exp(1)`; or one
    /// term: `sin(x)*y`.
    #[arg(long, value_name = "TEXT")]
    pub(crate) library: Vec<String>,
    /// File of candidate terms, one on each line, added to those of --library; `#` begins a comment
    #[arg(long, value_name = "FILE")]
    pub(crate) terms: Option<PathBuf>,
    /// Past values as further variables of the candidates: `x@1` is x one row before, called `x_ago1` in terms;
    /// `x@1..3` the last three rows; `x@0.3s` what x was 0.3 units of time before; repeatable
    #[arg(
        long,
        value_name = "x@1,...",
        value_delimiter = ',',
        conflicts_with = "stream"
    )]
    pub(crate) past: Vec<String>,
    /// Part of an equation that is known; repeatable
    ///
    /// `x' = v` is the whole equation of x. `v' = -9.81 + ...` is a part of it, and the rest is looked for. With --second-order
    /// `x'' = -9.81 + ...`, with --discrete `x[k+1] = y`. Known terms have no standard error.
    #[arg(long, value_name = "EQUATION", conflicts_with = "stream")]
    pub(crate) known: Vec<String>,
    /// Sign that a coefficient must have, such as `v': v < 0`; repeatable
    ///
    /// The term has that sign or is left out. `v': v*abs(v) < 0` is the same for another candidate of the equation of v, with
    /// --second-order `x'': x_dot < 0`, with --discrete `x[k+1]: x > 0`. Terms are chosen among the subsets whose estimates keep
    /// all signs. A warning names signs that the data contradict.
    #[arg(long, value_name = "SIGN", conflicts_with = "stream")]
    pub(crate) sign: Vec<String>,
    /// Invariant that the equations keep, such as `v^2/2 - cos(x)`; repeatable
    ///
    /// An expression of the states. Terms are chosen among combinations that keep all invariants exactly, and coefficients of
    /// different equations keep the ratios that follow. Numbers in it are taken as exact. A warning tells where the data contradict
    /// the invariants. Not with --known, --sign, --second-order, --discrete or --stream.
    #[arg(
        long,
        value_name = "EXPRESSION",
        allow_hyphen_values = true,
        conflicts_with_all = ["stream", "known", "sign", "second_order", "discrete"]
    )]
    pub(crate) conserve: Vec<String>,
    /// Linear relation between coefficients that holds exactly, such as `[x': y] = -[y': x]`; repeatable
    ///
    /// `[x': y]` is the coefficient of the term y in the equation of x. `[x': x] + [y': y] = 0` is a sum, `[x'': y] = [y'': x]` is for
    /// states of second order. A relation has no constant: a coefficient that is known belongs to --known. A warning tells where the
    /// data contradict the relations. Not with --sign, --discrete or --stream.
    #[arg(
        long,
        value_name = "RELATION",
        allow_hyphen_values = true,
        conflicts_with_all = ["stream", "sign", "discrete"]
    )]
    pub(crate) constraint: Vec<String>,
    /// Find a model whose trajectories all stay bounded
    ///
    /// With candidates linear in the states all eigenvalues decay. With poly(2) the quadratic terms keep the energy |x|²/2, and there is
    /// a ball that every trajectory enters. A fit that is not stable moves to the nearest coefficients that are. A warning tells where
    /// the data contradict it. Without --library candidates are poly(2) of the states, and inputs. Not with --conserve, --constraint,
    /// --known, --sign, --second-order, --discrete, --past or --stream.
    #[arg(
        long,
        conflicts_with_all = ["stream", "conserve", "constraint", "known", "sign", "second_order", "discrete", "past"]
    )]
    pub(crate) stable: bool,
    /// Find x'' = f(x, x', u): positions are measured, velocities are not
    ///
    /// All states are positions, or those that --second-order=x,y names. The velocity of x is called `x_dot` in terms. It is
    /// estimated together with the model, so its column (if there is one) is better left out.
    #[arg(
        long,
        value_name = "x,y",
        value_delimiter = ',',
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = ALL,
        conflicts_with_all = ["stream", "discrete", "past"]
    )]
    pub(crate) second_order: Vec<String>,
    /// Where noise comes from: the measurement, disturbances of the system, both [default: found from the data]
    ///
    /// Noise of the measurement leaves the system alone: whole trajectories are followed. A disturbance stays in the state. With
    /// `process` rows count as states and each is predicted from the one before, with `both` a filter tells the two apart. The sizes of
    /// disturbances and noise are estimated with the equations. With --discrete `measurement` is known: without it the likelier of
    /// noise of the measurement and noise of the map is taken.
    #[arg(long, value_name = "SOURCE", conflicts_with = "stream")]
    pub(crate) noise: Option<Noise>,
    /// Candidate terms for the variance of disturbances, such as `poly(2)`; repeatable, they add up [default: a constant]
    ///
    /// In dx = f dt + g dW the squared diffusion g^2 of each state is then found as a sparse sum of these terms, as the drift f is of
    /// those of --library: `var(dx)/dt = 0.2 + 0.4*x^2`. Sums that are not positive on every row do not count. Disturbances of
    /// different states are independent. With --noise process or --noise both; not with --second-order, --discrete or --stream.
    #[arg(
        long,
        value_name = "TEXT",
        conflicts_with_all = ["stream", "discrete", "second_order"]
    )]
    pub(crate) diffusion: Vec<String>,
    /// Find a map from each sample to the next one, instead of rates of change
    #[arg(long)]
    pub(crate) discrete: bool,
    /// Trajectories to judge the model by, which the fit does not see; repeatable
    #[arg(long, value_name = "TEST")]
    pub(crate) test: Vec<PathBuf>,
    /// Settings that override the automatic choice
    #[arg(long, value_name = "S.toml")]
    pub(crate) settings: Option<PathBuf>,
    /// Read the training data once, part by part: for tables larger than memory
    ///
    /// Memory does not grow with the rows (tens of MB for tables of a few columns). Slopes, terms and coefficients come from all rows, by regression
    /// (best subsets and SR3). The refinement by output error, which would need the rows again, is left out: noisy data that fit
    /// into memory are fitted more accurately without --stream, in more time. The rows of a trajectory must follow each other.
    #[arg(long)]
    pub(crate) stream: bool,
    /// Write the sums of the pass to a file, from which `sindy merge` ends the fit: for many files on several machines
    ///
    /// Give every machine all files, in the same order, and the same options: the first 50 000 rows decide how slopes are
    /// taken, and the sums are added in the order of the files. --shard says which of them a machine passes over.
    #[arg(long, value_name = "OUT.json", requires = "stream", conflicts_with_all = ["model", "figure", "test"])]
    pub(crate) partial: Option<PathBuf>,
    /// Pass over the K-th of N equal parts of the files
    #[arg(long, value_name = "K/N", requires = "partial")]
    pub(crate) shard: Option<Shard>,
    /// File for the model, which `sindy simulate` reads
    #[arg(long, value_name = "OUT.json")]
    pub(crate) model: Option<PathBuf>,
    /// Figure of the choice and the fit (.svg, .png or .html)
    #[arg(long, value_name = "OUT")]
    pub(crate) figure: Option<PathBuf>,
}

/// Where noise comes from.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub(crate) enum Noise {
    /// The measurement alone, white or not
    Measurement,
    /// Disturbances of the system alone
    Process,
    /// Both
    Both,
}

impl From<Noise> for NoiseSource {
    fn from(noise: Noise) -> Self {
        match noise {
            Noise::Measurement => Self::Measurement,
            Noise::Process => Self::Process,
            Noise::Both => Self::Both,
        }
    }
}

/// All states, where `--second-order` stands alone; no column can have this name.
const ALL: &str = "(all)";

const FIT_EXAMPLES: &str = "\
Examples:
  sindy fit lorenz.csv --states x,y,z
  sindy fit flights.parquet --trajectory flight --states h,v --inputs throttle --library 'poly(2) + rational(0.5, h)'
  sindy fit runs.npy --columns t,x,y --states x,y --terms candidates.txt --json
  sindy fit swing.csv --states q --second-order --library 'poly(3) + sin(q)'
  sindy fit cart.csv --states x,v --inputs u --known \"x' = v\"
  sindy fit swing.csv --states q --second-order --sign \"q'': q_dot < 0\"
  sindy fit swing.csv --states x,v --library 'poly(2) + sin(x)' --conserve 'v^2/2 - cos(x)'
  sindy fit coupled.csv --states x,y --second-order --constraint \"[x'': y] = [y'': x]\"
  sindy fit gusts.csv --states x,v --noise both
  sindy fit prices.csv --states x --noise process --diffusion 'poly(2)'
  sindy fit driven.csv --states x --inputs t --library 'poly(2, x) + cos(2*t) + sin(2*t)'
  sindy fit map.csv --states x --discrete --past x@1 --model model.json
  sindy fit big.parquet --states x,y --stream
  sindy fit runs/*.parquet --states x,y --stream --partial 3.json --shard 3/64
  sindy fit a.csv b.csv --states x,y --test c.csv --model model.json --figure fit.html

Columns may carry a unit behind their name: --states x finds `x (m)`. Times are taken from the column `t`, `time` or
`time_s`, else from `t_s`, `timestamp` or `timestamp_s`; --time names another, --dt replaces it.";

impl FitArgs {
    /// The states whose velocities are not measured.
    pub(super) fn positions(&self) -> Vec<String> {
        match self.second_order.iter().any(|n| n == ALL) {
            true => self.states.clone(),
            false => self.second_order.clone(),
        }
    }

    /// Refuses a column that is to be two things at once.
    pub(super) fn check(&self) -> Result<()> {
        check_columns(
            &self.states,
            &self.inputs,
            self.weights.as_ref(),
            &self.table,
        )
    }
}

/// Refuses a column that is to be two things at once.
pub(crate) fn check_columns(
    states: &[String],
    inputs: &[String],
    weights: Option<&String>,
    table: &TableArgs,
) -> Result<()> {
    let states = states.iter().map(|n| ("--states", n));
    let inputs = inputs.iter().map(|n| ("--inputs", n));
    let others = [
        ("--weights", weights),
        ("--time", table.time.as_ref()),
        ("--trajectory", table.trajectory.as_ref()),
    ];
    let others = others
        .into_iter()
        .filter_map(|(argument, n)| n.map(|n| (argument, n)));
    let mut taken: Vec<(&str, &String)> = Vec::new();
    for (argument, name) in states.chain(inputs).chain(others) {
        match taken.iter().find(|(_, n)| *n == name) {
            // Time may stand in the equations as well.
            Some(("--inputs", _)) if argument == "--time" => {}
            Some((before, _)) if *before == argument => {
                return Err(Error::Arguments(format!(
                    "{argument}: `{name}` stands twice"
                )));
            }
            Some((before, _)) => {
                return Err(Error::Arguments(format!(
                    "{argument}: expected a column that is nothing else, found `{name}`, which {before} names too"
                )));
            }
            None => taken.push((argument, name)),
        }
    }
    Ok(())
}
