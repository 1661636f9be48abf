//! What all commands share: where text, progress and JSON go.

use std::io::{IsTerminal as _, Write as _};
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use touchdown::progress::Progress;
use touchdown::{Error, Result};

/// Global options, made into sinks.
pub(crate) struct Context {
    json: bool,
    bar: ProgressBar,
    /// Whether to tell in lines what a bar would show.
    lines: bool,
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
        if let Ok(style) = ProgressStyle::with_template(
            "{msg:>20} [{bar:32}] {pos}/{len}  {elapsed} elapsed, {eta} left",
        ) {
            bar.set_style(style.progress_chars("=> "));
        }
        Self {
            json,
            bar,
            lines: !quiet && !std::io::stderr().is_terminal(),
            refused: Mutex::new(None),
        }
    }

    /// Text for people: on standard output, or on standard error where that is kept for JSON.
    pub(crate) fn say(&self, text: &str) {
        if self.json {
            self.bar.suspend(|| {
                let _ = writeln!(anstream::stderr(), "{text}");
            });
        } else {
            self.print(&format!("{text}\n"));
        }
    }

    /// Text on standard output. A reader that has gone away is no failure of ours; any other refusal is kept.
    fn print(&self, text: &str) {
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
        self.bar.suspend(|| {
            let _ = writeln!(anstream::stderr(), "warning: {text}");
        });
    }

    /// The one JSON object of a command, if it was asked for.
    pub(crate) fn object<T: Serialize>(&self, object: &T) -> Result<()> {
        if self.json {
            let text = super::output::json(object)?;
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
    }

    /// Takes the progress bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Context {
    fn stage(&self, name: &str, steps: u64) {
        self.bar.reset();
        self.bar.set_length(steps);
        self.bar.set_position(0);
        self.bar.set_message(name.to_string());
    }

    fn step(&self) {
        self.bar.inc(1);
    }

    fn done(&self, what: &str) {
        if self.lines {
            let _ = writeln!(anstream::stderr(), "{what}");
        }
    }
}
