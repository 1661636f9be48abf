//! All arguments.

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use touchdown_terminal::{EXIT_STATUS, Output, Shell};

use crate::fit::MergeArgs;
use crate::fit::args::FitArgs;
use crate::implicit::args::ImplicitArgs;
use crate::pde::args::PdeArgs;
use crate::simulate::args::SimulateArgs;

/// Finds the differential equations behind measured trajectories, with few terms, and runs them.
///
/// `sindy fit` reads tables of measurements and chooses smoothing, terms and coefficients by itself. `sindy simulate` runs
/// the model that it found. `sindy implicit` finds rational equations, `sindy pde` those of fields over time and space.
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
  sindy implicit enzyme.csv --states x --model enzyme.json
  sindy pde field.npz
  sindy simulate model.json --start x=1,y=0 --until 10 --step 0.01 --output run.csv
  sindy simulate model.json --data measured.csv --figure compare.svg";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Find the equations behind measured trajectories
    Fit(Box<FitArgs>),
    /// Find rational equations, D(x) x' = N(x), behind measured trajectories
    Implicit(Box<ImplicitArgs>),
    /// Find the partial differential equations behind fields on a grid
    Pde(Box<PdeArgs>),
    /// Put partial sums of `fit --stream --partial` together and end the fit
    Merge(MergeArgs),
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
