//! What real autopilots sent, read as pymavlink reads it: bit for bit.
//!
//! `recordings/make.py` cut the bytes from flights under `touchdown simulator`.

use std::path::{Path, PathBuf};

use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;
use touchdown_link::simulator::px4::Px4Codec;
use touchdown_link::wire::Decoder;

fn recording(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/recordings")
        .join(name)
}

/// The rows of a table below its header.
fn rows(name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(recording(name)).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_string).collect();
    text.lines().skip(1).map(cells).collect()
}

/// Pieces of uneven sizes, as a network delivers them.
fn pieces(bytes: &[u8]) -> Vec<&[u8]> {
    let (mut rest, mut pieces, mut size) = (bytes, Vec::new(), 1);
    while !rest.is_empty() {
        let (piece, after) = rest.split_at(size.min(rest.len()));
        pieces.push(piece);
        rest = after;
        size = 1 + (size * 7 + 3) % 300;
    }
    pieces
}

#[test]
fn xval_px4s_motor_signals_are_those_that_pymavlink_reads() {
    let bytes = std::fs::read(recording("px4-1.17-simulator.bin")).unwrap();
    let mut codec = Px4Codec::default();
    let mut found = Vec::new();
    for piece in pieces(&bytes) {
        codec.push(piece);
        while let Some(answer) = codec.answer() {
            // Front left, rear left, rear right, front right: motors 3, 2, 4 and 1 of PX4.
            let [front_left, rear_left, rear_right, front_right] = answer.motors.0;
            let motors = [front_right, rear_left, front_left, rear_right];
            let mut row = vec![answer.time_us.to_string()];
            row.extend(motors.map(|s| (s as f32).to_bits().to_string()));
            found.push(row);
        }
    }
    assert_eq!(found, rows("px4-1.17-simulator.csv"));
    // The cut may hurt two frames at most.
    assert!(codec.counts().corrupt <= 2, "{:?}", codec.counts());
    let flying = found.iter().filter(|row| row[1] != "0").count();
    assert!(flying > 300, "{flying} samples with turning motors");
}

#[test]
fn xval_px4s_messages_are_those_that_pymavlink_reads() {
    let bytes = std::fs::read(recording("px4-1.17-mavlink.bin")).unwrap();
    let mut decoder = Decoder::default();
    let mut found = Vec::new();
    for piece in pieces(&bytes) {
        decoder.push(piece);
        while let Some(frame) = decoder.next_frame() {
            let mut row = vec![
                frame.message.message_id().to_string(),
                frame.system.to_string(),
                frame.component.to_string(),
            ];
            row.extend(match &frame.message {
                MavMessage::ATTITUDE_QUATERNION(q) => {
                    [q.q1, q.q2, q.q3, q.q4].map(|c| c.to_bits().to_string())
                }
                _ => Default::default(),
            });
            found.push(row);
        }
    }
    let expected = rows("px4-1.17-mavlink.csv");
    // The two libraries know different sets of messages: those that both know agree, in their order.
    let known: std::collections::BTreeSet<_> = found.iter().map(|row| row[0].clone()).collect();
    let also: std::collections::BTreeSet<_> = expected.iter().map(|row| row[0].clone()).collect();
    found.retain(|row| also.contains(&row[0]));
    let expected: Vec<_> = expected
        .into_iter()
        .filter(|row| known.contains(&row[0]))
        .collect();
    assert!(expected.len() > 1000, "{} messages", expected.len());
    assert_eq!(found, expected);
}
