//! Progress of long work, told to whoever wants to show it.

/// Told about progress; called from many threads.
pub trait Progress: Sync {
    /// A stage of `steps` steps begins.
    fn stage(&self, name: &str, steps: u64);
    /// One step of the stage is done.
    fn step(&self);
    /// Something is done for good, such as a file that is written: for logs, where no bar is drawn.
    fn done(&self, _what: &str) {}
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64) {}
    fn step(&self) {}
}
