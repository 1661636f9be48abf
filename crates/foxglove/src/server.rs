//! The live view: a WebSocket server for Foxglove, driven by its caller in turns.
//!
//! No call waits. A client that reads slowly loses messages, and one that reads nothing for 10 s is disconnected. Clients
//! can subscribe, and nothing else: the view is read only.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::time::Duration;

use crate::Topic;
use crate::client::Client;
use crate::protocol;

/// Clients at most.
const CLIENTS: usize = 8;

/// A message of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LiveMessage {
    /// Place of the topic among those of the server.
    pub topic: usize,
    /// Time, ns.
    pub time_ns: u64,
    /// The message, JSON.
    pub json: Vec<u8>,
}

/// The server.
pub struct LiveServer {
    listener: TcpListener,
    info: String,
    advertisement: String,
    /// The newest message of each topic. A new subscription begins with it, so that rare messages are seen as well.
    newest: Vec<Option<LiveMessage>>,
    clients: Vec<Client>,
}

impl LiveServer {
    /// Listens at an address. `name` is what Foxglove shows.
    ///
    /// # Errors
    /// An address that cannot be used.
    pub fn bind(address: SocketAddr, name: &str, topics: &[Topic]) -> std::io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            info: protocol::server_info(name),
            advertisement: protocol::advertise(topics),
            newest: topics.iter().map(|_| None).collect(),
            clients: Vec::with_capacity(CLIENTS),
        })
    }

    /// The address, with the port that the system has chosen for port 0.
    ///
    /// # Errors
    /// The system's.
    pub fn address(&self) -> std::io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Sends a message to all who have subscribed. `now` counts from any time.
    pub fn publish(&mut self, message: LiveMessage, now: Duration) {
        let topic = message.topic as u64;
        for client in &mut self.clients {
            client.publish(topic, message.time_ns, &message.json, now);
        }
        if let Some(newest) = self.newest.get_mut(message.topic) {
            *newest = Some(message);
        }
    }

    /// Accepts clients, reads their requests, and writes what waits for them. To be called about every 10 ms.
    pub fn turn(&mut self, now: Duration) {
        self.accept(now);
        for client in &mut self.clients {
            if client.negotiate(now) {
                client.send_text(&self.info, now);
                client.send_text(&self.advertisement, now);
            }
            for topic in client.turn(self.newest.len(), now) {
                let newest = usize::try_from(topic).ok().and_then(|k| self.newest.get(k));
                if let Some(Some(message)) = newest {
                    client.publish(topic, message.time_ns, &message.json, now);
                }
            }
        }
        self.clients.retain(|client| !client.is_closed());
    }

    /// Clients whose handshake is complete.
    #[must_use]
    pub fn clients(&self) -> usize {
        self.clients.iter().filter(|c| c.is_open()).count()
    }

    fn accept(&mut self, now: Duration) {
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    let usable =
                        stream.set_nonblocking(true).is_ok() && stream.set_nodelay(true).is_ok();
                    // Beyond the limit a connection is closed at once.
                    if usable && self.clients.len() < CLIENTS {
                        let client = Client::new(stream, now);
                        self.clients.push(client);
                    }
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => return,
            }
        }
    }
}
