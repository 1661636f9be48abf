//! A client of the live view.

use std::net::TcpStream;
use std::time::Duration;

use tungstenite::handshake::server::{
    Callback, ErrorResponse, Request as HttpRequest, Response, ServerHandshake,
};
use tungstenite::handshake::{HandshakeError, MidHandshake};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Bytes, Error, Message, WebSocket, accept_hdr_with_config};

use crate::protocol::{NAMES, Request, Subscription, message_data};

/// Longest request that is read, bytes: a subscription to every topic takes a few thousand.
const REQUEST_BYTES: usize = 1 << 16;
/// Most bytes that wait for a client. It is about a second of all topics. Half of it drops messages on a short stall of a
/// radio link; twice of it only costs memory.
const WAITING_BYTES: usize = 1 << 18;
/// Subscriptions of a client at most: several panels may show the same topic.
const SUBSCRIPTIONS: usize = 256;
/// Requests of a client that are read in a turn: one that floods the server delays others no longer.
const REQUESTS: usize = 16;
/// Longest handshake. Half of it fails on a slow radio link; twice of it holds a place of a silent client longer.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Time after which a client that reads nothing is disconnected. Half of it is a laptop that sleeps for a moment; with
/// twice of it, the place is taken longer.
const STALLED: Duration = Duration::from_secs(10);

/// Chooses the protocol's name.
pub(crate) struct Negotiation;

impl Callback for Negotiation {
    fn on_request(
        self,
        request: &HttpRequest,
        mut response: Response,
    ) -> Result<Response, ErrorResponse> {
        let offered = request.headers().get_all("sec-websocket-protocol");
        let offered: Vec<&str> = offered
            .iter()
            .filter_map(|value| value.to_str().ok())
            .flat_map(|value| value.split(','))
            .map(str::trim)
            .collect();
        let Some(name) = NAMES.into_iter().find(|name| offered.contains(name)) else {
            let expected = format!(
                "expected the WebSocket subprotocol {}\n",
                NAMES.join(" or ")
            );
            let mut refusal = ErrorResponse::new(Some(expected));
            *refusal.status_mut() = StatusCode::BAD_REQUEST;
            return Err(refusal);
        };
        response
            .headers_mut()
            .insert("sec-websocket-protocol", HeaderValue::from_static(name));
        Ok(response)
    }
}

type Handshake = MidHandshake<ServerHandshake<TcpStream, Negotiation>>;

/// A connection, before and after its handshake.
enum Connection {
    Negotiating(Box<Handshake>),
    Open(Box<WebSocket<TcpStream>>),
    Closed,
}

/// A client.
pub(crate) struct Client {
    connection: Connection,
    subscriptions: Vec<Subscription>,
    connected: Duration,
    greeted: bool,
    /// Since when the client has read nothing of what waits for it.
    stalled: Option<Duration>,
}

impl Client {
    /// A client that has connected, on a socket that does not block.
    pub(crate) fn new(stream: TcpStream, now: Duration) -> Self {
        let config = WebSocketConfig::default()
            .read_buffer_size(4096)
            .write_buffer_size(0)
            .max_write_buffer_size(WAITING_BYTES)
            .max_message_size(Some(REQUEST_BYTES))
            .max_frame_size(Some(REQUEST_BYTES));
        let mut client = Self {
            connection: Connection::Closed,
            subscriptions: Vec::new(),
            connected: now,
            greeted: false,
            stalled: None,
        };
        client.negotiated(accept_hdr_with_config(stream, Negotiation, Some(config)));
        client
    }

    fn negotiated(
        &mut self,
        result: Result<
            WebSocket<TcpStream>,
            HandshakeError<ServerHandshake<TcpStream, Negotiation>>,
        >,
    ) {
        self.connection = match result {
            Ok(socket) => Connection::Open(Box::new(socket)),
            Err(HandshakeError::Interrupted(handshake)) => {
                Connection::Negotiating(Box::new(handshake))
            }
            Err(HandshakeError::Failure(_)) => Connection::Closed,
        };
    }

    pub(crate) fn is_closed(&self) -> bool {
        matches!(self.connection, Connection::Closed)
    }

    /// Continues the handshake. Returns whether the client is to be greeted: once, when it is complete.
    pub(crate) fn negotiate(&mut self, now: Duration) -> bool {
        if let Connection::Negotiating(_) = &self.connection
            && let Connection::Negotiating(handshake) =
                std::mem::replace(&mut self.connection, Connection::Closed)
            && now.saturating_sub(self.connected) <= HANDSHAKE
        {
            self.negotiated(handshake.handshake());
        }
        let greets = self.is_open() && !self.greeted;
        self.greeted |= greets;
        greets
    }

    /// Whether the handshake is complete.
    pub(crate) fn is_open(&self) -> bool {
        matches!(self.connection, Connection::Open(_))
    }

    /// Sends text.
    pub(crate) fn send_text(&mut self, text: &str, now: Duration) {
        self.send(Message::text(text), now);
    }

    /// Sends a message of a topic to its subscriptions, unless the client has not read the ones before.
    pub(crate) fn publish(&mut self, topic: u64, time_ns: u64, message: &[u8], now: Duration) {
        for k in 0..self.subscriptions.len() {
            let Subscription { id, channel_id } = self.subscriptions[k];
            if channel_id == topic && self.stalled.is_none() {
                let bytes = Bytes::from(message_data(id, time_ns, message));
                self.send(Message::Binary(bytes), now);
            }
        }
    }

    fn send(&mut self, message: Message, now: Duration) {
        if let Connection::Open(socket) = &mut self.connection {
            let written = socket.write(message);
            self.wrote(written, now);
        }
    }

    fn wrote(&mut self, result: Result<(), Error>, now: Duration) {
        match result {
            Ok(()) => self.stalled = None,
            // What the socket does not take waits in the buffer; what the buffer does not take is lost.
            Err(Error::Io(e)) if e.kind() == std::io::ErrorKind::WouldBlock => {
                self.stalled.get_or_insert(now);
            }
            Err(Error::WriteBufferFull(_)) => {
                self.stalled.get_or_insert(now);
            }
            Err(_) => self.connection = Connection::Closed,
        }
    }

    /// Reads requests and writes what waits. Returns the topics to which the client has just subscribed.
    pub(crate) fn turn(&mut self, topics: usize, now: Duration) -> Vec<u64> {
        let mut new = Vec::new();
        for _ in 0..REQUESTS {
            let Connection::Open(socket) = &mut self.connection else {
                return Vec::new();
            };
            match socket.read() {
                Ok(Message::Text(text)) => {
                    if let Ok(request) = serde_json::from_str(text.as_str()) {
                        self.take(request, topics, &mut new);
                    }
                }
                Ok(_) => {}
                Err(Error::Io(e)) if e.kind() == std::io::ErrorKind::WouldBlock => break,
                Err(_) => self.connection = Connection::Closed,
            }
        }
        if let Connection::Open(socket) = &mut self.connection {
            let flushed = socket.flush();
            self.wrote(flushed, now);
        }
        if self
            .stalled
            .is_some_and(|since| now.saturating_sub(since) > STALLED)
        {
            self.connection = Connection::Closed;
        }
        new
    }

    fn take(&mut self, request: Request, topics: usize, new: &mut Vec<u64>) {
        match request {
            Request::Subscribe { subscriptions } => {
                for subscription in subscriptions {
                    let known = self.subscriptions.iter().any(|s| s.id == subscription.id);
                    let exists = subscription.channel_id < topics as u64;
                    if exists && !known && self.subscriptions.len() < SUBSCRIPTIONS {
                        self.subscriptions.push(subscription);
                        new.push(subscription.channel_id);
                    }
                }
            }
            Request::Unsubscribe { subscription_ids } => {
                self.subscriptions
                    .retain(|s| !subscription_ids.contains(&s.id));
            }
        }
    }
}
