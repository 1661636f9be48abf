//! What all commands share: the terminal, as the library's progress knows it, and how files are announced.

use std::ops::Deref;
use std::path::Path;

use serde::Serialize;
use touchdown_campaign::progress::Progress;
use touchdown_terminal::Terminal;

use super::output;

/// The terminal, to which the library reports its progress.
pub(crate) struct Context(pub(crate) Terminal);

impl Context {
    /// Files in `folder` are written from now on. An interrupted command reports it.
    pub(crate) fn writes_into(&self, folder: &Path) {
        let folder = folder.display().to_string();
        self.if_interrupted(move || output::missing(&folder));
    }

    /// One JSON object on a line of its own, if JSON was asked for.
    pub(crate) fn line_object<T: Serialize>(&self, object: &T) {
        if let (true, Ok(text)) = (self.wants_json(), serde_json::to_string(object)) {
            self.print(&format!("{text}\n"));
        }
    }

    /// Ends a command that wrote a report into `folder`.
    pub(crate) fn reported<T: Serialize>(&self, text: &str, folder: &Path, results: &T) {
        self.finish();
        self.say(text);
        let report = folder.join("report.html");
        self.say(&format!("report: {}", report.display()));
        self.object(results);
    }
}

impl Deref for Context {
    type Target = Terminal;

    fn deref(&self) -> &Terminal {
        &self.0
    }
}

impl Progress for Context {
    fn stage(&self, name: &str, steps: u64) {
        self.0.stage(name, steps);
    }

    fn step(&self) {
        self.0.step();
    }

    fn done(&self, what: &str) {
        self.0.done(what);
    }
}
