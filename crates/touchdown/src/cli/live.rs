//! The live view for Foxglove, in a thread of its own.

use std::net::SocketAddr;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use touchdown::{Error, Result};
use touchdown_foxglove::server::{LiveMessage, LiveServer};
use touchdown_link::recording::{Recorder, Watcher};

use super::context::Context;

/// Where Foxglove looks by default; only programs on this computer reach it.
pub(super) const ADDRESS: &str = "127.0.0.1:8765";
/// Messages that wait for the thread at most: two seconds of all topics. Further ones are not shown.
const WAITING: usize = 1024;
/// Time between two turns of the server. Twice of it is visible; half of it costs processor time.
const TURN: Duration = Duration::from_millis(10);

/// The live view. It ends when this and all its watchers are dropped.
pub(super) struct Live(SyncSender<LiveMessage>);

impl Live {
    /// Listens.
    pub(super) fn start(context: &Context, address: SocketAddr) -> Result<Self> {
        let unusable = |e: std::io::Error| Error::Arguments(format!("--live={address}: {e}"));
        let name = concat!("touchdown ", env!("CARGO_PKG_VERSION"));
        let server = LiveServer::bind(address, name, &Recorder::topics()).map_err(unusable)?;
        let bound = server.address().map_err(unusable)?;
        context.say(&format!("live view for Foxglove: ws://{bound}"));
        let (messages, waiting) = sync_channel(WAITING);
        std::thread::spawn(move || serve(server, &waiting));
        Ok(Self(messages))
    }

    /// Shows what a recorder writes.
    pub(super) fn watcher(&self) -> Watcher {
        let messages = self.0.clone();
        Box::new(move |topic, time_ns, json| {
            let json = json.to_vec();
            // The recording does not wait for a thread that does not keep up: the view misses messages.
            let _ = messages.try_send(LiveMessage {
                topic,
                time_ns,
                json,
            });
        })
    }
}

fn serve(mut server: LiveServer, messages: &Receiver<LiveMessage>) {
    let start = Instant::now();
    loop {
        match messages.recv_timeout(TURN) {
            Ok(message) => server.publish(message, start.elapsed()),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        // At most one queue's worth, so that a flood of messages does not starve the clients.
        for _ in 0..WAITING {
            match messages.try_recv() {
                Ok(message) => server.publish(message, start.elapsed()),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => break,
            }
        }
        server.turn(start.elapsed());
    }
}
