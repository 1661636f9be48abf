//! The flight: link, clock and Ctrl-C around the companion.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver as Incoming, RecvTimeoutError};
use std::time::{Duration, Instant};

use touchdown::{Error, Result};
use touchdown_link::address::Address;
use touchdown_link::checklist::Checklist;
use touchdown_link::companion::{Companion, Event, Stage, Summary};
use touchdown_link::recording::Recorder;
use touchdown_link::settings::{FlightSettings, PERIOD_S};
use touchdown_link::transport::{self, Receiver, Sender};

use super::recorder::RecorderThread;
use crate::cli::context::Context;

/// Longest time that Ctrl-C waits for the hand-over.
const CTRL_C_WAITS: Duration = Duration::from_secs(7);

/// Bytes and their arrival time.
type Arrival = (Instant, std::io::Result<Vec<u8>>);

/// The sending half. It asks for a holding mode if the loop panics in control.
struct Outgoing {
    sender: Sender,
    hold: Option<Vec<u8>>,
}

impl Drop for Outgoing {
    fn drop(&mut self) {
        if let (true, Some(hold)) = (std::thread::panicking(), &self.hold) {
            let _ = self.sender.send(hold);
        }
    }
}

/// Flies until the companion has ended.
pub(super) fn fly(
    context: &Context,
    settings: &FlightSettings,
    out: &Path,
    take_control: bool,
) -> Result<Summary> {
    let link = |e: std::io::Error| -> Error {
        touchdown_link::LinkError::Link {
            address: settings.link.clone(),
            source: e,
        }
        .into()
    };
    let mut companion =
        Companion::new(settings, take_control).map_err(touchdown_link::LinkError::from)?;
    let address: Address = settings.link.parse()?;
    let recorder = RecorderThread::start(Recorder::create(out, settings, take_control)?);
    let (receiver, sender) = transport::open(&address)?;
    let mut outgoing = Outgoing { sender, hold: None };
    let arrivals = listen(receiver);
    let (stop, ended) = watch_interrupt(context, out);
    context.say(&format!(
        "listening on {address}; Ctrl-C hands the vehicle back"
    ));

    let start = Instant::now();
    let period = Duration::from_secs_f64(PERIOD_S);
    let mut next = start + period;
    let mut bytes = Vec::with_capacity(1024);
    let mut printed = Checklist::default();
    let mut stopping = false;
    let outcome = loop {
        let at = |when: Instant| u64::try_from((when - start).as_micros()).unwrap_or(u64::MAX);
        let (at_us, event);
        let chunk;
        if !stopping && (stop.load(Ordering::Relaxed) || recorder.failed()) {
            stopping = true;
            (at_us, event) = (at(Instant::now()), Event::Stop);
        } else {
            match wait(&arrivals, next) {
                Ok(Some((when, received))) => {
                    chunk = received;
                    (at_us, event) = (at(when), Event::Received(&chunk));
                }
                Ok(None) => {
                    let now = Instant::now();
                    // A late tick is not made up for.
                    next = (next + period).max(now);
                    (at_us, event) = (at(now), Event::Tick);
                }
                Err(e) => break Err(link(e)),
            }
        }
        bytes.clear();
        companion.handle(at_us, event, &mut bytes);
        outgoing.hold = companion.hold_bytes();
        let sent = if bytes.is_empty() {
            Ok(())
        } else {
            outgoing.sender.send(&bytes)
        };
        recorder.write(at_us, event, &bytes);
        if let Err(e) = sent {
            break Err(link(e));
        }
        report(context, &mut companion, &mut printed);
        if companion.stage() == Stage::Ended {
            break Ok(companion.summary());
        }
    };
    let recorded = recorder.finish();
    ended.store(true, Ordering::Relaxed);
    let summary = outcome?;
    recorded?;
    Ok(summary)
}

/// The next bytes; none when it is time for a tick.
fn wait(
    arrivals: &Incoming<Arrival>,
    until: Instant,
) -> std::io::Result<Option<(Instant, Vec<u8>)>> {
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Ok(None);
    }
    match arrivals.recv_timeout(left) {
        Ok((when, received)) => received.map(|bytes| Some((when, bytes))),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => Err(std::io::ErrorKind::ConnectionAborted.into()),
    }
}

/// A thread that stamps bytes as they arrive.
fn listen(mut receiver: Receiver) -> Incoming<Arrival> {
    let (stamped, arrivals) = mpsc::channel();
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        loop {
            let received = receiver.receive(&mut buffer);
            let broken = received.is_err();
            let arrival = received.map(|length| buffer[..length].to_vec());
            if arrival.as_ref().is_ok_and(Vec::is_empty) {
                continue;
            }
            if stamped.send((Instant::now(), arrival)).is_err() || broken {
                return;
            }
        }
    });
    arrivals
}

/// Flags for Ctrl-C, which asks the loop to stop and waits until it has ended, and for the loop's end.
fn watch_interrupt(context: &Context, out: &Path) -> (Arc<AtomicBool>, Arc<AtomicBool>) {
    let (stop, ended) = (
        Arc::new(AtomicBool::new(false)),
        Arc::new(AtomicBool::new(false)),
    );
    let (asks, waits) = (Arc::clone(&stop), Arc::clone(&ended));
    let file = out.display().to_string();
    context.if_interrupted(move || {
        asks.store(true, Ordering::Relaxed);
        let asked = Instant::now();
        while !waits.load(Ordering::Relaxed) && asked.elapsed() < CTRL_C_WAITS {
            std::thread::sleep(Duration::from_millis(10));
        }
        format!("the vehicle was handed back; the recording is {file}")
    });
    (stop, ended)
}

/// Prints what is new.
fn report(context: &Context, companion: &mut Companion, printed: &mut Checklist) {
    for note in companion.take_notes() {
        context.say(&note);
    }
    let list = companion.checklist();
    let verdicts =
        |list: &Checklist| -> Vec<_> { list.items.iter().map(|item| item.verdict).collect() };
    if verdicts(list) != verdicts(printed) {
        context.say(&list.text());
        *printed = list.clone();
    }
}
