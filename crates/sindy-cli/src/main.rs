//! The command `sindy`: finds the differential equations behind measured trajectories, and runs them.

mod args;
mod context;
mod drawing;
mod error;
mod fit;
mod named;
mod output;
mod past;
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
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return misused(&error),
    };
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

/// Arguments that do not parse, or a wish for help or the version. Where JSON was asked for, there is an object too.
fn misused(error: &clap::Error) -> ExitCode {
    if error.use_stderr() {
        let before_dashes = std::env::args_os().take_while(|a| a != "--");
        let json = before_dashes.into_iter().any(|a| a == "--json");
        let text = error.render().to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        // What follows a blank line is usage.
        let text = text.split("\n\n").next().unwrap_or_default();
        Context::new(json, true).refuse(text);
    }
    // A reader that has gone away is no failure of ours.
    let _ = error.print();
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

fn dispatch(context: &Context, command: Command) -> Result<Done> {
    match command {
        Command::Fit(args) => fit::run(context, &args),
        Command::Simulate(args) => simulate::run(context, &args),
        Command::Settings => fit::settings::print(context),
    }
}
