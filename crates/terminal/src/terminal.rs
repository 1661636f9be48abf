//! Text for people, JSON for programs, progress, and how a command ends.

use std::fmt::Display;
use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use clap::error::ErrorKind;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::escape;
use crate::failure::{failure, refusal};
use crate::interrupt::Interrupt;
use crate::status::{BAD_INPUT, Done, FAILED};

/// Time from one picture of the spinner to the next: quick enough to look alive, slow enough to cost nothing.
const TICK: Duration = Duration::from_millis(120);

/// Where output goes; every command has these options.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Output {
    /// Print one JSON object on standard output; text and progress go to standard error
    ///
    /// A command that fails prints `{"error": "...", "outcome": "refused"}`. Standard error has the same text, and the exit
    /// status is the same as without --json.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print no progress
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// The arguments of the process. Where they do not parse, or ask for help or the version, this prints the answer and
/// returns the exit status.
///
/// # Errors
/// The exit status with which the process must end.
pub fn parse<A: clap::Parser>() -> Result<A, ExitCode> {
    A::try_parse().map_err(|error| {
        if error.use_stderr() {
            let mut before_dashes = std::env::args_os().take_while(|a| a != "--");
            if before_dashes.any(|a| a == "--json") {
                let text = match error.kind() {
                    // What is rendered then is the whole help.
                    ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                        "expected a subcommand, found none".to_owned()
                    }
                    _ => error.render().to_string(),
                };
                let text = text.strip_prefix("error: ").unwrap_or(&text);
                // Usage follows a blank line.
                let text = text.split("\n\n").next().unwrap_or_default();
                let _ = writeln!(anstream::stdout(), "{}", refusal(text, "refused"));
            }
        }
        // A reader that has gone away is no failure of ours. Arguments that are shown again are escaped.
        let text = error.render().to_string();
        if escape::text(&text) == text {
            let _ = error.print();
        } else {
            let _ = write!(anstream::stderr(), "{}", escape::text(&text));
        }
        ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(BAD_INPUT))
    })
}

/// The terminal of a running command.
pub struct Terminal {
    json: bool,
    bar: ProgressBar,
    /// Whether lines replace the bar that nobody sees.
    lines: bool,
    /// Why standard output did not take the result.
    unprinted: Mutex<Option<String>>,
    interrupt: Interrupt,
}

impl Terminal {
    /// The terminal by the options; it answers Ctrl-C from now on.
    #[must_use]
    pub fn new(output: Output) -> Self {
        let target = if output.quiet {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        Self {
            json: output.json,
            lines: !output.quiet && !std::io::stderr().is_terminal(),
            unprinted: Mutex::new(None),
            interrupt: Interrupt::install(output.json, bar.clone()),
            bar,
        }
    }

    /// Whether JSON was asked for.
    #[must_use]
    pub fn wants_json(&self) -> bool {
        self.json
    }

    /// Sets what Ctrl-C says from now on: what the command has written. Without it, nothing was written.
    pub fn if_interrupted(&self, report: impl Fn() -> String + Send + 'static) {
        self.interrupt.says(report);
    }

    /// Answers Ctrl-C even if the process was started with an ignored one, as a job in the background of a script is.
    pub fn insist_on_interrupts(&self) {
        self.interrupt.insist();
    }

    /// A stage of `steps` steps begins.
    pub fn stage(&self, name: &str, steps: u64) {
        self.style("{msg:>20} [{bar:32}] {pos}/{len}  {elapsed} elapsed, {eta} left");
        self.bar.reset();
        self.bar.set_length(steps);
        self.bar.set_position(0);
        self.bar.set_message(escape::line(name).into_owned());
    }

    /// One step of the stage is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// A stage of unknown length begins.
    pub fn busy(&self, stage: &str) {
        self.style("{spinner} {elapsed}  {msg}");
        self.bar.enable_steady_tick(TICK);
        self.bar.set_message(escape::line(stage).into_owned());
    }

    fn style(&self, template: &str) {
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style.progress_chars("=> "));
        }
    }

    /// A line of progress, for logs in which no bar is drawn.
    pub fn done(&self, what: &str) {
        if self.lines {
            let _ = writeln!(anstream::stderr(), "{}", escape::line(what));
        }
    }

    /// Removes the progress bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Text for people: on standard output, or on standard error where standard output has the JSON object.
    pub fn say(&self, text: &str) {
        if self.json {
            self.aside(text);
        } else {
            self.print(&format!("{text}\n"));
        }
    }

    /// Text for people on standard error.
    pub fn aside(&self, text: &str) {
        self.bar.suspend(|| {
            let _ = writeln!(anstream::stderr(), "{}", escape::text(text));
        });
    }

    /// A warning, on standard error.
    pub fn warn(&self, text: &str) {
        self.aside(&format!("warning: {}", escape::line(text)));
    }

    /// Text on standard output.
    pub fn print(&self, text: &str) {
        self.write(&escape::text(text));
    }

    /// Text without characters that command a terminal, on standard output.
    fn write(&self, text: &str) {
        let written = self.bar.suspend(|| {
            let mut out = anstream::stdout();
            out.write_all(text.as_bytes()).and_then(|()| out.flush())
        });
        // A reader that has gone away is no failure of ours.
        if let Err(e) = written
            && e.kind() != std::io::ErrorKind::BrokenPipe
        {
            self.did_not_print(format!("standard output: {e}"));
        }
    }

    /// The JSON object of a command, if it was asked for.
    pub fn object<T: Serialize>(&self, object: &T) {
        if self.json {
            match serde_json::to_string_pretty(object) {
                Ok(text) => self.write(&format!("{}\n", escape::json(&text))),
                Err(e) => self.did_not_print(format!("the result cannot be written as JSON: {e}")),
            }
        }
    }

    fn did_not_print(&self, why: String) {
        let mut unprinted = self
            .unprinted
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        unprinted.get_or_insert(why);
    }

    /// Ends a command: prints its error, if there is one, and returns the exit status; `status` gives that of an error.
    pub fn conclude<E: Display>(
        self,
        outcome: Result<Done, E>,
        status: impl Fn(&E) -> u8,
    ) -> ExitCode {
        self.finish();
        let unprinted = self.unprinted.into_inner();
        let (error, status) = match (outcome, unprinted.unwrap_or_else(PoisonError::into_inner)) {
            (Ok(done), None) => return done.into(),
            (Ok(_), Some(why)) => (why, FAILED),
            (Err(error), _) => (error.to_string(), status(&error)),
        };
        failure(self.json, &error, "refused");
        ExitCode::from(status)
    }
}
