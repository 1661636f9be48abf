//! The arguments of `sindy implicit`.

use std::path::PathBuf;

use clap::Args;

use crate::table::TableArgs;
use crate::table::args::name;

/// Find rational equations, x' = N/D, behind measured trajectories.
///
/// Reactions with enzymes, switches, predators that are satiated and linked bodies divide: x' = 0.6 - 1.5 x/(0.3 + x). Each state's
/// rate of change is written as a sum of few terms over another, and as a plain sum where that explains the data as well. Terms of
/// numerator and denominator, smoothing and coefficients are chosen from the data. Each equation is judged by the trajectories that
/// follow from it. The first term of each denominator has the coefficient 1. Warnings name other relations that are likely as
/// well, and models that leave more than the noise. Noise of several percent on short records can hide terms, and a library
/// without the truth can approximate it to within the noise; no warning can name either.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ImplicitArgs {
    /// Data: CSV with a header, Parquet or NumPy arrays (.npy); each file is a trajectory, unless --trajectory splits it
    #[arg(required = true, value_name = "DATA")]
    pub(crate) data: Vec<PathBuf>,
    /// Columns that are states: what the equations are for
    #[arg(long, required = true, value_name = "x,y", value_delimiter = ',', value_parser = name)]
    pub(crate) states: Vec<String>,
    /// Columns that act on the states from outside
    #[arg(long, value_name = "u,v", value_delimiter = ',', value_parser = name)]
    pub(crate) inputs: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
    /// Column of weights, at least 0: rows do not count alike
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) weights: Option<String>,
    /// Candidate terms of numerators, as `sindy fit` has them; repeatable, they add up
    #[arg(long, value_name = "TEXT", default_value = "poly(3)")]
    pub(crate) library: Vec<String>,
    /// Candidate terms of denominators; repeatable, they add up. The constant is always one of them
    #[arg(long, value_name = "TEXT", default_value = "poly(2)")]
    pub(crate) denominator: Vec<String>,
    /// Equation that is known, such as `x' = v`; repeatable
    #[arg(long, value_name = "EQUATION")]
    pub(crate) known: Vec<String>,
    /// File for the model, which `sindy simulate` reads
    #[arg(long, value_name = "OUT.json")]
    pub(crate) model: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  sindy implicit enzyme.csv --states x
  sindy implicit prey.csv --states x,y --library 'poly(3)' --denominator 'poly(1)' --model prey.json
  sindy implicit cart.csv --states q,v --inputs u --known \"q' = v\" \\
      --library 'sin(q) + cos(q)*sin(q) + v^2*sin(q) + u + v' --denominator 'cos(q)^2'
  sindy simulate prey.json --data prey.csv --figure compare.html

Candidates that the physics rules out are best left out: with fewer of them less data and more noise suffice.";
