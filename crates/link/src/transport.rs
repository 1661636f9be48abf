//! Bytes over serial, UDP and TCP.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serialport::SerialPort;

use crate::address::Address;
use crate::error::LinkError;
use crate::wire::Decoder;
use crate::wire::signing::{Signing, Verifier};

/// Senders on a UDP port that get answers. A program that finds the pad may send to the same port as the autopilot: it
/// gets the same bytes.
const PEERS: usize = 4;

/// Silence after which another sender may take the place of a known one. In half of it a reboot of the autopilot costs
/// its place; after twice of it an autopilot that comes back by another port waits as long.
const FORGOTTEN: Duration = Duration::from_secs(10);

/// The senders on a UDP port that get answers: those of whole frames, signed ones on a signed link. Nobody takes the place
/// of a sender that is heard.
struct Peers {
    known: [Option<(SocketAddr, Duration)>; PEERS],
    decoder: Decoder,
}

impl Peers {
    fn new(signing: Option<Signing>) -> Self {
        Self {
            known: [None; PEERS],
            decoder: Decoder::new(signing.map(Verifier::new)),
        }
    }

    fn heard(&mut self, from: SocketAddr, datagram: &[u8], now: Duration) {
        self.decoder.forget();
        self.decoder.push(datagram);
        if self.decoder.next_frame().is_none() {
            return;
        }
        while self.decoder.next_frame().is_some() {}
        let of_sender = |known: &Option<(SocketAddr, Duration)>| {
            known.is_some_and(|(address, _)| address == from)
        };
        let free = |known: &Option<(SocketAddr, Duration)>| {
            known.is_none_or(|(_, heard)| now.saturating_sub(heard) > FORGOTTEN)
        };
        let place = self.known.iter().position(of_sender);
        if let Some(place) = place.or_else(|| self.known.iter().position(free)) {
            self.known[place] = Some((from, now));
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
        /// The senders, if they decide where answers go.
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

/// Opens a link. On a signed one, only senders of signed frames get answers.
///
/// # Errors
/// A port, host or device that cannot be opened.
pub fn open(address: &Address, signing: Option<Signing>) -> Result<(Receiver, Sender), LinkError> {
    halves(address, signing).map_err(|source| LinkError::Link {
        address: address.to_string(),
        source,
    })
}

fn halves(address: &Address, signing: Option<Signing>) -> std::io::Result<(Receiver, Sender)> {
    Ok(match address {
        Address::UdpIn(place) => {
            let peers = Arc::new(Mutex::new(Peers::new(signing)));
            udp(UdpSocket::bind(place)?, Some(peers))?
        }
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
    /// Waits for bytes, at most 50 ms. None is no error: nothing came. `now` is the time since any instant, the same in all calls.
    ///
    /// # Errors
    /// A link that is closed or broken. A UDP port without a listener is neither.
    pub fn receive(&mut self, buffer: &mut [u8], now: Duration) -> std::io::Result<usize> {
        let received = match &mut self.0 {
            Incoming::Udp { socket, peers } => socket.recv_from(buffer).map(|(length, from)| {
                if let Some(peers) = peers {
                    peers.lock().unwrap_or_else(PoisonError::into_inner).heard(
                        from,
                        &buffer[..length],
                        now,
                    );
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
                for (peer, _) in known.iter().flatten() {
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
    use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage};

    use super::*;
    use crate::wire::Encoder;
    use crate::wire::signing::{Signer, SigningKey};

    fn frame(encoder: &mut Encoder) -> Vec<u8> {
        let mut bytes = Vec::new();
        encoder.write(
            &MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()),
            &mut bytes,
        );
        bytes
    }

    fn port(number: u16) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], number))
    }

    fn answered(peers: &Peers) -> Vec<u16> {
        let known = peers.known.iter().flatten();
        known.map(|(address, _)| address.port()).collect()
    }

    #[test]
    fn prop_a_flood_takes_no_place_from_a_sender_that_is_heard() {
        let mut encoder = Encoder::new(7, 1);
        let mut peers = Peers::new(None);
        let at = Duration::from_secs;
        peers.heard(port(1), &frame(&mut encoder), at(0));
        for number in 2..100 {
            peers.heard(port(number), b"", at(1));
            peers.heard(port(number), b"\xfd\x09 no frame", at(1));
        }
        assert_eq!(answered(&peers), [1]);
        for number in 2..100 {
            peers.heard(port(number), &frame(&mut encoder), at(2));
        }
        assert_eq!(answered(&peers), [1, 2, 3, 4]);
        peers.heard(port(1), &frame(&mut encoder), at(9));
        // The others have been silent for more than 10 s.
        peers.heard(port(50), &frame(&mut encoder), at(13));
        assert_eq!(answered(&peers), [1, 50, 3, 4]);
    }

    #[test]
    fn prop_on_a_signed_link_only_signers_get_answers() {
        let signing = |text: &str| Signing {
            key: SigningKey::from_text(text).unwrap(),
            link_id: 1,
            start: 1_000_000,
        };
        let mut peers = Peers::new(Some(signing("our passphrase")));
        let now = Duration::ZERO;
        peers.heard(port(1), &frame(&mut Encoder::new(7, 1)), now);
        for (number, text) in [(2, "their passphrase"), (3, "our passphrase")] {
            let mut encoder = Encoder::new(7, 1).signed(Some(Signer::new(signing(text))));
            peers.heard(port(number), &frame(&mut encoder), now);
        }
        assert_eq!(answered(&peers), [3]);
    }

    #[test]
    fn prop_udp_answers_go_to_all_senders_of_frames() {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap();
        let place = free.local_addr().unwrap().to_string();
        drop(free);
        let (mut here, mut back) = open(&Address::UdpIn(place.clone()), None).unwrap();
        let (mut there, mut to) = open(&Address::UdpOut(place.clone()), None).unwrap();
        back.send(b"lost").unwrap();
        let hello = frame(&mut Encoder::new(7, 1));
        let mut buffer = [0; 64];
        to.send(&hello).unwrap();
        assert_eq!(
            here.receive(&mut buffer, Duration::ZERO).unwrap(),
            hello.len()
        );
        back.send(b"you").unwrap();
        assert_eq!(there.receive(&mut buffer, Duration::ZERO).unwrap(), 3);
        assert_eq!(&buffer[..3], b"you");
        assert_eq!(
            there.receive(&mut buffer, Duration::ZERO).unwrap(),
            0,
            "nothing came"
        );
        // Another program sends to the same port: the first one still gets its answers.
        let (mut elsewhere, mut other) = open(&Address::UdpOut(place), None).unwrap();
        other.send(&hello).unwrap();
        assert_eq!(
            here.receive(&mut buffer, Duration::ZERO).unwrap(),
            hello.len()
        );
        back.send(b"both").unwrap();
        assert_eq!(there.receive(&mut buffer, Duration::ZERO).unwrap(), 4);
        assert_eq!(elsewhere.receive(&mut buffer, Duration::ZERO).unwrap(), 4);
    }
}
