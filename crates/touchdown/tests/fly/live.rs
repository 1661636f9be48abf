//! The live view during a flight, over real sockets.

use std::collections::BTreeMap;
use std::net::TcpStream;
use std::sync::mpsc;

use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use super::flight::{Case, PATIENCE, replay};
use crate::common::{json, python};

/// A client of the live view. It has asked for every topic.
fn watcher(address: &str) -> (WebSocket<MaybeTlsStream<TcpStream>>, Value) {
    let mut request = format!("ws://{address}").into_client_request().unwrap();
    let protocol = HeaderValue::from_static("foxglove.sdk.v1");
    let headers = request.headers_mut();
    headers.insert("sec-websocket-protocol", protocol);
    let (mut client, _) = tungstenite::connect(request).unwrap();
    let mut object = || -> Value {
        let text = client.read().unwrap().into_text().unwrap();
        serde_json::from_str(&text).unwrap()
    };
    assert_eq!(object()["op"], "serverInfo");
    let channels = object()["channels"].clone();
    let of =
        |channel: &Value| serde_json::json!({ "id": channel["id"], "channelId": channel["id"] });
    let all: Vec<_> = channels.as_array().unwrap().iter().map(of).collect();
    let subscribe = serde_json::json!({ "op": "subscribe", "subscriptions": all });
    client.send(Message::text(subscribe.to_string())).unwrap();
    (client, channels)
}

/// Messages by topic until the flight has ended.
fn watched(address: &str) -> BTreeMap<String, Vec<Value>> {
    let (mut client, channels) = watcher(address);
    let mut messages: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    while let Ok(Message::Binary(bytes)) = client.read() {
        let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap()) as usize;
        let topic = channels[id]["topic"].as_str().unwrap().to_string();
        let message = serde_json::from_slice(&bytes[13..]).unwrap();
        messages.entry(topic).or_default().push(message);
    }
    messages
}

#[test]
fn prop_a_flight_is_watched_live_and_a_watcher_that_never_reads_does_not_disturb_it() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (lines, printed) = mpsc::channel();
    let case = Case {
        ours: &["--live=127.0.0.1:0"],
        lines: Some(&lines),
        ..Case::default()
    };
    let (flown, seen) = std::thread::scope(|scope| {
        let flown = scope.spawn(|| case.fly(&python, folder.path()));
        let bound = |line: String| Some(line.split_once("ws://")?.1.to_string());
        let mut next = std::iter::from_fn(|| printed.recv_timeout(PATIENCE).ok());
        let address = next.find_map(bound).unwrap();
        let seen = scope.spawn({
            let address = address.clone();
            move || watched(&address)
        });
        let idle = watcher(&address);
        let flown = flown.join().unwrap();
        drop(idle);
        (flown, seen.join().unwrap())
    });
    flown.landed();
    for topic in [
        "/mavlink/attitude",
        "/mavlink/setpoint",
        "/tf",
        "/vehicle/pose",
        "/deck/pose",
        "/estimate",
        "/deck/estimate",
        "/command",
        "/checklist",
    ] {
        assert!(seen.contains_key(topic), "{topic}: {:?}", seen.keys());
    }
    let values = |topic: &str, key: &str| -> Vec<Value> {
        let mut values: Vec<_> = seen[topic].iter().map(|m| m[key].clone()).collect();
        values.dedup();
        values
    };
    assert!(values("/stage", "stage").contains(&serde_json::json!("in_control")));
    assert!(values("/phase", "phase").contains(&serde_json::json!("descend")));
    assert_eq!(
        seen["/checklist"].last().unwrap()["items"][0]["verdict"],
        "good"
    );
    // The recording has the same topics, and is replayed as any other.
    let inspected = json(
        0,
        [
            "inspect".into(),
            folder.path().join("flight.mcap").into_os_string(),
        ],
    );
    assert!(
        inspected.to_string().contains("vehicle/pose"),
        "{inspected:#}"
    );
    assert_eq!(replay(folder.path())["difference"], Value::Null);
}
