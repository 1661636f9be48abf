//! Ctrl-C, and on Unix SIGTERM and SIGHUP: waits for files that are being written, says what was written, and ends the process.

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use indicatif::ProgressBar;

use crate::failure::failure;
use crate::status::INTERRUPTED;

/// Longest time for which the end of the process waits for a terminal, or for who reads its pipe.
const PRINTS: Duration = Duration::from_secs(1);

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
    /// Handles these signals from now on. An ignored Ctrl-C stays ignored, as in a job in the background of a script, and an
    /// ignored SIGHUP, as under `nohup`.
    pub(crate) fn install(json: bool, bar: ProgressBar) -> Self {
        let report: Report = Box::new(|| "nothing was written".to_owned());
        let interrupt = Self {
            report: Arc::new(Mutex::new(report)),
            json,
            bar,
        };
        // Without a handler, Ctrl-C ends the process all the same.
        let _ = ctrlc::try_set_handler(interrupt.handler());
        #[cfg(unix)]
        termination::handle(interrupt.handler());
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
            // The report first: it may end work that must not wait for a terminal that is stopped.
            let report = handled
                .report
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            let text = format!("interrupted: {}", report());
            let (json, bar) = (handled.json, handled.bar.clone());
            let (said, printed) = channel();
            std::thread::spawn(move || {
                bar.finish_and_clear();
                failure(json, &text, "interrupted");
                let _ = said.send(());
            });
            let _ = printed.recv_timeout(PRINTS);
            std::process::exit(i32::from(INTERRUPTED));
        }
    }

    pub(crate) fn says(&self, report: impl Fn() -> String + Send + 'static) {
        *self.report.lock().unwrap_or_else(PoisonError::into_inner) = Box::new(report);
    }
}

/// SIGTERM, and the SIGHUP of a closed terminal.
#[cfg(unix)]
mod termination {
    use std::sync::Arc;

    use signal_hook::consts::{SIGHUP, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;

    /// Handles the first of these signals in a thread of its own.
    ///
    /// SIGXFSZ is handled too, by doing nothing: a file that passes the limit of the shell is then an error of that write, as a
    /// full disk is, and does not end the process.
    pub(super) fn handle(mut handler: impl FnMut() + Send + 'static) {
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored = ignored(&status);
        let handled = [SIGTERM, SIGHUP]
            .into_iter()
            .filter(|signal| ignored >> (signal - 1) & 1 == 0);
        // Without a handler, these signals end the process all the same.
        let Ok(mut signals) = Signals::new(handled) else {
            return;
        };
        std::thread::spawn(move || {
            if signals.forever().next().is_some() {
                handler();
            }
        });
    }

    /// The signals that a process ignores, as Linux reports them: bit k - 1 is signal k. Elsewhere none is known.
    fn ignored(status: &str) -> u64 {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
            .unwrap_or(0)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn analytic_ignored_signals_are_bits() {
            assert_eq!(
                ignored("Name:\tx\nSigIgn:\t0000000000000001\n"),
                1 << (SIGHUP - 1)
            );
            assert_eq!(ignored("Name:\tx\n"), 0);
        }
    }
}
