//! Ctrl-C, SIGTERM and SIGHUP: waits for files that are being written, says what was written, and ends the process.

use std::sync::{Arc, Mutex, PoisonError};

use indicatif::ProgressBar;

use crate::failure::failure;
use crate::status::INTERRUPTED;

/// Says what a command has written so far.
type Report = Box<dyn Fn() -> String + Send>;

/// What the handler of Ctrl-C will say, and where.
#[derive(Clone)]
pub(crate) struct Interrupt {
    report: Arc<Mutex<Report>>,
    json: bool,
    bar: ProgressBar,
}

impl Interrupt {
    /// Handles these signals from now on, if nobody else does and none is ignored, as in a job in the background of a script.
    pub(crate) fn install(json: bool, bar: ProgressBar) -> Self {
        let report: Report = Box::new(|| "nothing was written".to_owned());
        let interrupt = Self {
            report: Arc::new(Mutex::new(report)),
            json,
            bar,
        };
        // Without a handler, Ctrl-C ends the process all the same.
        let _ = ctrlc::try_set_handler(interrupt.handler());
        interrupt
    }

    /// Handles Ctrl-C even if the process was started with an ignored one.
    pub(crate) fn insist(&self) {
        // A handler of ours that is there already stays.
        let _ = ctrlc::set_handler(self.handler());
    }

    /// Says what was written, and ends the process.
    fn handler(&self) -> impl FnMut() + Send + 'static {
        let handled = self.clone();
        move || {
            let _no_file_is_half_written = touchdown_files::pause();
            handled.bar.finish_and_clear();
            let report = handled
                .report
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            let text = format!("interrupted: {}", report());
            failure(handled.json, &text, "interrupted");
            std::process::exit(i32::from(INTERRUPTED));
        }
    }

    pub(crate) fn says(&self, report: impl Fn() -> String + Send + 'static) {
        *self.report.lock().unwrap_or_else(PoisonError::into_inner) = Box::new(report);
    }
}
