//! Buffers that are used again, so that the flight allocates nothing once it runs.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

/// Size of a buffer: a datagram of a MAVLink link is far smaller.
pub(super) const BUFFER: usize = 4096;
/// Buffers at the start: a tenth of a second of arrivals and ticks.
const FIRST: usize = 64;
/// Buffers that are kept at most.
const MOST: usize = 4096;

/// Where used buffers go.
#[derive(Clone)]
pub(super) struct Used(SyncSender<Vec<u8>>);

/// Where free buffers come from.
pub(super) struct Free(Receiver<Vec<u8>>);

/// A pool.
pub(super) fn pool() -> (Used, Free) {
    let (used, free) = sync_channel(MOST);
    for _ in 0..FIRST {
        // The channel has room for them.
        let _ = used.try_send(Vec::with_capacity(BUFFER));
    }
    (Used(used), Free(free))
}

impl Used {
    /// Takes a buffer back.
    pub(super) fn put(&self, mut buffer: Vec<u8>) {
        // The empty buffer of a tick is not one of the pool: it would crowd out those that have room.
        if buffer.capacity() == 0 {
            return;
        }
        buffer.clear();
        match self.0.try_send(buffer) {
            // The pool is full, or the flight has ended.
            Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
        }
    }
}

impl Free {
    /// An empty buffer; a new one only if all are in use.
    pub(super) fn get(&self) -> Vec<u8> {
        self.0
            .try_recv()
            .unwrap_or_else(|_| Vec::with_capacity(BUFFER))
    }
}
