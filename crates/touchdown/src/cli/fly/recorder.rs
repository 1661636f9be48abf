//! The recording, written by a thread of its own: a slow disk does not delay the flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, SyncSender};
use std::thread::JoinHandle;

use touchdown::{Error, Result};
use touchdown_link::LinkError;
use touchdown_link::companion::Event;
use touchdown_link::recording::Recorder;

use super::pool::Used;

/// Lines that wait for the disk at most: about a minute of them. A disk that is slower counts as full.
const WAITING: usize = 1 << 15;

/// What happened.
#[derive(Clone, Copy)]
pub(super) enum What {
    Received,
    Tick,
    Stop,
}

/// An event, and what was sent upon it.
struct Line {
    at_us: u64,
    what: What,
    received: Vec<u8>,
    sent: Vec<u8>,
}

/// The thread that writes.
pub(super) struct RecorderThread {
    lines: SyncSender<Line>,
    failed: Arc<AtomicBool>,
    thread: JoinHandle<std::result::Result<(), LinkError>>,
}

impl RecorderThread {
    pub(super) fn start(mut recorder: Recorder, received: Used, sent: Used) -> Self {
        let (lines, incoming) = mpsc::sync_channel::<Line>(WAITING);
        let failed = Arc::new(AtomicBool::new(false));
        let failing = Arc::clone(&failed);
        let thread = std::thread::spawn(move || {
            for line in incoming {
                let event = match line.what {
                    What::Received => Event::Received(&line.received),
                    What::Tick => Event::Tick,
                    What::Stop => Event::Stop,
                };
                if let Err(e) = recorder.write(line.at_us, event, &line.sent) {
                    failing.store(true, Ordering::Relaxed);
                    return Err(e);
                }
                received.put(line.received);
                sent.put(line.sent);
            }
            recorder.finish()
        });
        Self {
            lines,
            failed,
            thread,
        }
    }

    /// Hands over an event, the bytes that arrived with it, and what was sent.
    pub(super) fn write(&self, at_us: u64, what: What, received: Vec<u8>, sent: Vec<u8>) {
        let line = Line {
            at_us,
            what,
            received,
            sent,
        };
        if self.lines.try_send(line).is_err() {
            self.failed.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the file can no longer be written, or not fast enough.
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
