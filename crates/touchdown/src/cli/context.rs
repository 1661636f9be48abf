//! What all commands share: the terminal, as the library's progress knows it.

use std::ops::Deref;

use touchdown::progress::Progress;
use touchdown_terminal::Terminal;

/// The terminal, to which the library reports its progress.
pub(crate) struct Context(pub(crate) Terminal);

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
