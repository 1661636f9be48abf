//! Bytes over serial, UDP and TCP.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serialport::SerialPort;

use crate::address::Address;
use crate::error::LinkError;

/// Senders on a UDP port that get answers. A program that finds the pad may send to the same port as the autopilot: it
/// gets the same bytes.
const PEERS: usize = 4;

/// The last senders on a UDP port.
#[derive(Default)]
struct Peers {
    known: [Option<SocketAddr>; PEERS],
    next: usize,
}

impl Peers {
    fn heard(&mut self, from: SocketAddr) {
        if !self.known.contains(&Some(from)) {
            self.known[self.next] = Some(from);
            self.next = (self.next + 1) % PEERS;
        }
    }
}

/// Longest wait of [`Receiver::receive`].
const WAIT: Duration = Duration::from_millis(50);

/// The receiving half of a link.
pub struct Receiver(Incoming);

enum Incoming {
    Udp {
        socket: UdpSocket,
        /// The last senders, if they decide where answers go.
        peers: Option<Arc<Mutex<Peers>>>,
    },
    Tcp(TcpStream),
    Serial(Box<dyn SerialPort>),
}

/// The sending half of a link.
pub struct Sender(Outgoing);

enum Outgoing {
    Udp {
        socket: UdpSocket,
        peers: Option<Arc<Mutex<Peers>>>,
    },
    Tcp(TcpStream),
    Serial(Box<dyn SerialPort>),
}

/// Opens a link.
///
/// # Errors
/// A port, host or device that cannot be opened.
pub fn open(address: &Address) -> Result<(Receiver, Sender), LinkError> {
    halves(address).map_err(|source| LinkError::Link {
        address: address.to_string(),
        source,
    })
}

fn halves(address: &Address) -> std::io::Result<(Receiver, Sender)> {
    Ok(match address {
        Address::UdpIn(place) => udp(UdpSocket::bind(place)?, Some(Arc::default()))?,
        Address::UdpOut(place) => {
            let socket = UdpSocket::bind(if place.starts_with('[') {
                "[::]:0"
            } else {
                "0.0.0.0:0"
            })?;
            socket.connect(place)?;
            udp(socket, None)?
        }
        Address::Tcp(place) => {
            let stream = TcpStream::connect(place)?;
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(WAIT))?;
            stream.set_write_timeout(Some(WAIT))?;
            let sending = stream.try_clone()?;
            (
                Receiver(Incoming::Tcp(stream)),
                Sender(Outgoing::Tcp(sending)),
            )
        }
        Address::Serial { device, baud } => {
            let port = serialport::new(device, *baud).timeout(WAIT).open()?;
            let sending = port.try_clone()?;
            (
                Receiver(Incoming::Serial(port)),
                Sender(Outgoing::Serial(sending)),
            )
        }
    })
}

fn udp(socket: UdpSocket, peers: Option<Arc<Mutex<Peers>>>) -> std::io::Result<(Receiver, Sender)> {
    socket.set_read_timeout(Some(WAIT))?;
    let sending = socket.try_clone()?;
    let outgoing = Outgoing::Udp {
        socket: sending,
        peers: peers.clone(),
    };
    Ok((Receiver(Incoming::Udp { socket, peers }), Sender(outgoing)))
}

impl Receiver {
    /// Waits for bytes, at most 50 ms. None is no error: nothing came.
    ///
    /// # Errors
    /// A link that is closed or broken. A UDP port without a listener is neither.
    pub fn receive(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let received = match &mut self.0 {
            Incoming::Udp { socket, peers } => socket.recv_from(buffer).map(|(length, from)| {
                if let Some(peers) = peers {
                    peers
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .heard(from);
                }
                length
            }),
            Incoming::Tcp(stream) => match stream.read(buffer) {
                Ok(0) => Err(ErrorKind::ConnectionAborted.into()),
                other => other,
            },
            Incoming::Serial(port) => port.read(buffer),
        };
        quiet(received)
    }
}

impl Sender {
    /// Sends bytes. Over UDP they are lost before the first sender was heard, and while the network is down.
    ///
    /// # Errors
    /// A link that is closed or broken.
    pub fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        let sent = match &mut self.0 {
            // A network that is down for a moment is silence, which the companion watches.
            Outgoing::Udp {
                socket,
                peers: None,
            } => {
                let _ = socket.send(bytes);
                return Ok(());
            }
            Outgoing::Udp {
                socket,
                peers: Some(peers),
            } => {
                let known = peers.lock().unwrap_or_else(PoisonError::into_inner).known;
                for peer in known.iter().flatten() {
                    let _ = socket.send_to(bytes, peer);
                }
                return Ok(());
            }
            Outgoing::Tcp(stream) => stream.write_all(bytes).map(|()| bytes.len()),
            Outgoing::Serial(port) => port.write_all(bytes).map(|()| bytes.len()),
        };
        quiet(sent).map(|_| ())
    }
}

/// Whether no bytes arrived in time, or a UDP port has no listener: the link is quiet, not broken.
pub(crate) fn is_quiet(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock
            | ErrorKind::TimedOut
            | ErrorKind::Interrupted
            | ErrorKind::ConnectionRefused
            | ErrorKind::ConnectionReset
            | ErrorKind::NetworkDown
            | ErrorKind::NetworkUnreachable
            | ErrorKind::HostUnreachable
    )
}

/// No bytes from a link that is quiet.
fn quiet(result: std::io::Result<usize>) -> std::io::Result<usize> {
    result.or_else(|e| if is_quiet(&e) { Ok(0) } else { Err(e) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_udp_answers_go_to_all_of_the_last_senders() {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap();
        let place = free.local_addr().unwrap().to_string();
        drop(free);
        let (mut here, mut back) = open(&Address::UdpIn(place.clone())).unwrap();
        let (mut there, mut to) = open(&Address::UdpOut(place.clone())).unwrap();
        back.send(b"lost").unwrap();
        let mut buffer = [0; 16];
        to.send(b"hello").unwrap();
        assert_eq!(here.receive(&mut buffer).unwrap(), 5);
        back.send(b"you").unwrap();
        assert_eq!(there.receive(&mut buffer).unwrap(), 3);
        assert_eq!(&buffer[..3], b"you");
        assert_eq!(there.receive(&mut buffer).unwrap(), 0, "nothing came");
        // Another program sends to the same port: the first one still gets its answers.
        let (mut elsewhere, mut other) = open(&Address::UdpOut(place)).unwrap();
        other.send(b"pad").unwrap();
        assert_eq!(here.receive(&mut buffer).unwrap(), 3);
        back.send(b"both").unwrap();
        assert_eq!(there.receive(&mut buffer).unwrap(), 4);
        assert_eq!(elsewhere.receive(&mut buffer).unwrap(), 4);
    }
}
