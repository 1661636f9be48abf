//! The recording, written by a thread of its own: a slow disk does not delay the flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::thread::JoinHandle;

use touchdown::{Error, Result};
use touchdown_link::LinkError;
use touchdown_link::companion::Event;
use touchdown_link::recording::{Entry, Recorder};

/// An event, and what was sent upon it.
struct Line {
    at_us: u64,
    event: Entry,
    sent: Vec<u8>,
}

/// The thread that writes.
pub(super) struct RecorderThread {
    lines: Sender<Line>,
    failed: Arc<AtomicBool>,
    thread: JoinHandle<std::result::Result<(), LinkError>>,
}

impl RecorderThread {
    pub(super) fn start(mut recorder: Recorder) -> Self {
        let (lines, incoming) = mpsc::channel::<Line>();
        let failed = Arc::new(AtomicBool::new(false));
        let failing = Arc::clone(&failed);
        let thread = std::thread::spawn(move || {
            for line in incoming {
                let event = match &line.event {
                    Entry::Received(bytes) => Event::Received(bytes),
                    Entry::Stop => Event::Stop,
                    Entry::Tick | Entry::Sent(_) => Event::Tick,
                };
                if let Err(e) = recorder.write(line.at_us, event, &line.sent) {
                    failing.store(true, Ordering::Relaxed);
                    return Err(e);
                }
            }
            recorder.finish()
        });
        Self {
            lines,
            failed,
            thread,
        }
    }

    pub(super) fn write(&self, at_us: u64, event: Event<'_>, sent: &[u8]) {
        let event = match event {
            Event::Received(bytes) => Entry::Received(bytes.to_vec()),
            Event::Tick => Entry::Tick,
            Event::Stop => Entry::Stop,
        };
        let line = Line {
            at_us,
            event,
            sent: sent.to_vec(),
        };
        // A thread that failed has hung up, and `failed` says so.
        let _ = self.lines.send(line);
    }

    /// Whether the file can no longer be written.
    pub(super) fn failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Waits for the last line.
    pub(super) fn finish(self) -> Result<()> {
        drop(self.lines);
        match self.thread.join() {
            Ok(written) => Ok(written?),
            Err(_) => Err(Error::Arguments(
                "the thread that writes the recording ended unexpectedly".to_string(),
            )),
        }
    }
}
