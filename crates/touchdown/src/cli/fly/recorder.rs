//! The recording, written by a thread of its own: a slow disk does not delay the flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::JoinHandle;

use touchdown::{Error, Result};
use touchdown_link::LinkError;
use touchdown_link::camera::CameraReport;
use touchdown_link::checklist::Checklist;
use touchdown_link::companion::{Event, FlightState};
use touchdown_link::recording::Recorder;

use super::pool::Used;

/// Lines that wait for the disk at most: about a minute of them. A disk that is slower counts as full.
const WAITING: usize = 1 << 15;

/// States that wait for the thread at most: several seconds of them. Further ones are not recorded.
const STATES: usize = 256;

/// Kind of an event.
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

/// An event, and the bytes that it caused to be sent.
struct Line {
    at_us: u64,
    what: What,
    received: Vec<u8>,
    sent: Vec<u8>,
}

/// State for people who watch. It has a queue of its own, because it is large and may be lost: a replay does not need it.
#[expect(
    clippy::large_enum_variant,
    reason = "a box would allocate in the control loop"
)]
enum Watched {
    State(FlightState),
    Checklist(u64, Arc<Checklist>),
}

/// The thread that writes.
pub(super) struct RecorderThread {
    lines: SyncSender<Line>,
    watched: SyncSender<Watched>,
    failed: Arc<AtomicBool>,
    thread: JoinHandle<std::result::Result<(), LinkError>>,
}

impl RecorderThread {
    pub(super) fn start(mut recorder: Recorder, received: Used, sent: Used) -> Self {
        let (lines, incoming) = mpsc::sync_channel::<Line>(WAITING);
        let (watched, states) = mpsc::sync_channel(STATES);
        let failed = Arc::new(AtomicBool::new(false));
        let failing = Arc::clone(&failed);
        let thread = std::thread::spawn(move || {
            let written = write_all(&mut recorder, (&incoming, &states), (&received, &sent));
            failing.store(written.is_err(), Ordering::Relaxed);
            written?;
            recorder.finish()
        });
        Self {
            lines,
            watched,
            failed,
            thread,
        }
    }

    /// Where images go. The recording ends only after all of these are dropped.
    pub(super) fn images(&self) -> Images {
        Images(self.lines.clone())
    }

    /// Passes an event, the bytes that arrived with it, and the bytes sent upon it.
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

    /// Passes the state of the flight.
    pub(super) fn write_state(&self, state: FlightState) {
        let _ = self.watched.try_send(Watched::State(state));
    }

    /// Passes the checklist.
    pub(super) fn write_checklist(&self, at_us: u64, list: Arc<Checklist>) {
        let _ = self.watched.try_send(Watched::Checklist(at_us, list));
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

/// Writes until the flight has ended, and gives the buffers back.
fn write_all(
    recorder: &mut Recorder,
    (lines, watched): (&Receiver<Line>, &Receiver<Watched>),
    (received, sent): (&Used, &Used),
) -> std::result::Result<(), LinkError> {
    for line in lines {
        match &line.what {
            What::Image(png) => recorder.write_image(line.at_us, png)?,
            what => recorder.write(line.at_us, what.event(&line.received), &line.sent)?,
        }
        received.put(line.received);
        sent.put(line.sent);
        write_watched(recorder, watched)?;
    }
    write_watched(recorder, watched)
}

fn write_watched(
    recorder: &mut Recorder,
    watched: &Receiver<Watched>,
) -> std::result::Result<(), LinkError> {
    for watched in watched.try_iter() {
        match watched {
            Watched::State(state) => recorder.write_state(&state)?,
            Watched::Checklist(at_us, list) => recorder.write_checklist(at_us, &list)?,
        }
    }
    Ok(())
}
