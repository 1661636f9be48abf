//! Ctrl-C, SIGTERM and SIGHUP: asks the flight to end, and ends the process once the vehicle was handed over.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::cli::context::Context;

/// Longest time that Ctrl-C waits: that of a hand-over (5 s) and of writing parameters back (5 s), and some for the file.
const WAITS: Duration = Duration::from_secs(12);
/// Time between two looks.
const LOOKS: Duration = Duration::from_millis(10);

/// Flags of Ctrl-C. When it is dropped, the flight has ended and its summary was printed. Then an interrupted process ends with the
/// status of an interruption, whatever the flight returned.
pub(super) struct Interrupt {
    asked: Arc<AtomicBool>,
    ended: Arc<AtomicBool>,
}

impl Interrupt {
    pub(super) fn watch(context: &Context, out: &Path) -> Self {
        let interrupt = Self {
            asked: Arc::default(),
            ended: Arc::default(),
        };
        let (asked, ended) = (Arc::clone(&interrupt.asked), Arc::clone(&interrupt.ended));
        let file = out.display().to_string();
        context.if_interrupted(move || {
            asked.store(true, Ordering::SeqCst);
            let since = Instant::now();
            while !ended.load(Ordering::SeqCst) {
                if since.elapsed() > WAITS {
                    return format!("the flight did not end in time; {file} is not whole");
                }
                std::thread::sleep(LOOKS);
            }
            format!("the flight has ended as its summary says; the recording is {file}")
        });
        // A vehicle in flight must be handed over, however the process was started.
        context.insist_on_interrupts();
        interrupt
    }

    /// Whether Ctrl-C was pressed.
    pub(super) fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::SeqCst);
        if self.asked() && !std::thread::panicking() {
            // The handler of Ctrl-C ends the process.
            loop {
                std::thread::park();
            }
        }
    }
}
