//! The live view over real sockets, with clients that behave and clients that do not.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use serde_json::{Value, json};
use touchdown_foxglove::Topic;
use touchdown_foxglove::messages::{pose, schema};
use touchdown_foxglove::server::{LiveMessage, LiveServer};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Error, Message, WebSocket, connect};

type Client = WebSocket<MaybeTlsStream<TcpStream>>;

fn topics() -> Vec<Topic> {
    let schema = schema(&pose(0, "world", [0.5; 3], [0.5; 4])).to_string();
    ["/vehicle/pose", "/deck/pose"]
        .map(|name| Topic {
            name: name.to_string(),
            schema_name: "foxglove.PoseInFrame".to_string(),
            schema: schema.clone(),
        })
        .to_vec()
}

/// A server, with time that the test makes pass.
struct Bench {
    server: LiveServer,
    now: Duration,
    sent: u64,
}

impl Bench {
    fn start() -> Self {
        let any = SocketAddr::from(([127, 0, 0, 1], 0));
        Self {
            server: LiveServer::bind(any, "bench", &topics()).unwrap(),
            now: Duration::ZERO,
            sent: 0,
        }
    }

    fn address(&self) -> SocketAddr {
        self.server.address().unwrap()
    }

    /// Runs the server while `client` works in a thread of its own.
    fn while_running<T: Send>(&mut self, client: impl FnOnce(SocketAddr) -> T + Send) -> T {
        let address = self.address();
        std::thread::scope(|scope| {
            let client = scope.spawn(move || client(address));
            while !client.is_finished() {
                self.server.turn(self.now);
                std::thread::yield_now();
            }
            client.join().unwrap()
        })
    }

    fn publish(&mut self, topic: usize) {
        self.sent += 1;
        let message = pose(self.sent, "world", [1.5, 0.0, -2.0], [1.0, 0.0, 0.0, 0.0]);
        let message = LiveMessage {
            topic,
            time_ns: self.sent,
            json: message.to_string().into_bytes(),
        };
        self.server.publish(message, self.now);
    }
}

fn connected(address: SocketAddr, protocol: &'static str) -> Result<Client, Error> {
    let mut request = format!("ws://{address}").into_client_request()?;
    let value = HeaderValue::from_static(protocol);
    request
        .headers_mut()
        .insert("sec-websocket-protocol", value);
    connect(request).map(|(client, response)| {
        let chosen = &response.headers()["sec-websocket-protocol"];
        assert!(protocol.contains(chosen.to_str().unwrap()));
        client
    })
}

fn text(client: &mut Client) -> Value {
    match client.read().unwrap() {
        Message::Text(text) => serde_json::from_str(&text).unwrap(),
        other => panic!("{other:?}"),
    }
}

fn subscribe(client: &mut Client, subscription: u32, topic: u64) {
    let request =
        json!({ "op": "subscribe", "subscriptions": [{ "id": subscription, "channelId": topic }] });
    client.send(Message::text(request.to_string())).unwrap();
}

/// Subscription, time and object of a binary message.
fn data(client: &mut Client) -> (u32, u64, Value) {
    match client.read().unwrap() {
        Message::Binary(bytes) => {
            assert_eq!(bytes[0], 1);
            (
                u32::from_le_bytes(bytes[1..5].try_into().unwrap()),
                u64::from_le_bytes(bytes[5..13].try_into().unwrap()),
                serde_json::from_slice(&bytes[13..]).unwrap(),
            )
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn prop_a_client_gets_the_topics_that_it_subscribes_to() {
    for protocol in ["foxglove.sdk.v1", "other, foxglove.websocket.v1"] {
        let mut bench = Bench::start();
        // The newest message of before comes first.
        bench.publish(1);
        let mut client = bench.while_running(|address| {
            let mut client = connected(address, protocol).unwrap();
            assert_eq!(text(&mut client)["op"], "serverInfo");
            let advertised = text(&mut client);
            assert_eq!(advertised["op"], "advertise");
            let channel = &advertised["channels"][1];
            assert_eq!(channel["topic"], "/deck/pose");
            assert_eq!(channel["encoding"], "json");
            assert_eq!(channel["schemaEncoding"], "jsonschema");
            let schema: Value = serde_json::from_str(channel["schema"].as_str().unwrap()).unwrap();
            assert_eq!(schema["properties"]["pose"]["type"], "object");
            subscribe(&mut client, 77, 1);
            let (subscription, time_ns, message) = data(&mut client);
            assert_eq!((subscription, time_ns), (77, 1));
            assert_eq!(message["pose"]["position"]["z"], -2.0);
            client
        });
        bench.publish(0);
        bench.publish(1);
        let client = bench.while_running(|_| {
            // That of the other topic does not come.
            assert_eq!(data(&mut client).1, 3);
            let request = json!({ "op": "unsubscribe", "subscriptionIds": [77] });
            client.send(Message::text(request.to_string())).unwrap();
            subscribe(&mut client, 78, 0);
            assert_eq!(data(&mut client).0, 78);
            client
        });
        assert_eq!(bench.server.clients(), 1);
        drop(client);
        bench.while_running(|address| drop(TcpStream::connect(address)));
        bench.server.turn(bench.now);
        assert_eq!(bench.server.clients(), 0);
    }
}

#[test]
fn prop_a_client_that_never_reads_loses_messages_and_then_its_place() {
    let mut bench = Bench::start();
    let idle = bench.while_running(|address| {
        let mut client = connected(address, "foxglove.sdk.v1").unwrap();
        subscribe(&mut client, 1, 0);
        client
    });
    let mut reader = bench.while_running(|address| {
        let mut client = connected(address, "foxglove.sdk.v1").unwrap();
        text(&mut client);
        text(&mut client);
        subscribe(&mut client, 2, 1);
        client
    });
    // Far more than the buffers of the system: no call waits for the idle client.
    for _ in 0..60_000 {
        bench.publish(0);
        bench.server.turn(bench.now);
    }
    assert_eq!(bench.server.clients(), 2);
    bench.publish(1);
    let last = bench.while_running(|_| data(&mut reader).1);
    assert_eq!(last, bench.sent);
    bench.now += Duration::from_secs(11);
    bench.server.turn(bench.now);
    assert_eq!(bench.server.clients(), 1);
    drop(idle);
}

#[test]
fn prop_hostile_connections_are_closed_and_others_are_served() {
    let mut bench = Bench::start();
    let closed = |bytes: Vec<u8>| {
        move |address: SocketAddr| {
            let mut stream = TcpStream::connect(address).unwrap();
            let _ = stream.write_all(&bytes);
            let mut answer = Vec::new();
            let _ = stream.read_to_end(&mut answer);
            String::from_utf8_lossy(&answer).into_owned()
        }
    };
    bench.while_running(closed(b"\x00\xffrubbish\r\n\r\n".to_vec()));
    bench.while_running(closed(b"POST / HTTP/1.1\r\n\r\n".to_vec()));
    let endless = [b"GET / HTTP/1.1\r\n".to_vec(), vec![b'x'; 1 << 20]].concat();
    bench.while_running(closed(endless));
    let refused = bench.while_running(|address| connected(address, "chat").err().unwrap());
    assert!(matches!(refused, Error::Http(answer) if answer.status() == 400));
    // Requests that mean nothing are ignored; one that is too long ends the connection.
    bench.while_running(|address| {
        let mut client = connected(address, "foxglove.sdk.v1").unwrap();
        for request in ["", "[]", "{\"op\":\"subscribe\"}", "{\"op\":\"fly\"}"] {
            client.send(Message::text(request)).unwrap();
        }
        subscribe(&mut client, 1, u64::MAX);
        client.send(Message::binary(vec![9; 100])).unwrap();
        text(&mut client);
        text(&mut client);
        let _ = client.send(Message::text("x".repeat(1 << 20)));
        while client.read().is_ok() {}
    });
    // Silent connections hold their places only for the time of a handshake.
    let silent: Vec<_> = (0..20)
        .map(|_| TcpStream::connect(bench.address()).unwrap())
        .collect();
    bench.server.turn(bench.now);
    bench.now += Duration::from_secs(6);
    bench.server.turn(bench.now);
    bench.while_running(|address| {
        text(&mut connected(address, "foxglove.sdk.v1").unwrap());
    });
    drop(silent);
}
