//! The command `sindy`: finds the differential equations behind measured trajectories, and runs them.

mod args;
mod context;
mod drawing;
mod error;
mod fit;
mod named;
mod output;
mod simulate;
mod table;
mod trajectories;

use std::process::ExitCode;

use clap::Parser as _;

use args::{Arguments, Command};
use context::Context;
use error::Result;

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum Done {
    /// All input was used.
    Whole,
    /// Done, but input was lost.
    WithLoss,
}

/// Parses the arguments, runs the command, gives the exit status: 0 done, 1 failed, 2 bad arguments, data or
/// settings, 3 done but input was lost.
fn main() -> ExitCode {
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
        Command::Fit(args) => fit::run(context, &args),
        Command::Simulate(args) => simulate::run(context, &args),
        Command::Settings => fit::settings::print(context),
    }
}
