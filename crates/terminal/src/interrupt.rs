//! Ctrl-C: waits for files that are being written, says what was written, and ends the process.

use std::sync::{Arc, Mutex, PoisonError};

use indicatif::ProgressBar;

use crate::failure::failure;
use crate::status::INTERRUPTED;

/// Says what a command has written so far.
type Report = Box<dyn Fn() -> String + Send>;

/// What the handler of Ctrl-C will say.
#[derive(Clone)]
pub(crate) struct Interrupt(Arc<Mutex<Report>>);

impl Interrupt {
    /// Handles Ctrl-C from now on, if nobody else does.
    pub(crate) fn install(json: bool, bar: ProgressBar) -> Self {
        let report: Report = Box::new(|| "nothing was written".to_owned());
        let interrupt = Self(Arc::new(Mutex::new(report)));
        let handled = interrupt.clone();
        // Without a handler, Ctrl-C ends the process all the same.
        let _ = ctrlc::try_set_handler(move || {
            let _no_file_is_half_written = touchdown_files::pause();
            bar.finish_and_clear();
            let report = handled.0.lock().unwrap_or_else(PoisonError::into_inner);
            failure(json, &format!("interrupted: {}", report()), "interrupted");
            std::process::exit(i32::from(INTERRUPTED));
        });
        interrupt
    }

    pub(crate) fn says(&self, report: impl Fn() -> String + Send + 'static) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Box::new(report);
    }
}
