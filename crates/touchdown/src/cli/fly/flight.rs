//! The flight: link, clock and Ctrl-C around the companion.
//!
//! | thread | does |
//! | --- | --- |
//! | this one | waits for bytes or the next tick, asks the companion, sends |
//! | listener | stamps bytes as they arrive |
//! | camera (two threads) | waits for frames; looks for the deck in the newest one |
//! | recorder | writes the recording |
//! | view | prints |
//!
//! They pass buffers that are used again, through queues of fixed size. So this thread waits neither for the disk nor for
//! the terminal, and allocates nothing while the vehicle is in control.

use std::sync::mpsc::{self, Receiver as Incoming, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

use touchdown::Result;
use touchdown_link::address::Address;
use touchdown_link::camera::CameraReport;
use touchdown_link::companion::{Companion, Publication, Session, Stage, Summary};
use touchdown_link::recording::Recorder;
use touchdown_link::settings::{FlightSettings, PERIOD_S};
use touchdown_link::transport::{self, Receiver, Sender};

use super::camera::Camera;
use super::interrupt::Interrupt;
use super::pool::{BUFFER, Free, pool};
use super::recorder::{RecorderThread, What};
use super::view::{View, view};
use crate::cli::context::Context;

/// Arrivals that wait for the loop at most; a loop that is slower than that has long handed over.
const WAITING: usize = 4096;

/// What arrives, and when.
pub(super) enum Arrival {
    Bytes(Instant, std::io::Result<Vec<u8>>),
    Camera(Instant, Box<CameraReport>),
}

/// The sending half. It asks for a holding mode if the loop ends by a panic or a broken link while in control.
struct Outgoing {
    sender: Sender,
    hold: Vec<u8>,
}

impl Drop for Outgoing {
    fn drop(&mut self) {
        if !self.hold.is_empty() {
            let _ = self.sender.send(&self.hold);
        }
    }
}

/// Flies until the companion has ended: the summary, and whether the recording is whole. The recording begins once settings, link
/// and camera are found good: a flight that is refused leaves the file of the one before.
pub(super) fn fly(
    context: &Context,
    settings: &FlightSettings,
    session: &Session,
    record: impl FnOnce() -> Result<Recorder>,
    interrupt: &Interrupt,
) -> Result<(Summary, Result<()>)> {
    let companion = Companion::new(settings, session).map_err(touchdown_link::LinkError::from)?;
    let address: Address = settings.link.parse()?;
    let (receiver, sender) = transport::open(&address, session.signing)?;
    let ((free_in, used_in), (free_out, used_out)) = (turned(pool()), turned(pool()));
    let (arriving, arrivals) = mpsc::sync_channel(WAITING);
    let start = Instant::now();
    let mut camera = Camera::start(settings, start)?;
    let recorder = RecorderThread::start(record()?, used_in, used_out);
    if let Some(camera) = &mut camera {
        camera.look(arriving.clone(), recorder.images());
    }
    listen(receiver, free_in, arriving);
    let mut flight = Flight {
        companion,
        start,
        arrivals,
        camera,
        outgoing: Outgoing {
            sender,
            hold: Vec::with_capacity(BUFFER),
        },
        recorder,
        free_out,
    };
    context.say(&format!(
        "listening on {address}; Ctrl-C hands the vehicle back"
    ));
    let (view, shown) = view();
    let outcome = std::thread::scope(|scope| {
        scope.spawn(|| shown.show(context));
        flight.run(interrupt, view)
    });
    drop(flight.camera);
    let recorded = flight.recorder.finish();
    outcome.map_err(|source| touchdown_link::LinkError::Link {
        address: settings.link.clone(),
        source,
    })?;
    Ok((flight.companion.summary(), recorded))
}

fn turned<A, B>((a, b): (A, B)) -> (B, A) {
    (b, a)
}

/// A flight that runs.
struct Flight {
    companion: Companion,
    /// Time zero of the companion.
    start: Instant,
    camera: Option<Camera>,
    arrivals: Incoming<Arrival>,
    outgoing: Outgoing,
    recorder: RecorderThread,
    free_out: Free,
}

impl Flight {
    fn run(&mut self, interrupt: &Interrupt, mut view: View) -> std::io::Result<()> {
        let start = self.start;
        let at = |when: Instant| u64::try_from((when - start).as_micros()).unwrap_or(u64::MAX);
        let period = Duration::from_secs_f64(PERIOD_S);
        let mut next = Instant::now() + period;
        let mut stopping = false;
        let mut publication = Publication::default();
        while self.companion.stage() != Stage::Ended {
            if !stopping && (interrupt.asked() || self.recorder.failed()) {
                stopping = true;
                self.handle(at(Instant::now()), What::Stop, Vec::new())?;
            }
            match self.wait(next)? {
                Some(Arrival::Bytes(when, bytes)) => {
                    self.handle(at(when), What::Received, bytes?)?;
                }
                Some(Arrival::Camera(when, report)) => {
                    self.handle(at(when), What::Camera(report), Vec::new())?;
                }
                None => {
                    let now = Instant::now();
                    // A late tick is not made up for, and two ticks are never close together.
                    next = (next + period).max(now + period / 2);
                    self.handle(at(now), What::Tick, Vec::new())?;
                    if let Some(camera) = &self.camera {
                        camera.tell(self.companion.attitude());
                    }
                    let state = self.companion.state();
                    if publication.includes(&state) {
                        self.recorder.write_state(state);
                    }
                    if let Some(list) = view.update(&mut self.companion, at(now)) {
                        self.recorder.write_checklist(at(now), list);
                    }
                }
            }
        }
        self.recorder.write_state(self.companion.state());
        view.end(&mut self.companion, at(Instant::now()));
        Ok(())
    }

    /// Passes an event to the companion, sends its bytes, and records both.
    fn handle(&mut self, at_us: u64, what: What, received: Vec<u8>) -> std::io::Result<()> {
        let mut bytes = self.free_out.get();
        self.companion
            .handle(at_us, what.event(&received), &mut bytes);
        self.outgoing.hold.clear();
        self.companion.hold_bytes(&mut self.outgoing.hold);
        let sent = if bytes.is_empty() {
            Ok(())
        } else {
            self.outgoing.sender.send(&bytes)
        };
        self.recorder.write(at_us, what, received, bytes);
        sent
    }

    /// What arrives next; none when it is time for a tick.
    fn wait(&self, until: Instant) -> std::io::Result<Option<Arrival>> {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(None);
        }
        match self.arrivals.recv_timeout(left) {
            Ok(arrival) => Ok(Some(arrival)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => {
                Err(std::io::ErrorKind::ConnectionAborted.into())
            }
        }
    }
}

/// A thread that stamps bytes as they arrive.
fn listen(mut receiver: Receiver, free: Free, arriving: SyncSender<Arrival>) {
    std::thread::spawn(move || {
        let mut buffer = free.get();
        let start = Instant::now();
        loop {
            buffer.resize(BUFFER, 0);
            let received = receiver.receive(&mut buffer, start.elapsed());
            let now = Instant::now();
            let arrival = match received {
                Ok(0) => continue,
                Ok(length) => {
                    buffer.truncate(length);
                    Ok(std::mem::replace(&mut buffer, free.get()))
                }
                Err(e) => Err(e),
            };
            let broken = arrival.is_err();
            if arriving.send(Arrival::Bytes(now, arrival)).is_err() || broken {
                return;
            }
        }
    });
}
