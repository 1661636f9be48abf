//! The command `sindy`: finds the differential equations behind measured trajectories, and runs them.

mod args;
mod drawing;
mod error;
mod fit;
mod implicit;
mod named;
mod numbers;
mod output;
mod pde;
mod simulate;
mod table;
mod trajectories;

use std::process::ExitCode;

use touchdown_terminal::{Done, Terminal, manual};

use args::{Arguments, Command};
use error::{Error, Result};

fn main() -> ExitCode {
    let arguments: Arguments = match touchdown_terminal::parse() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let terminal = Terminal::new(arguments.output);
    let outcome = dispatch(&terminal, arguments.command);
    terminal.conclude(outcome, Error::exit_status)
}

fn dispatch(terminal: &Terminal, command: Command) -> Result<Done> {
    match command {
        Command::Fit(args) => fit::run(terminal, &args),
        Command::Implicit(args) => implicit::run(terminal, &args),
        Command::Pde(args) => pde::run(terminal, &args),
        Command::Merge(args) => fit::merge(terminal, &args),
        Command::Simulate(args) => simulate::run(terminal, &args),
        Command::Settings => fit::settings::print(terminal),
        Command::Completions { shell } => {
            manual::completions::<Arguments>(terminal, shell);
            Ok(Done::Whole)
        }
        Command::Man { out } => {
            let written = manual::pages::<Arguments>(terminal, &out);
            written.map_err(|(path, e)| Error::file(&path, e))?;
            Ok(Done::Whole)
        }
    }
}
