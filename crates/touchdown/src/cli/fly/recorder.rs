//! The recording, written by a thread of its own: a slow disk does not delay the flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, SyncSender};
use std::thread::JoinHandle;

use touchdown::{Error, Result};
use touchdown_link::LinkError;
use touchdown_link::camera::CameraReport;
use touchdown_link::companion::Event;
use touchdown_link::recording::Recorder;

use super::pool::Used;

/// Lines that wait for the disk at most: about a minute of them. A disk that is slower counts as full.
const WAITING: usize = 1 << 15;

/// What happened.
pub(super) enum What {
    Received,
    Camera(Box<CameraReport>),
    /// An image of the camera, the bytes of a PNG file, which the companion does not see.
    Image(Vec<u8>),
    Tick,
    Stop,
}

impl What {
    /// The companion's event. It hears nothing of images.
    pub(super) fn event<'a>(&'a self, received: &'a [u8]) -> Event<'a> {
        match self {
            Self::Received => Event::Received(received),
            Self::Camera(report) => Event::Camera(report),
            Self::Image(_) => Event::Received(&[]),
            Self::Tick => Event::Tick,
            Self::Stop => Event::Stop,
        }
    }
}

/// Takes images for the recording.
#[derive(Clone)]
pub(super) struct Images(SyncSender<Line>);

impl Images {
    /// Hands over an image. One that the disk has no time for is not recorded.
    pub(super) fn write(&self, at_us: u64, png: Vec<u8>) {
        let _ = self.0.try_send(Line {
            at_us,
            what: What::Image(png),
            received: Vec::new(),
            sent: Vec::new(),
        });
    }
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
                let written = match &line.what {
                    What::Image(png) => recorder.write_image(line.at_us, png),
                    what => recorder.write(line.at_us, what.event(&line.received), &line.sent),
                };
                if let Err(e) = written {
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

    /// Where images go. The recording ends only after all of these are dropped.
    pub(super) fn images(&self) -> Images {
        Images(self.lines.clone())
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
