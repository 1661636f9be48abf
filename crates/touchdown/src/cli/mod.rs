//! The command line: arguments, dispatch, and the one place that turns an outcome into an exit status.

mod args;
mod block_size;
mod campaign;
mod context;
mod export;
mod fly;
mod identify;
mod inspect;
mod land;
mod live;
mod output;
mod reproduce;
mod rig;
mod settings;
mod simulator;
mod slurm;
mod software_in_the_loop;
mod validate;

use std::process::ExitCode;

use touchdown::{Error, Result};
use touchdown_terminal::{Done, Terminal, manual};

use args::{Arguments, Command};
use context::Context;

/// Parses the arguments, runs the command and returns the exit status.
pub(crate) fn main() -> ExitCode {
    let arguments: Arguments = match touchdown_terminal::parse() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let context = Context(Terminal::new(arguments.output));
    let outcome = dispatch(&context, arguments.command);
    context.0.conclude(outcome, Error::exit_status)
}

fn dispatch(context: &Context, command: Command) -> Result<Done> {
    match command {
        Command::Reproduce(args) => reproduce::run(context, &args),
        Command::Rig(args) => rig::run(context, &args),
        Command::Inspect(args) => inspect::run(context, &args),
        Command::Identify(args) => identify::run(context, &args),
        Command::Validate(args) => validate::run(context, &args),
        Command::Export(args) => export::run(context, &args),
        Command::Land(args) => land::run(context, &args),
        Command::Campaign(args) => campaign::run(context, &args),
        Command::Fly(args) => fly::run(context, &args),
        Command::Simulator(args) => simulator::run(context, &args),
        Command::Settings(args) => settings::run(context, &args),
        Command::Completions { shell } => {
            manual::completions::<Arguments>(context, shell);
            Ok(Done::Whole)
        }
        Command::Man { out } => {
            let written = manual::pages::<Arguments>(context, &out);
            written.map_err(|(path, e)| Error::file(&path, e))?;
            Ok(Done::Whole)
        }
    }
}
