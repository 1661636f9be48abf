//! The command line: arguments, dispatch, and the one place that turns an outcome into an exit status.

mod args;
mod campaign;
mod context;
mod identify;
mod inspect;
mod land;
mod output;
mod reproduce;
mod rig;
mod settings;
mod validate;

use std::process::ExitCode;

use clap::Parser as _;
use touchdown::Result;

use args::{Arguments, Command};
use context::Context;

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Done {
    /// All input was used.
    Whole,
    /// Done, but input was lost.
    WithLoss,
}

/// Parses the arguments, runs the command, gives the exit status: 0 done, 1 failed, 2 bad arguments, maps,
/// settings or cards, 3 done but input was lost.
pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let context = Context::new(arguments.json, arguments.quiet);
    let done = dispatch(&context, arguments.command);
    match done.and_then(|done| context.all_printed().map(|()| done)) {
        Ok(Done::Whole) => ExitCode::SUCCESS,
        Ok(Done::WithLoss) => ExitCode::from(3),
        Err(error) => {
            context.fail(&error);
            ExitCode::from(error.exit_status())
        }
    }
}

fn dispatch(context: &Context, command: Command) -> Result<Done> {
    match command {
        Command::Reproduce(args) => reproduce::run(context, &args),
        Command::Rig(args) => rig::run(context, &args),
        Command::Inspect(args) => inspect::run(context, &args),
        Command::Identify(args) => identify::run(context, &args),
        Command::Validate(args) => validate::run(context, &args),
        Command::Land(args) => land::run(context, &args),
        Command::Campaign(args) => campaign::run(context, &args),
        Command::Settings(args) => settings::run(context, &args),
    }
}
