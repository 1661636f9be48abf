//! What real autopilots sent, read as pymavlink reads it, and whole conversations, replayed: bit for bit.
//!
//! `recordings/make.py` cut the bytes from flights under `touchdown simulator`, and says how to make new ones.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mavlink::Message as _;
use mavlink::dialects::common::MavMessage;
use touchdown_link::companion::{Companion, Event};
use touchdown_link::recording::{Entry, Recording};
use touchdown_link::replay::replay;
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

/// Compares the messages of an autopilot with those that pymavlink reads.
fn messages_agree(name: &str) {
    let bytes = std::fs::read(recording(&format!("{name}-mavlink.bin"))).unwrap();
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
    let expected = rows(&format!("{name}-mavlink.csv"));
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

#[test]
fn xval_messages_of_both_autopilots_are_those_that_pymavlink_reads() {
    messages_agree("px4-1.17");
    messages_agree("ardupilot-4.7");
}

/// The conversation with what the companion sends now, in place of what it sent when it was recorded. It ends where the companion
/// gives control back, because the recorded vehicle follows the commands of another flight.
fn record(path: &Path, conversation: &Recording) {
    let metadata = |name: &str| {
        let bytes = std::fs::read(path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let index = summary
            .metadata_indexes
            .iter()
            .find(|index| index.name == name);
        mcap::read::metadata(&bytes, index.unwrap()).unwrap()
    };
    let metadata = metadata("flight");
    let options = mcap::WriteOptions::new()
        .use_chunks(false)
        .compression(None);
    let file = BufWriter::new(File::create(path).unwrap());
    let mut writer = options.create(file).unwrap();
    writer.write_metadata(&metadata).unwrap();
    let [received, tick, stop, sent] = ["/received", "/tick", "/stop", "/sent"].map(|topic| {
        writer
            .add_channel(0, topic, "mavlink", &BTreeMap::new())
            .unwrap()
    });
    let mut sequence = 0;
    let mut put = |channel_id, at_us: u64, bytes: &[u8]| {
        let (log_time, publish_time) = (at_us * 1000, at_us * 1000);
        sequence += 1;
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence,
            log_time,
            publish_time,
        };
        writer.write_to_known_channel(&header, bytes).unwrap();
    };
    let session = conversation.session(None).unwrap();
    let mut companion = Companion::new(&conversation.settings, &session).unwrap();
    for (at_us, entry) in &conversation.entries {
        let (channel, event, bytes): (_, _, &[u8]) = match entry {
            Entry::Received(bytes) => (received, Event::Received(bytes), bytes),
            Entry::Tick => (tick, Event::Tick, &[]),
            Entry::Stop => (stop, Event::Stop, &[]),
            // No camera of its own took part.
            Entry::Sent(_) | Entry::Camera(_) => continue,
        };
        let mut out = Vec::new();
        companion.handle(*at_us, event, &mut out);
        if companion.ending().is_some() {
            break;
        }
        put(channel, *at_us, bytes);
        if !out.is_empty() {
            put(sent, *at_us, &out);
        }
    }
    writer.finish().unwrap();
}

#[test]
fn regress_real_conversations_until_control_is_given_back_are_replayed_bit_for_bit() {
    // Checklist, switch and as many setpoints of a landing at 100 Hz as the two flights have in common. In PX4's the pilot switches
    // before the weight is measured in the air, in ArduPilot's after it.
    for (name, least) in [("px4-1.17", 100), ("ardupilot-4.7", 250)] {
        let path = recording(&format!("{name}-flight.mcap"));
        let conversation = Recording::read(&path).unwrap();
        if std::env::var_os("TOUCHDOWN_RECORD").is_some() {
            record(&path, &conversation);
            continue;
        }
        let again = replay(&conversation, None).unwrap();
        assert_eq!(again.difference, None, "{name}");
        assert!(!again.cut_off);
        assert!(
            again.flight.setpoints > least,
            "{name}: {}",
            again.flight.setpoints
        );
        assert!(
            again.flight.ending.is_none(),
            "{name}: {:?}",
            again.flight.ending
        );
    }
}
