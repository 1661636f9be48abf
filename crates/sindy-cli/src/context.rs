//! What all commands share: where text, progress and JSON go.

use std::io::Write as _;
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::error::{Error, Result};

/// Time from one picture of the spinner to the next.
const TICK: Duration = Duration::from_millis(120);

/// The object of a command that failed.
#[derive(Serialize)]
struct Refusal<'a> {
    error: &'a str,
    outcome: &'a str,
}

/// Global options, made into sinks.
pub(crate) struct Context {
    json: bool,
    bar: ProgressBar,
    /// What standard output refused to take, if it did.
    refused: Mutex<Option<std::io::Error>>,
}

impl Context {
    pub(crate) fn new(json: bool, quiet: bool) -> Self {
        let target = if quiet {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed}  {msg}") {
            bar.set_style(style);
        }
        Self {
            json,
            bar,
            refused: Mutex::new(None),
        }
    }

    /// A stage of unknown length begins.
    pub(crate) fn busy(&self, stage: &str) {
        self.bar.enable_steady_tick(TICK);
        self.bar.set_message(stage.to_owned());
    }

    /// Text for people: on standard output, or on standard error where that is kept for JSON.
    pub(crate) fn say(&self, text: &str) {
        if self.json {
            self.aside(text);
        } else {
            self.print(&format!("{text}\n"));
        }
    }

    /// Text for people on standard error.
    pub(crate) fn aside(&self, text: &str) {
        self.bar.suspend(|| {
            let _ = writeln!(anstream::stderr(), "{text}");
        });
    }

    /// Text on standard output. A reader that has gone away is no failure of ours; any other refusal is kept.
    pub(crate) fn print(&self, text: &str) {
        let written = self.bar.suspend(|| {
            let mut out = anstream::stdout();
            out.write_all(text.as_bytes()).and_then(|()| out.flush())
        });
        if let Err(e) = written
            && e.kind() != std::io::ErrorKind::BrokenPipe
            && let Ok(mut refused) = self.refused.lock()
        {
            refused.get_or_insert(e);
        }
    }

    /// Fails where standard output did not take what was printed.
    pub(crate) fn all_printed(&self) -> Result<()> {
        let refused = self.refused.lock().ok().and_then(|mut r| r.take());
        refused.map_or(Ok(()), |e| Err(Error::file("standard output".as_ref(), e)))
    }

    /// A warning, on standard error.
    pub(crate) fn warn(&self, text: &str) {
        self.aside(&format!("warning: {text}"));
    }

    /// The one JSON object of a command, if it was asked for.
    pub(crate) fn object<T: Serialize>(&self, object: &T) -> Result<()> {
        if self.json {
            let mut text = serde_json::to_string_pretty(object).map_err(|e| {
                Error::Arguments(format!("the result cannot be written as JSON: {e}"))
            })?;
            text.push('\n');
            self.print(&text);
        }
        Ok(())
    }

    /// Whether JSON was asked for.
    pub(crate) fn wants_json(&self) -> bool {
        self.json
    }

    /// Tells an error.
    pub(crate) fn fail(&self, error: &Error) {
        self.bar.finish_and_clear();
        let _ = writeln!(anstream::stderr(), "error: {error}");
        self.refuse(&error.to_string());
    }

    /// The object of a command that failed, if JSON was asked for: one can be read whatever happened.
    pub(crate) fn refuse(&self, error: &str) {
        let outcome = "refused";
        // Text alone can always be written.
        let _ = self.object(&Refusal { error, outcome });
    }

    /// Takes the progress bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
