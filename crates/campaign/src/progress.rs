//! Progress of long work, reported to the caller.

/// Receiver of progress reports; called from many threads.
pub trait Progress: Sync {
    /// A stage of `steps` steps begins.
    fn stage(&self, name: &str, steps: u64);
    /// One step of the stage is done.
    fn step(&self);
    /// A step is complete, such as a written file. It serves logs without a progress bar.
    fn done(&self, _what: &str) {}
}

/// Reports to no one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64) {}
    fn step(&self) {}
}
